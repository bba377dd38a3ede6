"""Point clouds as text: a line of numbers for each point, as .xyz, .txt and .csv.

There is no standard. Columns are separated by white space, commas or semicolons; where white space
or semicolons separate them, commas are decimal commas. A first line that is not of numbers is a
header; one with a single number, as in .pts, is the number of points. If the header or a comment
names x, y and z, columns are found by name. Else the coordinates come first, then a normal or a
colour; of seven columns that are no normals the last three are the colour, after the intensity, as
in .pts. Of more columns, the values say where normals and colours are, or the file is refused.
"""

import re
from collections.abc import Sequence
from typing import Final

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.errors import MeshError
from solver.mesh.formats.contents import colors_in_unit_range
from solver.mesh.formats.text import decode, float_table, last_line_note, lines_of
from solver.mesh.repair import TriangleSoup

_COMMENTS: Final = "#", "//"

_UNIT: Final = 0.01
"""Error of the length of a normal in a file: columns four to six are normals if all have it."""

_WITH_INTENSITY: Final = 7
"""Columns of .pts: coordinates, intensity and colour."""

_PTS: Final = "icn"
_ORDERS: Final = {6: ("nc", "cn"), 7: ("inc", _PTS, "nic", "cin", "nci", "cni")}
"""Orders of a normal, a colour and the intensity after the coordinates, by their columns; that of
.pts, whose first line is the number of points."""

_SEPARATORS: Final = str.maketrans(",;\t", "   ")
_DECIMAL_COMMAS: Final = str.maketrans(",;\t", ".  ")

_NOT_BY_COMMAS: Final = re.compile(r";|[^\s,][^\S\n]+[^\s,]")
"""A semicolon, or white space that is not beside a comma."""

_NO_DECIMAL_COMMA: Final = re.compile(r"(?<!\d),|,(?!\d)|,[^\s;,.]*[.,]|\.[^\s;,.]*,")
"""A comma that is not between digits, or has another comma or a point in its number."""

_COUNT: Final = re.compile(r"[0-9]{1,18}")
"""Python refuses to read very many digits, and superscripts, which are digits to `str.isdigit`."""

_AXES: Final = "x", "y", "z"
_NORMALS: Final = ("nx", "ny", "nz"), ("normalx", "normaly", "normalz")
_CHANNELS: Final = ("r", "g", "b"), ("red", "green", "blue")

_BRACKETS: Final = re.compile(r"[\[(][^\[\]()]*[\])]")
"""A unit after the name of a column."""

_UNNAMED: Final = (
    "the first line is no point, and does not name columns x, y and z: the first three numbers of"
    " each line were taken for them"
)


def read_xyz(data: bytes) -> TriangleSoup:
    """Read a point cloud from text.

    Parameters
    ----------
    data
        Bytes of the file.

    Returns
    -------
    TriangleSoup
        Without faces; with normals or colours if columns have their names, or, where columns have
        no names, if columns four to six are that; of seven columns, the last three are colours; of
        nine or ten, both are found by their values.

    Raises
    ------
    MeshError
        A line is not of numbers, lines differ in length or have fewer than three numbers, there
        are fewer than the first line promises, not as many columns as the header names, or more
        than seven whose values do not say what they are.
    """
    text = decode(data)
    lines = [line.strip() for line in lines_of(text) if line.translate(_SEPARATORS).strip()]
    comments = [line for line in lines if line.startswith(_COMMENTS)]
    lines = [line for line in lines if not line.startswith(_COMMENTS)]
    first = lines[0].translate(_SEPARATORS).strip() if lines else ""
    promised = int(first) if _COUNT.fullmatch(first) else None
    header = lines[0] if lines and promised is None and _is_header(first, lines[1:2]) else ""
    lines = lines[1:] if header or promised is not None else lines
    if not lines:
        raise MeshError("the file has no points")
    if promised is not None and promised != len(lines):
        raise MeshError(
            f"the file promises {promised} points and has {len(lines)}; it is cut off or damaged"
        )
    table = float_table(_separated_by_blanks(lines), "point")
    if table.shape[1] < 3:
        raise MeshError(f"a point has {table.shape[1]} numbers; x, y and z are needed")
    names = _names(header, comments, table.shape[1])
    normals, colors = (
        _named_extras(table, names) if names else _unnamed_extras(table, promised is not None)
    )
    columns = [names.index(axis) for axis in _AXES] if names else [0, 1, 2]
    notes = tuple(note.replace("face", "point") for note in last_line_note(text))
    faces: IntArray = np.zeros((0, 3), dtype=np.int64)
    return TriangleSoup(
        np.ascontiguousarray(table[:, columns]),
        faces,
        colors,
        np.arange(len(table), dtype=np.int64),
        None,
        (_UNNAMED, *notes) if header and not names else notes,
        normals=normals,
        is_cloud=True,
    )


