"""Polygon File Format (PLY): text and binary, either byte order, polygons of any mix of sizes.

The header declares *elements* (``vertex``, ``face``, ...) of so many rows, and the properties of a
row in order: a number, or a list preceded by its length.
"""

import codecs
import re
from dataclasses import dataclass, replace

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.errors import MeshError
from solver.mesh.formats.contents import colors_in_unit_range, polygon_contents
from solver.mesh.formats.ply_data import (
    Columns,
    Element,
    Property,
    Values,
    binary_columns,
    text_columns,
)
from solver.mesh.formats.text import decode, last_line_note, lines_of
from solver.mesh.repair import TriangleSoup

_TYPES = {
    "char": "i1",
    "int8": "i1",
    "uchar": "u1",
    "uint8": "u1",
    "short": "i2",
    "int16": "i2",
    "ushort": "u2",
    "uint16": "u2",
    "int": "i4",
    "int32": "i4",
    "uint": "u4",
    "uint32": "u4",
    "int64": "i8",
    "uint64": "u8",
    "float": "f4",
    "float32": "f4",
    "double": "f8",
    "float64": "f8",
}
_GREATEST = {"u1": 255.0, "u2": 65535.0}
"""Value of full intensity in unsigned integers."""

_FACE_LISTS = ("vertex_indices", "vertex_index")
"""Names of the property that lists the corners of faces."""

_IMAGE, _PLACES_IN_IMAGE = "TextureFile", "texcoord"
"""First word of the comment that names an image, and list of texture coordinates of a face."""

_FORMATS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
_LONGEST_HEADER = 1 << 20
"""Bytes."""

_MOST_PROPERTIES = 1100
"""Every row is read property by property; files have some dozens, but may have the weights of 1,024
joints beside geometry and colours."""
_GREATEST_INTEGER = np.iinfo(np.int64).max
_TOLD_APART = 2.0**53

_COUNT = re.compile(r"[0-9]{1,100}")
_END = re.compile(rb"[\r\n]end_header")


@dataclass(frozen=True)
class _Header:
    byte_order: str  # "" for text
    elements: tuple[Element, ...]
    comments: dict[str, list[str]]  # by the element that they follow, "" before all
    size: int  # bytes, the line break after end_header included


@dataclass(frozen=True, eq=False)
class PlyColumns:
    """Values of the rows of an element.

    Parameters
    ----------
    numbers
        (n,) single numbers by property, int64 or float64.
    colors
        (n, 3) colours in 0..1, or (n, 4) with opacity; ``None`` without.
    comments
        Text of the comments that follow the element's line, and of those before all elements.
    """

    numbers: dict[str, Values]
    colors: FloatArray | None
    comments: tuple[str, ...]


def read_ply(data: bytes) -> TriangleSoup:
    """Read a PLY file.

    Parameters
    ----------
    data
        Bytes of the file.

    Returns
    -------
    TriangleSoup
        With colours if the vertices have ``red``, ``green`` and ``blue``; with normals if they have
        ``nx``, ``ny`` and ``nz``, and there are no faces.

    Raises
    ------
    MeshError
        The bytes are not a complete PLY file.
    """
    header, columns, notes = _read(data)
    if "face" not in columns and "tristrips" in columns:
        raise MeshError("PLY triangle strips are not supported; save with faces instead")
    vertex, face = columns["vertex"], columns.get("face", {})
    vertices = np.stack([_numbers(vertex, name) for name in ("x", "y", "z")], axis=1)
    sizes, corners = _polygons(face)
    of_vertices = _properties(header)["vertex"]
    colors = _colors(vertex, of_vertices)
    notes += _note_of_texture(header)
    contents = replace(
        polygon_contents(vertices, sizes, corners, colors, notes),
        fixed_point=all(of_vertices[axis].kind[0] in "iu" for axis in "xyz"),
    )
    if len(sizes):
        return contents
    if not {"nx", "ny", "nz"} <= vertex.keys():
        return replace(contents, is_cloud=True)
    normals = np.stack([_numbers(vertex, name) for name in ("nx", "ny", "nz")], axis=1)
    return replace(contents, normals=normals, is_cloud=True)


