"""Whatever a user holds a mesh in, as the file that is uploaded."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO, Protocol, TypeAlias, runtime_checkable

import numpy as np
import numpy.typing as npt


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
    str | os.PathLike[str] | bytes | BinaryIO | tuple[npt.ArrayLike, npt.ArrayLike] | MeshLike
)
"""A path; a file's bytes; an open binary file; arrays (vertices, faces); or an object with both."""


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
    elif isinstance(source, tuple) and len(source) == 2:
        yield MeshFile("mesh.ply", binary_ply(source[0], source[1]))
    elif isinstance(source, MeshLike):
        yield MeshFile("mesh.ply", binary_ply(source.vertices, source.faces, _colors(source)))
    elif hasattr(source, "read"):
        yield MeshFile(_file_name(_name_of(source), extension), source)
    else:
        raise TypeError(
            "a shape is a path, bytes, an open binary file, a tuple (vertices, faces), or an "
            f"object with .vertices and .faces, not {type(source).__name__}"
        )


def _name_of(file: object) -> str:
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
    """Write a triangle mesh as little-endian binary PLY; positions keep their full precision.

    Parameters
    ----------
    vertices
        Positions, shape (V, 3).
    faces
        Vertex indices from 0, shape (F, 3).
    colors
        RGB or RGBA, 0 to 255, shape (V, 3) or (V, 4); alpha is left out.

    Raises
    ------
    ValueError
        An array has the wrong shape, or faces are not integers a PLY file can hold.
    """
    points = _table("vertices", np.asarray(vertices, dtype=np.float64))
    triangles = np.asarray(faces)
    if triangles.size and not np.issubdtype(triangles.dtype, np.integer):
        raise ValueError(f"faces must be integers, not {triangles.dtype}")
    triangles = _table("faces", triangles)
    limits = np.iinfo(np.int32)
    if triangles.size and not limits.min <= triangles.min() <= triangles.max() <= limits.max:
        raise ValueError("faces must be vertex indices that fit 32 bits")

    fields: list[tuple[str, str, tuple[int, ...]]] = [("position", "<f8", (3,))]
    properties = [f"property double {axis}" for axis in "xyz"]
    if colors is not None:
        fields.append(("color", "u1", (3,)))
        properties += [f"property uchar {channel}" for channel in ("red", "green", "blue")]
    vertex_table = np.empty(len(points), dtype=fields)
    vertex_table["position"] = points
    if colors is not None:
        vertex_table["color"] = np.asarray(colors)[:, :3]
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


def _table(name: str, array: npt.NDArray[np.generic]) -> npt.NDArray[np.generic]:
    if array.ndim != 2 or array.shape[1] != 3:
        raise ValueError(f"{name} must have the shape (n, 3), not {array.shape}")
    return array
