"""Stereolithography (STL), binary and text: triangles without shared vertices, which are merged."""

import codecs

import numpy as np

from solver.arrays import FloatArray
from solver.errors import MeshError
from solver.mesh.formats.text import decode, float_table, lines_of
from solver.mesh.repair import TriangleSoup, merge_coincident

_HEADER = 84
"""Bytes before the first facet of a binary file: a comment of 80, and the number of facets."""

_RECORD = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
"""A facet of a binary file."""

_FACET = ("facet", "outer", "vertex", "vertex", "vertex", "endloop", "endfacet")
"""First words of the lines of a facet."""


def read_stl(data: bytes) -> TriangleSoup:
    """Read an STL file.

    Parameters
    ----------
    data
        Bytes of the file.

    Returns
    -------
    TriangleSoup
        Vertices in the same position merged, in the order of their first appearance; since STL has
        no vertex numbers, `vertex_ids` number the merged vertices.

    Raises
    ------
    MeshError
        The bytes are not a complete STL file.
    """
    corners = _binary_corners(data)
    if corners is None:
        data = data.removeprefix(codecs.BOM_UTF8)  # text editors write it
        if data[:512].lstrip()[:5].lower() != b"solid" or b"\0" in data:
            raise MeshError(
                "the STL file is cut off, damaged or no STL file: its length is not that of the "
                "number of facets it promises"
            )
        corners = _text_corners(data)
    number = np.arange(len(corners), dtype=np.int64)
    facets = np.arange(len(corners) // 3, dtype=np.int64)
    soup = TriangleSoup(corners, number.reshape(-1, 3), None, number, facets)
    merged = merge_coincident(soup, "STL stores every triangle by itself")
    ids = np.arange(len(merged.vertices), dtype=np.int64)
    notes = (
        *merged.notes,
        "vertices are numbered in the order of their first appearance in the STL file",
    )
    return TriangleSoup(merged.vertices, merged.faces, None, ids, merged.face_ids, notes)


def _binary_corners(data: bytes) -> FloatArray | None:
    """(3 · facets, 3) corners; ``None`` unless the file has exactly the length it promises."""
    if len(data) < _HEADER:
        return None
    facets = int.from_bytes(data[_HEADER - 4 : _HEADER], "little")
    if len(data) != _HEADER + facets * _RECORD.itemsize:
        return None
    table = np.frombuffer(data, _RECORD, facets, _HEADER)
    return table["corners"].reshape(-1, 3).astype(np.float64)


def _text_corners(data: bytes) -> FloatArray:
    """(3 · facets, 3) corners of the facets of all solids."""
    lines = [line for raw in lines_of(decode(data)) if (line := raw.strip())]
    words = [line.split(maxsplit=1)[0].lower() for line in lines]
    facets = [word for word in words if word not in ("solid", "endsolid")]
    whole = facets == [*_FACET] * (len(facets) // len(_FACET))
    if not whole or words.count("solid") != words.count("endsolid"):
        raise MeshError(
            "the text STL file has a facet without three vertices or an end, or a solid without "
            "endsolid; it is cut off or damaged"
        )
    vertices = [line for line, word in zip(lines, words, strict=True) if word == "vertex"]
    table = float_table([line[len("vertex") :] for line in vertices], "vertex")
    if vertices and table.shape[1] != 3:
        raise MeshError("a vertex of the STL file does not have three coordinates")
    return table.reshape(-1, 3)
