"""Fewer vertices for the same surface: edge collapse by quadric error, onto vertices that stay.

Garland and Heckbert (SIGGRAPH 1997) weigh the planes of all faces that a vertex has come to stand
for, and collapse the edge that departs from them least. Here one end of the edge is collapsed into
the other, so that every vertex left is one of the user's own, in its place. To the planes, the
points themselves are added with a small weight: samples are only taken where there are vertices,
and distances need paths, so flat regions must keep some."""

import numpy as np

from solver.arrays import BoolArray, FloatArray, IntArray
from solver.mesh.edge_collapse import collapse_edges
from solver.mesh.repair import TriangleSoup, edges_of, non_manifold_vertices
from solver.mesh.triangle_mesh import TriangleMesh, triangle_areas

_POINTS = 0.02
"""Weight of the squared distance to points, relative to that to planes."""

_BOUNDARY = 10.0
"""Weight of planes along the boundary, which keep its shape."""


def simplified(mesh: TriangleMesh, vertices: int) -> TriangleMesh:
    """Approximate a mesh by one of fewer vertices, which are among those it has.

    Parameters
    ----------
    mesh
        Any mesh. Where it is no manifold, nothing is changed.
    vertices
        How many to keep.

    Returns
    -------
    TriangleMesh
        `mesh` itself if it has no more. Otherwise `vertex_ids` holds the user's numbers of the
        vertices that stayed, and `vertices_of` finds, for the number of any other, the one that
        stands for it. The same for the same mesh; O(V log V).
    """
    if mesh.n_vertices <= vertices:
        return mesh
    unit = mesh.scaled(1.0 / np.sqrt(mesh.area))
    faces, into = mesh.faces.copy(), np.arange(mesh.n_vertices)
    boundary, fixed = _boundary_and_fixed(mesh.faces, mesh.n_vertices)
    quadrics = _quadrics(unit.vertices, mesh.faces)
    collapse_edges(unit.vertices, faces, quadrics, boundary, fixed, into, vertices)
    soup = TriangleSoup(
        mesh.vertices,
        mesh.faces,
        mesh.colors,
        mesh.vertex_ids,
        mesh.warnings,
        mesh.merged,
    ).with_vertices_merged(into)
    alive = faces[:, 0] >= 0
    kept = TriangleSoup(
        soup.vertices, faces[alive], soup.colors, soup.vertex_ids, soup.notes, soup.merged
    ).compacted()
    area = float(triangle_areas(unit.vertices, faces[alive]).sum())
    return TriangleMesh(
        kept.vertices,
        kept.faces,
        kept.vertex_ids,
        kept.colors,
        (
            *kept.notes,
            f"simplified from {mesh.n_vertices} to {len(kept.vertices)} vertices, whose area is"
            f" {100.0 * abs(area - 1.0):.2g} % {'larger' if area > 1.0 else 'smaller'}",
        ),
        kept.merged,
    )


def _boundary_and_fixed(faces: IntArray, n_vertices: int) -> tuple[BoolArray, BoolArray]:
    """Vertices of the boundary, and those that stay: where the surface is no manifold."""
    edges = edges_of(faces)
    boundary, fixed = np.zeros((2, n_vertices), dtype=np.bool_)
    boundary[edges.boundary] = True
    fixed[edges.ends[edges.counts > 2]] = True
    fixed[non_manifold_vertices(faces, edges)] = True
    return boundary, fixed


def _quadrics(positions: FloatArray, faces: IntArray) -> FloatArray:
    """(V, 4, 4) the sums of squared distances that vertices stand for, weighed by area.

    x̃ᵀ Q x̃ with x̃ = (x, 1).
    """
    a, b, c = (positions[faces[:, corner]] for corner in range(3))
    normal = np.cross(b - a, c - a)
    double = np.linalg.norm(normal, axis=1)
    planes = _planes(normal / double[:, None], a, double / 6.0)
    quadrics = np.zeros((len(positions), 4, 4))
    for corner in range(3):
        np.add.at(quadrics, faces[:, corner], planes)
    edges = edges_of(faces)
    face, side = edges.boundary_sides
    start, end = positions[faces[face, side]], positions[faces[face, (side + 1) % 3]]
    along = end - start
    across = np.cross(along, normal[face] / double[face, None])
    length = np.linalg.norm(along, axis=1)
    walls = _planes(across / length[:, None], start, _BOUNDARY * length**2)
    for ends in (faces[face, side], faces[face, (side + 1) % 3]):
        np.add.at(quadrics, ends, walls)
    mass = _POINTS * np.bincount(
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
