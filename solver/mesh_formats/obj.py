"""Wavefront OBJ: positions, faces and vertex colours; everything else is left aside.

Texture coordinates and normals have their own indices in a face's corners. Only the first index,
the position's, is read, so a vertex here is a ``v`` line, whatever seams the texture has. Read here
and not by trimesh 5.2, which repeats vertices along seams and for every material, takes index 0
and negative indices for other vertices than are meant, and drops faces that are cut off.
"""

import re

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.errors import MeshError
from solver.mesh_formats.contents import colors_in_unit_range, polygon_contents
from solver.mesh_formats.text import decode, float_table, last_line_note
from solver.repair.soup import TriangleSoup

_OTHER_INDICES = re.compile(r"/\S*")


def read_obj(data: bytes) -> TriangleSoup:
    """Read a Wavefront OBJ file.

    Parameters
    ----------
    data
        Bytes of the file.

    Returns
    -------
    TriangleSoup
        Vertices are the ``v`` lines in the order of the file.

    Raises
    ------
    MeshError
        The bytes are not a complete OBJ file.
    """
    text = decode(data)
    positions: list[str] = []
    faces: list[list[str]] = []
    known: list[int] = []  # number of v lines before each face: negative indices count from there
    for line in re.sub(r"\\\r?\n", " ", text).splitlines():
        keyword, rest = [*line.split(maxsplit=1), "", ""][:2]
        if keyword == "v":
            positions.append(rest.partition("#")[0])
        elif keyword == "f":
            faces.append(_OTHER_INDICES.sub("", rest.partition("#")[0]).split())
            known.append(len(positions))
    if not positions:
        raise MeshError("not an OBJ file, or one without vertices: it has no line beginning with v")
    vertices, colors = _vertices(positions)
    sizes = np.array([len(corners) for corners in faces], dtype=np.int64)
    return polygon_contents(
        vertices, sizes, _corners(faces, sizes, known), colors, last_line_note(text)
    )


def _vertices(lines: list[str]) -> tuple[FloatArray, FloatArray | None]:
    table = float_table(lines, "vertex")
    columns = table.shape[1]
    if columns < 3:
        raise MeshError("a vertex line of the OBJ file has fewer than three coordinates")
    colors = None
    if columns in (6, 7):  # x y z r g b, an extension most programs know
        colors = colors_in_unit_range(np.ascontiguousarray(table[:, 3:6]))
    return np.ascontiguousarray(table[:, :3]), colors


def _corners(faces: list[list[str]], sizes: IntArray, known: list[int]) -> IntArray:
    """Vertex indices from 0 out of OBJ's, which start at 1 or count back from -1."""
    try:
        written = np.array([int(corner) for face in faces for corner in face], dtype=np.int64)
    except (ValueError, OverflowError) as error:
        raise MeshError(f"a face line of the OBJ file cannot be read: {error}") from error
    if (written == 0).any():
        raise MeshError(
            "a face of the OBJ file refers to vertex 0, but OBJ counts from 1; "
            "the program that wrote the file counted from 0"
        )
    before = np.repeat(np.array(known, dtype=np.int64), sizes)
    return np.where(written > 0, written - 1, before + written)
