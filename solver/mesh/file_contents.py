"""What a mesh file has besides the repaired surface: its textures, and its number of vertices."""

from solver.mesh.formats import READERS
from solver.mesh.textures import Paint
from solver.mesh.triangle_mesh import TriangleMesh

_NUMBERED = ("off", "obj", "ply", "xyz", "txt", "csv")
"""Formats that number vertices one after the other."""


def textured_surface(data: bytes, file_type: str) -> tuple[TriangleMesh, Paint] | None:
    """Read the surface of a mesh file as it is, and its textures.

    Parameters
    ----------
    data, file_type
        As for :func:`read_mesh`.

    Returns
    -------
    A mesh that is not repaired, with the vertex numbers of the file, and the textures of its faces;
    ``None`` for a file without textures.

    Raises
    ------
    MeshError
        As :func:`read_mesh`.
    """
    soup = READERS[file_type.lower().lstrip(".")](data)
    if soup.paint is None or not soup.paint.textures:
        return None
    return TriangleMesh.of(soup), soup.paint


def vertex_rows(data: bytes, file_type: str) -> int | None:
    """Return the number of vertices of a mesh file, those included that no face uses.

    Parameters
    ----------
    data, file_type
        As for :func:`read_mesh`.

    Returns
    -------
    ``None`` for formats that number vertices otherwise than one after the other.

    Raises
    ------
    MeshError
        As :func:`read_mesh`.
    """
    kind = file_type.lower().lstrip(".")
    return len(READERS[kind](data).vertices) if kind in _NUMBERED else None
