"""Meshes read from files and made of arrays, checked and repaired."""

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.errors import MeshError
from solver.mesh.components import note_of_links
from solver.mesh.formats import READERS
from solver.mesh.point_cloud import surface_of_points
from solver.mesh.repair import TriangleSoup, repaired
from solver.mesh.triangle_mesh import TriangleMesh

MESH_FORMATS: tuple[str, ...] = tuple(READERS)
"""File extensions that :func:`read_mesh` knows, lower case, without the dot."""


def read_mesh(data: bytes, file_type: str) -> TriangleMesh:
    """Read a mesh file.

    Vertices keep the numbers they have in the file, whatever normals and texture coordinates it
    has. Formats that cannot share a vertex between faces (STL, glTF) have vertices in the same
    position merged. Defects are repaired as by :func:`triangle_mesh`.

    Parameters
    ----------
    data
        Bytes of the file.
    file_type
        One of `MESH_FORMATS`, in either case, with or without a dot.

    Returns
    -------
    TriangleMesh

    Raises
    ------
    MeshError
        The format is unknown, the file is not a complete file of that format, or it has no
        surface that can be computed on.

    Examples
    --------
    >>> square = b"OFF\\n4 1 0\\n0 0 0\\n1 0 0\\n1 1 0\\n0 1 0\\n4 0 1 2 3\\n"
    >>> mesh = read_mesh(square, "off")
    >>> mesh.n_vertices, mesh.n_faces, mesh.area
    (4, 2, 1.0)
    >>> mesh.warnings
    ('cut 1 face of more than three corners into triangles',)
    """
    return _checked(read_soup(data, file_type))


def read_soup(
    data: bytes, file_type: str, readers: Mapping[str, Callable[[bytes], TriangleSoup]] = READERS
) -> TriangleSoup:
    """Read a mesh file as it is.

    Parameters
    ----------
    data, file_type
        As for :func:`read_mesh`.
    readers
        By format.

    Raises
    ------
    MeshError
        The format is unknown, or the file is not a complete file of that format.
    """
    kind = file_type.lower().lstrip(".")
    if kind not in readers:
        raise MeshError(f"unknown mesh format {kind[:20]!r}; use one of {', '.join(readers)}")
    if not data:
        raise MeshError("the file is empty")
    try:
        with np.errstate(over="ignore", invalid="ignore"):  # numbers may be any; they are checked
            return readers[kind](data)
    except MemoryError:
        raise MeshError("the file is too large to be read in the memory there is") from None


def triangle_mesh(
    vertices: FloatArray, faces: IntArray, colors: FloatArray | None = None
) -> TriangleMesh:
    """Make a mesh of arrays: check them, and repair defects.

    Repeated vertices, faces and parts of the surface are merged, seams and cracks closed,
    degenerate faces dropped, and the winding made consistent; see :mod:`.repair`. `warnings` of the
    mesh says so, and `vertex_ids` keeps the numbers of the vertices given.

    Parameters
    ----------
    vertices
        (V, 3) positions.
    faces
        (F, 3) indices of vertices, from 0.
    colors
        (V, 3) in 0..1, or ``None``.

    Returns
    -------
    TriangleMesh

    Raises
    ------
    MeshError
        Array shapes are wrong, a coordinate is not finite, a colour is not in 0..1, an index is out
        of range, or no face with an area is left.

    Examples
    --------
    >>> corners = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    >>> mesh = triangle_mesh(corners, np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]))
    >>> mesh.closed, mesh.components, len(mesh.edges)
    (True, 1, 6)
    """
    points = np.asarray(vertices, dtype=np.float64)
    corners = np.asarray(faces)
    if corners.size and not np.issubdtype(corners.dtype, np.integer):
        raise MeshError("faces must be an array of integers")
    if points.ndim != 2 or points.shape[1] != 3:
        raise MeshError(f"vertices must be a (V, 3) array, not one of shape {points.shape}")
    if corners.size and (corners.ndim != 2 or corners.shape[1] != 3):
        raise MeshError(f"faces must be an (F, 3) array, not one of shape {corners.shape}")
    if colors is not None:
        colors = np.asarray(colors, dtype=np.float64)
        if colors.shape != points.shape:
            raise MeshError("colors must be a (V, 3) array with a row for every vertex")
        if not ((colors >= 0.0) & (colors <= 1.0)).all():
            raise MeshError("colors must be numbers from 0 to 1; divide bytes by 255")
    triangles = corners.astype(np.int64).reshape(-1, 3)
    vertex_ids, face_ids = (np.arange(len(one), dtype=np.int64) for one in (points, triangles))
    return _checked(TriangleSoup(points, triangles, colors, vertex_ids, face_ids))


def _checked(soup: TriangleSoup) -> TriangleMesh:
    if not len(soup.vertices):
        raise MeshError("the mesh has no vertices")
    soup = replace(soup, file_rows=_rows_of_file(soup))
    if soup.is_cloud:
        soup = surface_of_points(soup)
    if not len(soup.faces):
        raise MeshError("the mesh has no faces; upload points alone as PLY or XYZ")
    if soup.faces.min() < 0 or soup.faces.max() >= len(soup.vertices):
        raise MeshError(f"a face refers to a vertex outside 0..{len(soup.vertices) - 1}")
    mesh = TriangleMesh.of(repaired(replace(soup, paint=None, normals=None)))
    warnings = mesh.warnings if mesh.components == 1 else (*mesh.warnings, note_of_links(mesh))
    return mesh.with_same_faces(warnings=warnings)


def _rows_of_file(soup: TriangleSoup) -> tuple[int, int]:
    """Numbers of vertices and of faces of the file that a soup was read from."""
    ids = soup.face_ids
    faces = len(soup.faces) if ids is None else int(ids.max(initial=-1)) + 1
    return len(soup.vertices) + len(soup.merged), faces