def _is_header(first: str, second: Sequence[str]) -> bool:
    """Return whether a first line is no point, nor one with a word that is no number: 1 2 three."""
    words = first.split()
    numbers = sum(map(_is_number, words))
    wide = [len(line.translate(_SEPARATORS).split()) for line in second]
    return numbers == 0 or (numbers < len(words) and wide != [len(words)])


def _is_number(word: str) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return True


def _separated_by_blanks(lines: Sequence[str]) -> list[str]:
    """Lines with blanks between numbers, and with decimal points."""
    text = "\n".join(lines)
    if "," not in text or not _NOT_BY_COMMAS.search(text):
        return text.translate(_SEPARATORS).split("\n")
    wrong = _NO_DECIMAL_COMMA.search(text)
    if wrong:
        line = text.count("\n", 0, wrong.start())
        raise MeshError(
            "blanks or semicolons separate numbers, so that commas are decimal commas; those of"
            f" point {line}, {lines[line][:60]!r}, are not: use one separator in all lines"
        )
    return text.translate(_DECIMAL_COMMAS).split("\n")


def _names(header: str, comments: Sequence[str], count: int) -> list[str]:
    """Names of so many columns, in lower case; empty if x, y and z are not named once each."""
    for line in (header, *comments):
        bare = _BRACKETS.sub("", line.lstrip("#/")).rstrip(" ,;\t")
        separator = next((one for one in ";\t," if one in bare), None)
        names = [name.strip(" \"'").lower() for name in bare.split(separator)]
        if any(names.count(axis) != 1 for axis in _AXES):
            continue
        if len(names) == count:
            return names
        if line == header:
            raise MeshError(f"the header names {len(names)} columns, but a point has {count}")
    return []


def _named_extras(
    table: FloatArray, names: Sequence[str]
) -> tuple[FloatArray | None, FloatArray | None]:
    """(V, 3) normals and colours of columns with their names."""
    normals, colors = (
        next(
            (table[:, [names.index(one) for one in axes]] for axes in known if {*axes} <= {*names}),
            None,
        )
        for known in (_NORMALS, _CHANNELS)
    )
    return normals, None if colors is None else colors_in_unit_range(colors)


def _unnamed_extras(
    table: FloatArray, counted: bool
) -> tuple[FloatArray | None, FloatArray | None]:
    """(V, 3) normals or colours, if the columns after the coordinates are that."""
    if table.shape[1] > _WITH_INTENSITY:
        return _ordered_extras(table[:, 3:], counted)
    extra = np.ascontiguousarray(table[:, 3:6])
    if extra.shape[1] < 3:
        return None, None
    if _are_normals(extra):
        return extra, None
    if table.shape[1] == _WITH_INTENSITY:
        extra = np.ascontiguousarray(table[:, 4:])
    return None, colors_in_unit_range(extra)


def _ordered_extras(
    extra: FloatArray, counted: bool
) -> tuple[FloatArray | None, FloatArray | None]:
    """(V, 3) normals and colours, in the only order that the values of (V, k) columns allow.

    Where the first line counts the points, it is that of .pts, if this is allowed.

    Raises
    ------
    MeshError
        None or several do, and the first three columns are no normals.
    """
    found = {}
    for order in _ORDERS.get(extra.shape[1], ()):
        normals, colors = (_three_columns(extra, order, what) for what in "nc")
        if _are_normals(normals) and _are_colors(colors):
            found[order] = normals, colors
    if counted and _PTS in found:
        found = {_PTS: found[_PTS]}
    if len(found) == 1:
        ((normals, colors),) = found.values()
        return normals, colors_in_unit_range(colors)
    if not found and _are_normals(extra[:, :3]):
        return np.ascontiguousarray(extra[:, :3]), None
    raise MeshError(
        f"a point has {extra.shape[1] + 3} numbers, and their values do not say what they are:"
        " expected x y z, then a normal of length 1 (nx ny nz) and a colour (r g b, whole numbers"
        " up to 255 or numbers up to 1) in either order, with an intensity or without one; name"
        " the columns in the first line, as in x y z nx ny nz r g b"
    )


def _three_columns(extra: FloatArray, order: str, what: str) -> FloatArray:
    """(V, 3) the normal ("n") or colour ("c") of columns in an order."""
    start = sum(1 if one == "i" else 3 for one in order[: order.index(what)])
    return np.ascontiguousarray(extra[:, start : start + 3])


def _are_normals(table: FloatArray) -> bool:
    with np.errstate(over="ignore"):
        return bool((np.abs(np.linalg.norm(table, axis=1) - 1.0) <= _UNIT).all())


def _are_colors(table: FloatArray) -> bool:
    """Return whether columns are in 0..1, or whole numbers in 0..255."""
    most = 1.0 if (table <= 1.0).all() else 255.0
    whole = most == 1.0 or (table == np.rint(table)).all()
    return bool(whole and ((table >= 0.0) & (table <= most)).all())
