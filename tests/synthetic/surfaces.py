"""Properties of surfaces that several tests check."""

import numpy as np

from solver.mesh import TriangleMesh


def euler_characteristic(mesh: TriangleMesh) -> int:
    return mesh.n_vertices - len(mesh.edges) + mesh.n_faces


def is_oriented(mesh: TriangleMesh) -> bool:
    """Whether no edge is passed twice in one direction."""
    edges = mesh.faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    return len(np.unique(edges, axis=0)) == len(edges)
