"""Conversion of paths, files, arrays and mesh objects to the file that is uploaded."""

import io
import os
import zipfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any, BinaryIO, Final, TypeAlias, TypeGuard

import numpy as np
import numpy.typing as npt

from isomatch._http import UploadFile
from isomatch._upload.mesh_objects import MeshObject, is_scene, object_file
from isomatch._upload.ply import binary_ply, points_ply

FileSource: TypeAlias = str | os.PathLike[str] | bytes | bytearray | memoryview | BinaryIO
"""A path, the bytes of a file, or an open binary file."""

MeshSource: TypeAlias = (
    FileSource
    | npt.NDArray[np.floating]
    | tuple[npt.ArrayLike, npt.ArrayLike]
    | tuple[npt.ArrayLike, npt.ArrayLike | None, npt.ArrayLike | None]
    | MeshObject
)
"""A path, the bytes of a file, an open binary file, an array of points (V, 3), or (V, 6) with their
normals, arrays (vertices, faces) or (vertices, faces, colours), whose faces are None for points
with colours, or an object with vertices and faces."""


_MESH_SOURCES: Final = (
    "a shape is a path, bytes, an open binary file, an array of points, a tuple (vertices, faces) "
    "or (vertices, faces, colours), or an object with .vertices and .faces or .triangles, not "
)


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
        yield _file_of_arrays(source)
    elif isinstance(source, MeshObject):
        yield object_file(source)
    elif is_scene(source):
        raise TypeError("a scene has several meshes: to upload them as one, use scene.to_mesh()")
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


def _file_of_arrays(arrays: tuple[Any, ...]) -> UploadFile:
    """Return (vertices, faces) or (vertices, faces, colours) as a file."""
    if len(arrays) not in (2, 3):
        raise TypeError(_MESH_SOURCES + f"a tuple of {len(arrays)}")
    vertices, faces, *colors = arrays
    if faces is None and len(colors) == 1:
        return UploadFile("points.ply", points_ply(vertices, *colors))
    return UploadFile("mesh.ply", binary_ply(vertices, faces, *colors))


def _archive(arrays: Mapping[str, npt.ArrayLike]) -> bytes:
    """Return arrays as the bytes of an ``.npz``.

    Raises
    ------
    ValueError
        A list has rows of several lengths, or an array has objects; the message names it.
    """
    stream = io.BytesIO()
    # A name may be that of a parameter of savez.
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, values in arrays.items():
            with archive.open(f"{name}.npy", "w", force_zip64=True) as member:
                np.lib.format.write_array(member, _plain_array(name, values), allow_pickle=False)
    return stream.getvalue()


def _plain_array(name: str, values: npt.ArrayLike) -> npt.NDArray[Any]:
    try:
        array = np.asarray(values)
    except ValueError as error:
        raise ValueError(f"{name!r} is no array: {error}") from error
    if array.dtype.hasobject:
        raise ValueError(
            f"{name!r} is an array of objects: give numbers, as by .astype(float), or text, as by"
            " .astype(str)"
        )
    return array


def _file_name(name: str, extension: str | None) -> str:
    if extension is not None:
        return Path(name or "mesh").stem + extension
    if not Path(name).suffix:
        raise ValueError('the name has no extension; give the format, as in file_type="off"')
    return name
