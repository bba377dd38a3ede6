"""One lopsided blob in two triangulations: small enough that a match takes a moment."""

from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import trimesh
from scipy.spatial.transform import Rotation

Floats = npt.NDArray[np.float64]

BUMPS = np.array([[1.0, 0.0, 0.0], [-0.5, 0.9, 0.1], [0.1, -0.4, 0.9], [-0.3, -0.6, -0.7]])
TURN = Rotation.from_rotvec([0.9, 1.7, 0.6]).as_matrix()
HEIGHTS = np.array([1.4, 0.9, 0.6, 0.35])

CLASSES = {
    "standing_individual_01.off": "standing_individual",
    "cat0.off": "cat",
    "great ape - 2 (old).ply": "great ape",
    "01.off": "01",
    "tail_.off": "tail",
    "human-sitting.off": "human",
    "human-sitting2.off": "human-sitting",
    "wild boar.off": "wild",
    "-left.off": "-left",
    "v1.2.off": "v",
    "cat.smooth.off": "cat.smooth",
    "cat": "cat",
}
"""Classes of names, as the command and the page tell them."""

LASTING: dict[str, Any] = {
    "points": 256,
    "alternatives": 32,
    "coarse_points": 10,
    "metric": "geodesic",
    "descriptor": "none",
}
"""Parameters with which a match lasts longer than any program takes to start and be heard."""


def blob(vertices: Floats) -> Floats:
    """Points of the blob's surface in given directions, (V, 3)."""
    directions = vertices / np.linalg.norm(vertices, axis=1, keepdims=True)
    bumps = BUMPS / np.linalg.norm(BUMPS, axis=1, keepdims=True)
    radius = 1.0 + np.exp(8.0 * (directions @ bumps.T - 1.0)) @ HEIGHTS
    surface: Floats = directions * radius[:, None]
    return surface


def moved(points: Floats) -> Floats:
    """Where points of the first of :func:`blob_meshes` are on the second."""
    there: Floats = points @ TURN.T + [3.0, 0.0, 1.0]
    return there


def blob_meshes(subdivisions: int = 3) -> tuple[trimesh.Trimesh, trimesh.Trimesh]:
    """The blob twice: another triangulation, turned and moved."""
    ball = trimesh.creation.icosphere(subdivisions=subdivisions)
    first = trimesh.Trimesh(blob(ball.vertices), ball.faces, process=False)
    ball = trimesh.creation.icosphere(subdivisions=subdivisions)
    second = trimesh.Trimesh(blob(ball.vertices @ TURN), ball.faces, process=False)
    second.vertices = moved(second.vertices)
    return first, second


def write_blobs(folder: Path, subdivisions: int = 3) -> tuple[Path, Path]:
    """Write the two as ``a.off`` and ``b.obj``."""
    first, second = blob_meshes(subdivisions)
    a, b = folder / "a.off", folder / "b.obj"
    first.export(a)
    second.export(b)
    return a, b
