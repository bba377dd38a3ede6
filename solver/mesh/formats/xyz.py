"""Point clouds as text: a line of numbers for each point, as .xyz, .txt and .csv.

There is no standard. Columns are separated by white space, commas or semicolons: the coordinates,
then a normal or a colour, then anything. A first line that is not of numbers is a header; one with
a single number, as in .pts, is the number of points.
"""

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.errors import MeshError
from solver.mesh.formats.contents import colors_in_unit_range
from solver.mesh.formats.text import decode, float_table, last_line_note
from solver.mesh.repair import TriangleSoup

_COMMENTS = "#", "//"

_UNIT = 0.01
"""Error of the length of a normal in a file: columns four to six are normals if all have it."""

_SEPARATORS = str.maketrans(",;\t", "   ")


def read_xyz(data: bytes) -> TriangleSoup:
    """Read a point cloud from text.

    Parameters
    ----------
    data
        Bytes of the file.

    Returns
    -------
    TriangleSoup
        Without faces; with normals or colours if columns four to six are that.

    Raises
    ------
    MeshError
        A line is not of numbers, lines differ in length or have fewer than three numbers, or there
        are fewer than the first line promises.
    """
    text = decode(data)
    stripped = (line.translate(_SEPARATORS).strip() for line in text.splitlines())
    lines = [line for line in stripped if line and not line.startswith(_COMMENTS)]
    promised = None
    if lines and lines[0].isdigit():
        promised, lines = int(lines[0]), lines[1:]
    elif lines and not _is_of_numbers(lines[0]):
        lines = lines[1:]
    if not lines:
        raise MeshError("the file has no points")
    if promised is not None and promised != len(lines):
        raise MeshError(
            f"the file promises {promised} points and has {len(lines)}; it is cut off or damaged"
        )
    table = float_table(lines, "point")
    if table.shape[1] < 3:
        raise MeshError(f"a point has {table.shape[1]} numbers; x, y and z are needed")
    extra = np.ascontiguousarray(table[:, 3:6])
    normals = colors = None
    if extra.shape[1] == 3:
        normals = extra if _are_normals(extra) else None
        colors = None if normals is not None else colors_in_unit_range(extra)
    faces: IntArray = np.zeros((0, 3), dtype=np.int64)
    ids = np.arange(len(table), dtype=np.int64)
    notes = tuple(note.replace("face", "point") for note in last_line_note(text))
    return TriangleSoup(
        np.ascontiguousarray(table[:, :3]),
        faces,
        colors,
        ids,
        None,
        notes,
        normals=normals,
        is_cloud=True,
    )


def _is_of_numbers(line: str) -> bool:
    try:
        np.array(line.split(), dtype=np.float64)
    except ValueError:
        return False
    return True


def _are_normals(columns: FloatArray) -> bool:
    lengths = np.linalg.norm(columns, axis=1)
    return bool((np.abs(lengths - 1.0) <= _UNIT).all())
