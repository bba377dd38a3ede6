"""Object File Format: OFF, with colours (COFF) or normals (NOFF) or both (CNOFF)."""

import re

import numpy as np

from solver.arrays import FloatArray
from solver.errors import MeshError
from solver.mesh.formats.contents import colors_in_unit_range, polygon_contents
from solver.mesh.formats.text import (
    check_digits,
    counted_lists,
    decode,
    float_table,
    last_line_note,
    lines_of,
)
from solver.mesh.repair import TriangleSoup

_HEADER = re.compile(r"(ST)?(C?)(N?)(4?)(n?)OFF(?![A-Za-z])\s*(.*)", re.DOTALL)


def read_off(data: bytes) -> TriangleSoup:
    """Read an OFF file.

    Parameters
    ----------
    data
        Bytes of the file.

    Returns
    -------
    TriangleSoup

    Raises
    ------
    MeshError
        The bytes are not a complete OFF file.
    """
    text = decode(data)
    lines = [line for raw in lines_of(text) if (line := raw.partition("#")[0].strip())]
    header = _HEADER.fullmatch(lines[0]) if lines else None
    if header is None:
        raise MeshError("not an OFF file: it does not begin with the word OFF")
    textured, colored, normals, homogeneous, dimension, counts = header.groups()
    if counts.upper().startswith("BINARY"):
        raise MeshError("binary OFF files are not supported; save as text OFF or as PLY")
    if textured or homogeneous or dimension:
        raise MeshError("only OFF, COFF, NOFF and CNOFF files are supported; save as OFF or PLY")
    body = lines[1:]
    if not counts:
        if not body:
            raise MeshError("the OFF file ends before its vertex and face counts")
        counts, body = body[0], body[1:]
    n_vertices, n_faces = _counts(counts)
    if len(body) < n_vertices + n_faces:
        raise MeshError(
            f"the OFF file promises {n_vertices} vertices and {n_faces} faces but has only "
            f"{len(body)} lines of them; the file is cut off or damaged"
        )
    table = float_table(body[:n_vertices], "vertex")
    if n_vertices and table.shape[1] < 3:
        raise MeshError("a vertex line of the OFF file has fewer than three coordinates")
    notes = list(last_line_note(text))
    if len(body) > n_vertices + n_faces:
        notes.append("lines after the last face of the OFF file were ignored")
    colors = _colors(table, bool(colored), bool(normals))
    sizes, corners = counted_lists(body[n_vertices : n_vertices + n_faces], "face")
    return polygon_contents(table[:, :3].reshape(-1, 3), sizes, corners, colors, notes)


def _counts(line: str) -> tuple[int, int]:
    try:
        words = line.split()[:2]
        check_digits(" ".join(words))
        n_vertices, n_faces = map(int, words)
    except ValueError:
        raise MeshError(f"the counts of the OFF file cannot be read: {line[:80]!r}") from None
    if n_vertices < 0 or n_faces < 0:
        raise MeshError("the OFF file promises a negative number of vertices or faces")
    return n_vertices, n_faces


def _colors(table: FloatArray, colored: bool, normals: bool) -> FloatArray | None:
    """Colours after position (and normal); some programs write them without declaring COFF."""
    start = 6 if normals else 3
    extra = table[:, start:]
    if extra.shape[1] < 3 or not (colored or (not normals and extra.shape[1] in (3, 4))):
        return None
    return colors_in_unit_range(np.ascontiguousarray(extra[:, :3]))
