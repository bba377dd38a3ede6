"""A class of shapes in correspondence: blobs with bumps of different sizes."""

import numpy as np
import trimesh

from solver.arrays import FloatArray, IntArray
from tests.solver import shapes
from tests.worker.figures import off

_BUMPS = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [-0.6, -0.8, 0.0]])
_HEIGHTS = np.array([0.8, 0.5, 0.3, 0.4])


def member(seed: int, subdivisions: int = 2) -> tuple[FloatArray, IntArray]:
    """Vertices and faces of one shape of the class; all have the same connectivity."""
    random = np.random.default_rng(seed)
    sphere = trimesh.creation.icosphere(subdivisions=subdivisions)
    points = np.asarray(sphere.vertices, dtype=np.float64)
    heights = _HEIGHTS * random.uniform(0.7, 1.3, len(_HEIGHTS))
    apart = ((points[:, None] - _BUMPS) ** 2).sum(axis=2)
    vertices = points * [1.0, 1.4, 2.0] * (1.0 + np.exp(-4.0 * apart) @ heights)[:, None]
    return vertices, np.asarray(sphere.faces, dtype=np.int64)


def family(count: int, subdivisions: int = 2, first: int = 0) -> list[bytes]:
    """OFF files of several shapes of the class."""
    return [off(*member(seed, subdivisions)) for seed in range(first, first + count)]


def too_coarse() -> bytes:
    """OFF file of a shape that is stored, but has too few vertices to be registered."""
    mesh = shapes.triangle()
    return off(mesh.vertices, mesh.faces)