def ply_columns(data: bytes) -> dict[str, PlyColumns]:
    """Read the values of the vertices and of the faces of a PLY file.

    Parameters
    ----------
    data
        Bytes of the file.

    Returns
    -------
    By element, "vertex" and "face".

    Raises
    ------
    MeshError
        The bytes are not a complete PLY file, or values of a property of integers are none.
    """
    header, columns, _ = _read(data)
    found = {}
    for element in ("vertex", "face"):
        rows = columns.get(element, {})
        types = _properties(header)[element] if rows else {}
        numbers = {
            name: one.astype(np.float64) if types[name].kind[0] == "f" else _integers(one, name)
            for name, one in rows.items()
            if isinstance(one, np.ndarray)
        }
        comments = (*header.comments.get("", []), *header.comments.get(element, []))
        found[element] = PlyColumns(numbers, _colors_and_opacity(rows, types), comments)
    return found


def _properties(header: _Header) -> dict[str, dict[str, Property]]:
    return {element.name: element.properties for element in header.elements}


def _read(data: bytes) -> tuple[_Header, dict[str, Columns], tuple[str, ...]]:
    data = data.removeprefix(codecs.BOM_UTF8)  # text editors write it
    header = _parse_header(data)
    body = data[header.size :]
    notes: tuple[str, ...] = ()
    if header.byte_order:
        columns = binary_columns(header.elements, body, header.byte_order)
    else:
        text = decode(body)
        columns, ignored = text_columns(header.elements, text)
        notes = last_line_note(text)
        if ignored:
            notes += ("lines after the last row of the PLY file were ignored",)
    if "vertex" not in columns:
        raise MeshError("the PLY file has no vertices")
    return header, columns, notes


def _note_of_texture(header: _Header) -> tuple[str, ...]:
    """Say that a texture was not read, if the file refers to an image or has coordinates in one."""
    comments = (one.split(maxsplit=1) for group in header.comments.values() for one in group)
    images = [words[1] for words in comments if len(words) == 2 and words[0] == _IMAGE]
    if not images and _PLACES_IN_IMAGE not in _properties(header).get("face", {}):
        return ()
    said = f"the image {images[0][:100]!r}" if images else "places in an image"
    return (
        f"the file refers to {said}: textures of PLY files are not read; to include them, upload"
        " GLB, or OBJ with its material file and its images together as one .zip",
    )


def _parse_header(data: bytes) -> _Header:
    end, size = _header_end(data)
    byte_order: str | None = None
    elements: dict[str, Element] = {}
    element: Element | None = None
    properties = 0
    comments: dict[str, list[str]] = {}
    for line in lines_of(decode(data[:end]))[1:]:
        words = line.split()
        if not words or words[0] in ("comment", "obj_info"):
            after = "" if element is None else element.name
            comments.setdefault(after, []).append(line.partition(" ")[2])
            continue
        if words[0] == "format" and byte_order is not None:
            raise MeshError("the PLY header says its format twice")
        if words[0] == "format" and len(words) == 3 and words[1] in _FORMATS:
            byte_order = _FORMATS[words[1]]
        elif words[0] == "element" and len(words) == 3 and _COUNT.fullmatch(words[2]):
            element = Element(words[1], int(words[2]))
            if elements.setdefault(element.name, element) is not element:
                raise MeshError(f"the PLY header declares the element {element.name[:80]} twice")
        elif words[0] == "property" and element is not None:
            properties += 1
            if properties > _MOST_PROPERTIES:
                raise MeshError(
                    f"the PLY header declares more than {_MOST_PROPERTIES} properties; it is"
                    " damaged, or save it without what is not needed"
                )
            prop = _property(words)
            if element.properties.setdefault(words[-1], prop) is not prop:
                raise MeshError(f"the PLY header declares the property {words[-1][:80]} twice")
        else:
            raise MeshError(f"a line of the PLY header cannot be read: {line[:80]!r}")
    if byte_order is None:
        raise MeshError("the PLY header does not say its format")
    return _Header(byte_order, tuple(elements.values()), comments, size)


