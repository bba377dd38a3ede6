"""Conversion of paths, files, arrays and mesh objects to the file that is uploaded."""

import io
import os
import zipfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO, Final, Protocol, TypeAlias, TypeGuard, runtime_checkable

import numpy as np
import numpy.typing as npt

from isomatch._http import UploadFile
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


FileSource: TypeAlias = str | os.PathLike[str] | bytes | BinaryIO
"""A path, the bytes of a file, or an open binary file."""

MeshSource: TypeAlias = (
    FileSource
    | npt.NDArray[np.floating]
    | tuple[npt.ArrayLike, npt.ArrayLike]
    | tuple[npt.ArrayLike, npt.ArrayLike, npt.ArrayLike | None]
    | MeshLike
)
"""A path, the bytes of a file, an open binary file, an array of points (V, 3), or (V, 6) with their
normals, arrays (vertices, faces) or (vertices, faces, colours), or an object with vertices and
faces."""


_MESH_SOURCES: Final = (
    "a shape is a path, bytes, an open binary file, an array of points, a tuple (vertices, faces) "
    "or (vertices, faces, colours), or an object with .vertices and .faces, not "
)


_POINT_COLUMNS: Final = ("x", "y", "z", "nx", "ny", "nz")


@contextmanager
def mesh_file(source: MeshSource, file_type: str | None = None) -> Iterator[UploadFile]:
    """Context that provides a source as a mesh file.

    Parameters
    ----------
    source
        See :data:`MeshSource`. An open file is read from its beginning and is left open; one that
        has no way back to it, such as a pipe, is read into memory.
    file_type
        Format, such as ``"off"``; required for bytes and for files without an extension.

    Raises
    ------
    OSError
        The path cannot be read.
    TypeError
        `source` is of an unsupported type.
    ValueError
        The format is unknown, or arrays are invalid.
    """
    extension = None if file_type is None else "." + file_type.lower().removeprefix(".")
    if _is_file(source):
        with _opened(source) as file:
            yield UploadFile(_file_name(file.name, extension), file.content)
    elif isinstance(source, np.ndarray):
        yield UploadFile("points.ply", points_ply(source))
    elif isinstance(source, tuple):
        if len(source) not in (2, 3):
            raise TypeError(_MESH_SOURCES + f"a tuple of {len(source)}")
        yield UploadFile("mesh.ply", binary_ply(*source))
    elif isinstance(source, MeshLike):
        yield UploadFile("mesh.ply", binary_ply(source.vertices, source.faces, _colors(source)))
    else:
        raise TypeError(_MESH_SOURCES + type(source).__name__)


@contextmanager
def attribute_file(
    source: FileSource | Mapping[str, npt.ArrayLike], file_type: str | None = None
) -> Iterator[UploadFile]:
    """Context that provides a file of attributes, or arrays by name as one.

    Parameters and errors are those of :func:`mesh_file`.
    """
    if isinstance(source, Mapping):
        yield UploadFile("values.npz", _archive(source))
        return
    if not _is_file(source):
        raise TypeError(
            "attributes are a path, bytes, an open binary file, or arrays by name, not "
            + type(source).__name__
        )
    with mesh_file(source, file_type) as file:
        yield file


@contextmanager
def prototype_file(source: FileSource) -> Iterator[UploadFile]:
    """Context that provides the archive of a prototype as a file, whatever its name.

    Raises
    ------
    OSError
        The path cannot be read.
    TypeError
        `source` is of an unsupported type.
    """
    if not _is_file(source):
        raise TypeError(
            f"a prototype is a path, bytes or an open binary file, not {type(source).__name__}"
        )
    with _opened(source) as file:
        yield UploadFile(file.name or "prototype.npz", file.content)


def _is_file(source: object) -> TypeGuard[FileSource]:
    of_file = isinstance(source, str | os.PathLike | bytes | bytearray | memoryview)
    return of_file or hasattr(source, "read")


@contextmanager
def _opened(source: FileSource) -> Iterator[UploadFile]:
    """Provide a file with the name it has, which may be none; a path is closed again."""
    if isinstance(source, str | os.PathLike):
        path = Path(source)
        with path.open("rb") as file:
            yield UploadFile(path.name, file)
    elif isinstance(source, bytes | bytearray | memoryview):
        yield UploadFile("", bytes(source))
    else:
        name = getattr(source, "name", "")
        seekable = getattr(source, "seekable", bool)()
        # Each attempt sends the whole file.
        content = source if seekable else io.BytesIO(source.read())
        yield UploadFile(Path(name).name if isinstance(name, str) else "", content)


def _archive(arrays: Mapping[str, npt.ArrayLike]) -> bytes:
    """Return arrays as the bytes of an ``.npz``; one of objects is refused."""
    stream = io.BytesIO()
    # A name may be that of a parameter of savez.
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, values in arrays.items():
            with archive.open(f"{name}.npy", "w", force_zip64=True) as member:
                np.lib.format.write_array(member, np.asarray(values), allow_pickle=False)
    return stream.getvalue()


def _file_name(name: str, extension: str | None) -> str:
    if extension is not None:
        return Path(name or "mesh").stem + extension
    if not Path(name).suffix:
        raise ValueError('the name has no extension; give the format, as in file_type="off"')
    return name


def _colors(mesh: object) -> npt.ArrayLike | None:
    # trimesh: only visuals of the kind "vertex" have a colour for each vertex.
    visual = getattr(mesh, "visual", None)
    if getattr(visual, "kind", None) != "vertex":
        return None
    colors: npt.ArrayLike | None = getattr(visual, "vertex_colors", None)
    return colors


def points_ply(points: npt.ArrayLike) -> bytes:
    """Write a point cloud as little-endian binary PLY, exactly and in the order given.

    Parameters
    ----------
    points
        (V, 3) positions, or (V, 6) with normals, written as float64.

    Raises
    ------
    ValueError
        The array has another shape.
    """
    table = np.asarray(points, dtype="<f8")
    if table.ndim != 2 or table.shape[1] not in (3, 6):
        raise ValueError(f"points must have the shape (V, 3) or (V, 6), not {table.shape}")
    header = [
        "ply",
        "format binary_little_endian 1.0",
        f"element vertex {len(table)}",
        *(f"property double {name}" for name in _POINT_COLUMNS[: table.shape[1]]),
        "end_header\n",
    ]
    return "\n".join(header).encode() + np.ascontiguousarray(table).tobytes()


def binary_ply(
    vertices: npt.ArrayLike, faces: npt.ArrayLike, colors: npt.ArrayLike | None = None
) -> bytes:
    """Write a triangle mesh as little-endian binary PLY, exactly and in the order given.

    Parameters
    ----------
    vertices
        Positions, (V, 3), written as float64.
    faces
        Vertex indices from 0, (F, 3).
    colors
        RGB or RGBA of each vertex, (V, 3) or (V, 4), integers from 0 to 255 or floats from 0 to 1;
        alpha is ignored.

    Raises
    ------
    ValueError
        An array is invalid: see :func:`checked_arrays` and :func:`checked_colors`.
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
