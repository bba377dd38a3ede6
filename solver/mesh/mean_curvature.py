"""Mean curvature of triangulated surfaces, as a measure."""

import numpy as np

from solver.arrays import FloatArray
from solver.mesh.edges import same_direction
from solver.mesh.normals import face_normals
from solver.mesh.triangle_mesh import TriangleMesh


def mean_curvature_measures(mesh: TriangleMesh) -> tuple[FloatArray, FloatArray]:
    """Integrals of the mean curvature round each vertex, and the areas they are over.

    The mean curvature of a polyhedron is in its edges: its integral over a region is half the sum
    of length times angle between normals, and tends to that of a smooth surface where triangles
    become small and stay well shaped (Cohen-Steiner and Morvan, "Restricted Delaunay triangulations
    and normal cycle", SoCG 2003). Half of an edge's integral belongs to each of its triangles, and
    half of that to each of its ends; a third of a triangle's area belongs to each corner.

    Triangles count that have another one of the same winding at each side, so that triangles on a
    boundary have neither integral nor area: one of their sides has no angle. The mean over a
    neighbourhood, the quotient of both sums, then does not depend on what was cut off.

    Parameters
    ----------
    mesh
        V vertices.

    Returns
    -------
    integrals : (V,) in the unit of length, positive where normals diverge.
    areas : (V,) in the unit squared.
    """
    edges = mesh.face_edges
    pairs, same = same_direction(mesh.faces, edges)
    pairs, ends = pairs[~same], edges.ends[edges.counts == 2][~same]
    inner = np.bincount(pairs.ravel(), minlength=mesh.n_faces) == 3
    normals = face_normals(mesh.vertices, mesh.faces)
    doubled = np.linalg.norm(normals, axis=1)
    unit, middles = (
        normals / np.maximum(doubled, 1e-300)[:, None],
        mesh.vertices[mesh.faces].mean(1),
    )
    ours, theirs = unit[pairs.T]
    angles = np.arctan2(
        np.linalg.norm(np.cross(ours, theirs), axis=1), np.einsum("ij,ij->i", ours, theirs)
    )
    convex = np.einsum("ij,ij->i", np.diff(middles[pairs], axis=1)[:, 0], ours) < 0.0
    lengths = np.linalg.norm(np.diff(mesh.vertices[ends], axis=1)[:, 0], axis=1)
    integrals = 0.5 * lengths * np.where(convex, angles, -angles) * inner[pairs].mean(axis=1)
    found: FloatArray = np.bincount(
        ends.ravel(), np.repeat(0.5 * integrals, 2), mesh.n_vertices
    ).astype(np.float64)
    areas: FloatArray = np.bincount(
        mesh.faces[inner].ravel(), np.repeat(doubled[inner] / 6.0, 3), mesh.n_vertices
    ).astype(np.float64)
    return found, areas