def _header_end(data: bytes) -> tuple[int, int]:
    """Return where the last line of the header begins, and where it ends."""
    if data[:3] != b"ply" or data[3:4] not in (b"\n", b"\r", b" "):
        raise MeshError("not a PLY file: it does not begin with the word ply")
    # A comment may have the word, too.
    last = _END.search(data, 0, _LONGEST_HEADER)
    end = last.start() + 1 if last else 0
    old = data[3:4] == b"\r" and data[4:5] != b"\n"  # lines end as on early Macintosh computers
    line_break = data.find(b"\r" if old else b"\n", end, end + 16)
    if last is None or line_break < 0:
        raise MeshError("the PLY header does not end; the file is cut off or damaged")
    return end, line_break + 1


def _property(words: list[str]) -> Property:
    try:
        if len(words) == 5 and words[1] == "list":
            length = _TYPES[words[2]]
            if length[0] == "f":
                raise KeyError(words[2])
            return Property(_TYPES[words[3]], length)
        _, kind, _ = words
        return Property(_TYPES[kind])
    except (KeyError, ValueError):
        raise MeshError(f"a PLY property cannot be read: {' '.join(words)[:80]!r}") from None


def _numbers(columns: Columns, name: str) -> FloatArray:
    values = columns.get(name)
    if not isinstance(values, np.ndarray):
        raise MeshError(f"the vertices of the PLY file have no {name}")
    return values.astype(np.float64)


def _integers(values: Values, name: str) -> IntArray:
    """(n,) values of a property of integers, which text may give with a point."""
    whole = values <= _GREATEST_INTEGER
    if values.dtype.kind == "f":
        # Text is read as float64: beyond this, integers are not told apart.
        whole = (np.abs(values) < _TOLD_APART) & (values == np.floor(values))
    if not whole.all():
        wrong = float(values[~whole][0])
        raise MeshError(
            f"the property {name[:80]} of the PLY file is declared as integers, and has the value"
            f" {wrong:g}; declare it as float or double"
        )
    return values.astype(np.int64)


def _polygons(columns: Columns) -> tuple[IntArray, IntArray]:
    if not columns:
        return np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.int64)
    lists = next((columns[name] for name in _FACE_LISTS if name in columns), None)
    if not isinstance(lists, tuple) or lists[1].dtype.kind == "f":
        raise MeshError("the faces of the PLY file have no list of integers vertex_indices")
    sizes, corners = lists
    return sizes, corners.astype(np.int64)


def _colors(rows: Columns, types: dict[str, Property]) -> FloatArray | None:
    channels = [rows.get(name) for name in ("red", "green", "blue")]
    if not all(isinstance(channel, np.ndarray) for channel in channels):
        return None
    values = np.stack([np.asarray(channel, dtype=np.float64) for channel in channels], axis=1)
    return _in_unit_range(values, types["red"])


def _colors_and_opacity(rows: Columns, types: dict[str, Property]) -> FloatArray | None:
    colors, alpha = _colors(rows, types), rows.get("alpha")
    if colors is None or not isinstance(alpha, np.ndarray):
        return colors
    opacity = _in_unit_range(alpha.astype(np.float64)[:, None], types["alpha"])
    return colors if opacity is None else np.hstack([colors, opacity])


def _in_unit_range(values: FloatArray, kind: Property) -> FloatArray | None:
    greatest = _GREATEST.get(kind.kind)
    return colors_in_unit_range(values) if greatest is None else values / greatest
