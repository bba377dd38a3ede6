"""PLY files with attributes of the vertices and of the faces."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from solver.errors import MeshError, TransferError
from solver.mesh.formats import PlyColumns, ply_columns
from solver.transfer.attributes import Attribute
from solver.transfer.files.columns import CHANNELS, from_columns, to_columns
from solver.transfer.files.names import renamed
from solver.transfer.files.ply_legends import Legends, labels_in_words
from solver.transfer.files.surface import WrittenSurface
from solver.transfer.overlap import FACES, VERTICES

_PLACES: Final = ("x", "y", "z", "nx", "ny", "nz")
_CORNERS: Final = "vertex_indices"
_RESERVED: Final = frozenset((*_PLACES, "count", _CORNERS, "vertex_index"))
"""Names of geometry, in this format and in the table of faces: attributes get others."""
_TYPES: Final = {"u1": "uchar", "i4": "int", "f8": "double"}

_WHOLE: Final = 2**53
"""Whole numbers up to this are exact in double precision."""


def read_ply_attributes(data: bytes) -> list[Attribute]:
    """Read the properties of vertices and faces, but for positions and normals.

    Numbers that all have a text by comments, as :func:`write_ply` writes them, become text. Of a
    name that both have, those of the vertices are read.

    Raises
    ------
    TransferError
        The bytes are not a complete PLY file.
    """
    try:
        elements = ply_columns(data)
    except MeshError as error:
        raise TransferError(str(error)) from error
    found: dict[str, Attribute] = {}
    for on, element in ((VERTICES, "vertex"), (FACES, "face")):
        own = _attributes(elements[element])
        found = {one.name: replace(one, on=on) for one in own} | found
    return list(found.values())


def _attributes(element: PlyColumns) -> list[Attribute]:
    columns: dict[str, npt.NDArray[Any]] = {
        name: values for name, values in element.numbers.items() if name not in _PLACES
    }
    columns |= labels_in_words(columns, element.comments)
    colors = () if element.colors is None else element.colors.T
    columns |= dict(zip(CHANNELS, colors, strict=False))
    # Numbers that are no colours are still numbers.
    others = [name for name in CHANNELS[len(colors) :] if name in columns]
    alone = [Attribute(name, columns.pop(name)) for name in others]
    return from_columns(columns) + alone


def write_ply(surface: WrittenSurface) -> bytes:
    """Return a surface as little-endian binary PLY.

    Colours are bytes. Text becomes numbers, and comments of the form ``label NAME NUMBER TEXT``
    after the element say which, unless they are too long for a header. An attribute that is called
    as geometry is gets another name (:func:`.renamed`).

    Raises
    ------
    TransferError
        Whole numbers are too large for PLY.
    """
    legends = Legends()
    (vertex, of_vertices), (face, of_faces) = (
        _columns([one for one in surface.attributes if (one.on == FACES) == on_faces], legends)
        for on_faces in (False, True)
    )
    position = [(axis, "<f8") for axis in "xyz"]
    table = np.empty(len(surface.vertices), dtype=[*position, *_fields(vertex)])
    for axis, values in zip("xyz", surface.vertices.T, strict=True):
        table[axis] = values
    corners = [("count", "u1"), (_CORNERS, "<i4", (3,))]
    faces = np.empty(len(surface.faces), dtype=[*corners, *_fields(face)])
    faces["count"], faces[_CORNERS] = 3, surface.faces
    for rows, columns in ((table, vertex), (faces, face)):
        for name, values in columns.items():
            rows[name] = values
    header = [
        "ply",
        "format binary_little_endian 1.0",
        f"element vertex {len(table)}",
        *of_vertices,
        *(f"property double {axis}" for axis in "xyz"),
        *_properties(vertex),
        f"element face {len(faces)}",
        *of_faces,
        f"property list uchar int {_CORNERS}",
        *_properties(face),
        "end_header\n",
    ]
    return "\n".join(header).encode() + table.tobytes() + faces.tobytes()


def _columns(
    attributes: Sequence[Attribute], legends: Legends
) -> tuple[dict[str, npt.NDArray[Any]], list[str]]:
    """Values by the name of their property, and comments for text."""
    columns: dict[str, npt.NDArray[Any]] = {}
    comments: list[str] = []
    for written, values in renamed(to_columns(attributes), _RESERVED, _spelling).items():
        if values.dtype.kind == "U":
            texts, values = np.unique(values, return_inverse=True)
            comments += legends.comments(written, texts.tolist())
        columns[written] = _stored(written, values)
    return columns, comments


def _spelling(name: str) -> str:
    """Return a name as a word of ASCII, as those of properties are."""
    return "_".join(name.split()).encode("ascii", errors="replace").decode("ascii")


def _fields(columns: Mapping[str, npt.NDArray[Any]]) -> list[tuple[str, np.dtype[Any]]]:
    return [(name, one.dtype) for name, one in columns.items()]


def _properties(columns: Mapping[str, npt.NDArray[Any]]) -> list[str]:
    return [f"property {_type(one.dtype)} {name}" for name, one in columns.items()]


def _stored(name: str, values: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Values in a type of PLY: bytes, whole numbers of 32 bits, or double precision."""
    if values.dtype == np.uint8:
        return values
    if values.dtype.kind == "i":
        least, greatest = int(values.min(initial=0)), int(values.max(initial=0))
        limits = np.iinfo(np.int32)
        if limits.min <= least and greatest <= limits.max:
            return values.astype("<i4")
        if max(-least, greatest) > _WHOLE:
            raise TransferError(
                f"PLY cannot hold {name[:40]!r}, which has numbers beyond 2^53; choose CSV or NPZ"
            )
    return values.astype("<f8")


def _type(kind: np.dtype[Any]) -> str:
    return _TYPES[kind.str.lstrip("<|")]
