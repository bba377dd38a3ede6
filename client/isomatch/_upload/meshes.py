"""Whatever a user holds a mesh in, as the file that is uploaded."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO, Final, Protocol, TypeAlias, runtime_checkable

import numpy as np
import numpy.typing as npt

from isomatch._upload.arrays import checked_arrays, checked_colors


@runtime_checkable
class MeshLike(Protocol):
    """Anything with arrays of vertices and faces, such as a ``trimesh.Trimesh``."""

    @property
    def vertices(self) -> npt.ArrayLike:
        """Positions, shape (V, 3)."""

    @property
    def faces(self) -> npt.ArrayLike:
        """Vertex indices of the triangles, shape (F, 3)."""


MeshSource: TypeAlias = (
    str
    | os.PathLike[str]
    | bytes
    | BinaryIO
    | tuple[npt.ArrayLike, npt.ArrayLike]
    | tuple[npt.ArrayLike, npt.ArrayLike, npt.ArrayLike | None]
    | MeshLike
)
"""A path; a file's bytes; an open binary file; arrays (vertices, faces) or (vertices, faces,
colours); or an object with vertices and faces."""


_WHAT_A_SHAPE_IS: Final = (
    "a shape is a path, bytes, an open binary file, a tuple (vertices, faces) or (vertices, faces, "
    "colours), or an object with .vertices and .faces, not "
)


@dataclass(frozen=True)
class MeshFile:
    """A mesh file ready for upload; the extension of its name tells the format."""

    name: str
    content: bytes | BinaryIO


@contextmanager
def mesh_file(source: MeshSource, file_type: str | None = None) -> Iterator[MeshFile]:
    """Make a mesh file of `source` for as long as the context lasts.

    Parameters
    ----------
    source
        See :data:`MeshSource`. An open file is read from its beginning and is left open.
    file_type
        Format, such as ``"off"``; needed for bytes and for files without a telling name.

    Raises
    ------
    OSError
        The path cannot be read.
    TypeError
        `source` is none of the things a mesh can be given as.
    ValueError
        The format cannot be told, or arrays have the wrong shape.
    """
    extension = None if file_type is None else "." + file_type.lower().removeprefix(".")
    if isinstance(source, str | os.PathLike):
        path = Path(source)
        with path.open("rb") as file:
            yield MeshFile(_file_name(path.name, extension), file)
    elif isinstance(source, bytes | bytearray | memoryview):
        yield MeshFile(_file_name("", extension), bytes(source))
    elif isinstance(source, tuple):
        if len(source) not in (2, 3):
            raise TypeError(_WHAT_A_SHAPE_IS + f"a tuple of {len(source)}")
        yield MeshFile("mesh.ply", binary_ply(*source))
    elif isinstance(source, MeshLike):
        yield MeshFile("mesh.ply", binary_ply(source.vertices, source.faces, _colors(source)))
    elif hasattr(source, "read"):
        yield MeshFile(_file_name(name_of(source), extension), source)
    else:
        raise TypeError(_WHAT_A_SHAPE_IS + type(source).__name__)


def name_of(file: object) -> str:
    """Return the name of an open file, without its folder; empty if it has none."""
    name = getattr(file, "name", "")
    return Path(name).name if isinstance(name, str) else ""


def _file_name(name: str, extension: str | None) -> str:
    if extension is not None:
        return Path(name or "mesh").stem + extension
    if not Path(name).suffix:
        raise ValueError(
            'the format cannot be told from the name; say file_type="off", for example'
        )
    return name


def _colors(mesh: object) -> npt.ArrayLike | None:
    # Trimesh keeps colours here; of its other visuals (textures, face colours) none is per vertex.
    visual = getattr(mesh, "visual", None)
    if getattr(visual, "kind", None) != "vertex":
        return None
    colors: npt.ArrayLike | None = getattr(visual, "vertex_colors", None)
    return colors


def binary_ply(
    vertices: npt.ArrayLike, faces: npt.ArrayLike, colors: npt.ArrayLike | None = None
) -> bytes:
    """Write a triangle mesh as little-endian binary PLY, exactly and in the order given.

    Parameters
    ----------
    vertices
        Positions, shape (V, 3), kept in float64.
    faces
        Vertex indices from 0, shape (F, 3).
    colors
        RGB or RGBA of each vertex, shape (V, 3) or (V, 4), integers from 0 to 255 or floats from
        0 to 1; alpha is left out.

    Raises
    ------
    ValueError
        An array has the wrong shape or type, a coordinate of a vertex that a face names is not
        finite, a face names a vertex that is not there, or a colour is out of range.
    """
    points, triangles = checked_arrays(vertices, faces)
    fields: list[tuple[str, str, tuple[int, ...]]] = [("position", "<f8", (3,))]
    properties = [f"property double {axis}" for axis in "xyz"]
    if colors is not None:
        fields.append(("color", "u1", (3,)))
        properties += [f"property uchar {channel}" for channel in ("red", "green", "blue")]
    vertex_table = np.empty(len(points), dtype=fields)
    vertex_table["position"] = points
    if colors is not None:
        vertex_table["color"] = checked_colors(colors, len(points))
    face_table = np.empty(len(triangles), dtype=[("count", "u1"), ("corners", "<i4", (3,))])
    face_table["count"] = 3
    face_table["corners"] = triangles

    header = [
        "ply",
        "format binary_little_endian 1.0",
        f"element vertex {len(points)}",
        *properties,
        f"element face {len(triangles)}",
        "property list uchar int vertex_indices",
        "end_header\n",
    ]
    return "\n".join(header).encode() + vertex_table.tobytes() + face_table.tobytes()
