"""Stereolithography (STL), binary and text: a soup of triangles whose vertices are merged."""

import re

import numpy as np

from solver.arrays import FloatArray
from solver.errors import MeshError
from solver.mesh_formats.contents import FileContents, merge_coincident
from solver.mesh_formats.text import decode, float_table

_HEADER_BYTES = 84
_RECORD = np.dtype(
    [("normal", "<f4", (3,)), ("corners", "<f4", (3, 3)), ("attribute", "<u2")], align=False
)
_VERTEX = re.compile(r"^\s*vertex\s+(.*)$", re.MULTILINE | re.IGNORECASE)
_FACET = re.compile(r"^\s*facet\b", re.MULTILINE | re.IGNORECASE)
_END_OF_FACET = re.compile(r"^\s*endfacet\b", re.MULTILINE | re.IGNORECASE)
_SOLID = re.compile(r"^\s*solid\b", re.MULTILINE | re.IGNORECASE)
_END_OF_SOLID = re.compile(r"^\s*endsolid\b", re.MULTILINE | re.IGNORECASE)


def read_stl(data: bytes) -> FileContents:
    """Read an STL file.

    Parameters
    ----------
    data
        Bytes of the file.

    Returns
    -------
    FileContents
        Vertices of equal position merged, in the order in which the file first names them; since
        STL has no vertex numbers, `vertex_ids` number the merged vertices.

    Raises
    ------
    MeshError
        The bytes are not a complete STL file.
    """
    triangles = _binary(data) if _is_binary(data) else _text(data)
    soup = FileContents(
        triangles.reshape(-1, 3),
        np.arange(3 * len(triangles), dtype=np.int64).reshape(-1, 3),
        None,
        np.arange(3 * len(triangles), dtype=np.int64),
    )
    merged = merge_coincident(soup, "STL stores every triangle by itself")
    ids = np.arange(len(merged.vertices), dtype=np.int64)
    notes = (*merged.notes, "vertices are numbered in the order in which the STL file names them")
    return FileContents(merged.vertices, merged.faces, None, ids, notes)


def _is_binary(data: bytes) -> bool:
    """Text files begin with "solid", but so do some binary ones: their length gives them away."""
    if len(data) >= _HEADER_BYTES and len(data) == _expected_bytes(data):
        return True
    return not (data[:512].lstrip()[:5].lower() == b"solid" and b"\0" not in data)


def _expected_bytes(data: bytes) -> int:
    return _HEADER_BYTES + int.from_bytes(data[80:84], "little") * _RECORD.itemsize


def _binary(data: bytes) -> FloatArray:
    if len(data) < _HEADER_BYTES:
        raise MeshError("not an STL file: too short for a binary one, and no text one either")
    if len(data) != _expected_bytes(data):
        raise MeshError(
            f"the STL file promises {_expected_bytes(data)} bytes and has {len(data)}; "
            "it is cut off, damaged, or not an STL file"
        )
    records = np.frombuffer(data, dtype=_RECORD, offset=_HEADER_BYTES)
    return records["corners"].astype(np.float64)


def _text(data: bytes) -> FloatArray:
    text = decode(data)
    vertices = _VERTEX.findall(text)
    facets = len(_FACET.findall(text))
    complete = len(_END_OF_FACET.findall(text)) == facets and len(vertices) == 3 * facets
    if not complete or len(_SOLID.findall(text)) != len(_END_OF_SOLID.findall(text)):
        raise MeshError(
            f"the STL file has {facets} facets and {len(vertices)} vertices, or no endsolid; "
            "it is cut off or damaged"
        )
    table = float_table(vertices, "vertex")
    if facets and table.shape[1] != 3:
        raise MeshError("a vertex of the STL file does not have three coordinates")
    return table.reshape(-1, 3, 3)
