"""Textures and texture coordinates of mesh files, with the surface of all faces."""

from solver.mesh.formats import mesh_in_zip, read_obj_coordinates
from solver.mesh.reading import read_soup
from solver.mesh.repair import TriangleSoup, merge_coincident
from solver.mesh.textures import Paint
from solver.mesh.triangle_mesh import TriangleMesh


def textured_surface(data: bytes, file_type: str) -> tuple[TriangleMesh, Paint] | None:
    """Read the surface of a mesh file with all its faces, and its textures.

    Parameters
    ----------
    data, file_type
        As for :func:`read_mesh`.

    Returns
    -------
    A mesh with the vertex numbers of the file, and the textures of its faces; ``None`` for a file
    without textures. Vertices in the same position are merged, those of no face are left out, and
    nothing else is repaired.

    Raises
    ------
    MeshError
        As :func:`read_soup`.
    """
    soup = read_soup(data, file_type)
    if soup.paint is None or not soup.paint.textures:
        return None
    return _welded(soup), soup.paint


def mapped_surface(data: bytes, file_type: str) -> tuple[TriangleMesh, Paint] | None:
    """Read the surface of a mesh file with all its faces, and its texture coordinates.

    Parameters
    ----------
    data, file_type
        As for :func:`read_mesh`.

    Returns
    -------
    As :func:`textured_surface`; an OBJ file without its images, alone or in a zip, has texture
    coordinates too.

    Raises
    ------
    MeshError
        As :func:`read_soup`.
    """
    kind = file_type.lower().lstrip(".")
    if kind != "obj":
        found = textured_surface(data, kind)
        if found is not None or kind != "zip":
            return found
        kind, data = mesh_in_zip(data)
        if kind != "obj":
            return None
    soup = read_soup(data, kind, {"obj": read_obj_coordinates})
    if soup.paint is None or (soup.paint.texture_of_face < 0).all():
        return None
    return _welded(soup), soup.paint


def _welded(soup: TriangleSoup) -> TriangleMesh:
    """Return the surface without cuts of zero width, which no path over its edges crosses.

    Textures are those of faces, so that seams keep them.
    """
    return TriangleMesh.of(merge_coincident(soup, "the file repeats vertices").compacted())
