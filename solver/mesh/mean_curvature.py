"""Mean curvature of triangulated surfaces, as a measure."""

import numpy as np

from solver.arrays import FloatArray
from solver.mesh.normals import face_normals
from solver.mesh.repair import edges_of
from solver.mesh.triangle_mesh import TriangleMesh


def mean_curvature_measures(mesh: TriangleMesh) -> tuple[FloatArray, FloatArray]:
    """Integrals of the mean curvature round each vertex, and the areas they are over.

    All curvature of a polyhedron is in its edges: the integral over a region is half the sum of
    length times dihedral angle, and tends to that of a smooth surface as triangles become small
    (Cohen-Steiner and Morvan, "Restricted Delaunay triangulations and normal cycle", SoCG 2003).
    An edge has a third of both its triangles as its area, and gives half of both to either end.
    Edges that are not between two triangles of one winding, as on boundaries, have neither: the
    mean over a neighbourhood, the quotient of both sums, does not know what was cut off.

    Parameters
    ----------
    mesh
        V vertices.

    Returns
    -------
    integrals : (V,) in the unit of length, positive where normals diverge.
    areas : (V,) in the unit squared.
    """
    edges = edges_of(mesh.faces)
    sides = np.argsort(edges.of_side, axis=None, kind="stable")
    sides = sides[edges.counts[edges.of_side.ravel()[sides]] == 2].reshape(-1, 2)
    starts = mesh.faces.ravel()[sides]
    ends = np.roll(mesh.faces, -1, axis=1).ravel()[sides]
    wound = starts[:, 0] == ends[:, 1]
    sides, start, end = sides[wound], starts[wound, 0], ends[wound, 0]
    normals = face_normals(mesh.vertices, mesh.faces)
    doubled = np.linalg.norm(normals, axis=1)
    ours, theirs = (normals / np.maximum(doubled, 1e-300)[:, None])[sides.T // 3]
    along = mesh.vertices[end] - mesh.vertices[start]
    lengths = np.linalg.norm(along, axis=1)
    # |along| times the sine and the cosine of the angle between normals.
    angles = np.arctan2(
        (np.cross(ours, theirs) * along).sum(axis=1), lengths * (ours * theirs).sum(axis=1)
    )
    integrals, areas = (
        sum(np.bincount(one, share, mesh.n_vertices) for one in (start, end))
        for share in (0.25 * lengths * angles, doubled[sides // 3].sum(axis=1) / 12.0)
    )
    return np.asarray(integrals), np.asarray(areas)
