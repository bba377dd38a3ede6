"""Simplification: edge collapse by quadric error, into vertices of the mesh.

Garland and Heckbert (SIGGRAPH 1997) sum the squared distances to the planes of all faces that a
vertex stands for, and collapse the edge of least error. Here one end of the edge is collapsed into
the other, so that every vertex left is one of the user's, in its position. Squared distances to the
vertices themselves are added with a small weight: samples are vertices, and geodesics run through
vertices, so flat regions must keep some."""

from dataclasses import replace

import numpy as np

from solver.arrays import BoolArray, FloatArray
from solver.mesh.edge_collapse import collapse_edges
from solver.mesh.edges import non_manifold_vertices
from solver.mesh.normals import face_normals, triangle_areas
from solver.mesh.triangle_mesh import TriangleMesh

_POINT_WEIGHT = 0.02
"""Weight of squared distances to vertices, relative to those to planes of faces."""

_BOUNDARY_WEIGHT = 10.0
"""Weight of squared distances to planes through boundary edges, which keep the boundary's shape."""


def simplified(mesh: TriangleMesh, vertices: int) -> TriangleMesh:
    """Approximate a mesh by fewer of its vertices.

    Parameters
    ----------
    mesh
        Any mesh. Non-manifold edges and vertices are kept.
    vertices
        Number of vertices to keep; more are kept where the topology needs them.

    Returns
    -------
    TriangleMesh
        `mesh` itself if it has no more vertices. Otherwise `vertex_ids` holds the user's numbers of
        the vertices kept, and `vertices_of` finds, for the number of any other, the vertex it was
        collapsed into. Deterministic; O(V log V).

    Examples
    --------
    >>> k = np.arange(100)
    >>> rim = np.stack([np.cos(0.02 * np.pi * k), np.sin(0.02 * np.pi * k), 0 * k], axis=1)
    >>> faces = np.stack([k, (k + 1) % 100, 0 * k + 100], axis=1)
    >>> disc = triangle_mesh(np.vstack([rim, np.zeros(3)]), faces)
    >>> coarse = simplified(disc, 20)
    >>> coarse.n_vertices
    20
    >>> bool((coarse.vertices_of(k) >= 0).all())
    True
    """
    if mesh.n_vertices <= vertices:
        return mesh
    unit = mesh.scaled(1.0 / np.sqrt(mesh.area))
    faces, into = mesh.faces.copy(), np.arange(mesh.n_vertices)
    boundary, fixed = _boundary_and_fixed(mesh)
    quadrics = _quadrics(unit)
    collapse_edges(unit.vertices, faces, quadrics, boundary, fixed, into, vertices)
    staying = faces[:, 0] >= 0
    left = faces[staying]
    merged = mesh.soup().with_vertices_merged(into).of_faces(staying)
    kept = replace(merged, faces=left).compacted()
    area = float(triangle_areas(unit.vertices, left).sum())
    return TriangleMesh.of(
        kept.noting(
            f"simplified from {mesh.n_vertices} to {len(kept.vertices)} vertices; the area became"
            f" {100.0 * abs(area - 1.0):.2g} % {'larger' if area > 1.0 else 'smaller'};"
            " a dense map, and what is carried along it, has images of these vertices alone: each"
            " other one has that of the vertex that it was merged into"
        )
    )


def _boundary_and_fixed(mesh: TriangleMesh) -> tuple[BoolArray, BoolArray]:
    """(V,) boundary vertices, and (V,) vertices that stay: of non-manifold edges and vertices."""
    edges = mesh.face_edges
    fixed = np.zeros(mesh.n_vertices, dtype=np.bool_)
    fixed[edges.ends[edges.counts > 2]] = True
    fixed[non_manifold_vertices(mesh.faces, edges)] = True
    return mesh.on_boundary, fixed


def _quadrics(mesh: TriangleMesh) -> FloatArray:
    """(V, 4, 4) error quadrics: x̃ᵀ Q x̃, x̃ = (x, 1), sums squared distances weighted by area."""
    positions, faces = mesh.vertices, mesh.faces
    normal = face_normals(positions, faces)
    double = np.linalg.norm(normal, axis=1)
    planes = _planes(normal / double[:, None], positions[faces[:, 0]], double / 6.0)
    quadrics = np.zeros((len(positions), 4, 4))
    for corner in range(3):
        np.add.at(quadrics, faces[:, corner], planes)
    face, side = mesh.face_edges.boundary_sides
    start, end = positions[faces[face, side]], positions[faces[face, (side + 1) % 3]]
    along = end - start
    across = np.cross(along, normal[face] / double[face, None])
    length = np.linalg.norm(along, axis=1)
    walls = _planes(across / length[:, None], start, _BOUNDARY_WEIGHT * length**2)
    for ends in (faces[face, side], faces[face, (side + 1) % 3]):
        np.add.at(quadrics, ends, walls)
    mass = _POINT_WEIGHT * np.bincount(
        faces.reshape(-1), weights=np.repeat(double / 6.0, 3), minlength=len(positions)
    )
    quadrics[:, [0, 1, 2], [0, 1, 2]] += mass[:, None]
    quadrics[:, :3, 3] -= mass[:, None] * positions
    quadrics[:, 3, :3] -= mass[:, None] * positions
    quadrics[:, 3, 3] += mass * (positions**2).sum(axis=1)
    return quadrics


def _planes(normal: FloatArray, point: FloatArray, weight: FloatArray) -> FloatArray:
    plane = np.column_stack([normal, -np.einsum("ij,ij->i", normal, point)])
    found: FloatArray = weight[:, None, None] * plane[:, :, None] * plane[:, None, :]
    return found
