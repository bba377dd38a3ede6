"""What a mesh file has besides the repaired surface: its textures."""

from solver.mesh.formats import READERS, read_obj_coordinates
from solver.mesh.textures import Paint
from solver.mesh.triangle_mesh import TriangleMesh


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


def mapped_surface(data: bytes, file_type: str) -> tuple[TriangleMesh, Paint] | None:
    """Read the surface of a mesh file as it is, and its texture coordinates.

    Parameters
    ----------
    data, file_type
        As for :func:`read_mesh`.

    Returns
    -------
    As :func:`textured_surface`; an OBJ file without its images has texture coordinates too.

    Raises
    ------
    MeshError
        As :func:`read_mesh`.
    """
    if file_type.lower().lstrip(".") != "obj":
        return textured_surface(data, file_type)
    soup = read_obj_coordinates(data)
    if soup.paint is None or (soup.paint.texture_of_face < 0).all():
        return None
    return TriangleMesh.of(soup), soup.paint
