"""A damaged mesh, and what damages are made of."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from solver.arrays import FloatArray, IntArray
from solver.mesh import TriangleMesh, read_mesh
from tests.solver.mesh import mesh_files


@dataclass(frozen=True, eq=False)
class Damaged:
    """A damaged mesh.

    Attributes
    ----------
    vertices
        (V', 3).
    faces
        Polygons.
    where
        (V,) the number in the file of each vertex of the undamaged mesh.
    scale
        Its lengths, in those of the undamaged mesh.
    """

    vertices: FloatArray
    faces: Sequence[Sequence[int]]
    where: IntArray
    scale: float = 1.0


Damage = Callable[[TriangleMesh], Damaged]


def damaged_mesh(
    mesh: TriangleMesh,
    vertices: FloatArray | None = None,
    faces: IntArray | Sequence[Sequence[int]] | None = None,
    scale: float = 1.0,
) -> Damaged:
    points = mesh.vertices if vertices is None else np.asarray(vertices, dtype=np.float64)
    polygons = mesh.faces if faces is None else faces
    listed = polygons.tolist() if isinstance(polygons, np.ndarray) else polygons
    return Damaged(points, listed, np.arange(mesh.n_vertices), scale)


def generator() -> np.random.Generator:
    return np.random.default_rng(20100707)


def with_points(mesh: TriangleMesh, *points: npt.ArrayLike) -> FloatArray:
    return np.concatenate([mesh.vertices, *(np.reshape(point, (-1, 3)) for point in points)])


def hinge(mesh: TriangleMesh, number: int = 100) -> tuple[int, int, int, int, int, int]:
    """Faces f, g at an edge, and corners: f is (i, j, a) and g is (j, i, b), up to rotation."""
    f = number
    i, j, a = (int(corner) for corner in mesh.faces[f])
    beside = ((mesh.faces == i) | (mesh.faces == j)).sum(axis=1) == 2
    g = int(next(face for face in np.flatnonzero(beside) if face != f))
    b = int(mesh.faces[g].sum() - i - j)
    return f, g, i, j, a, b


def centroids(mesh: TriangleMesh) -> FloatArray:
    found: FloatArray = mesh.vertices[mesh.faces].mean(axis=1)
    return found


def jittered(damaged: Damaged, size: float) -> Damaged:
    noise = size * generator().standard_normal(damaged.vertices.shape)
    return Damaged(damaged.vertices + noise, damaged.faces, damaged.where)


def read(damaged: Damaged) -> TriangleMesh:
    """The mesh of its file."""
    return read_mesh(mesh_files.ply(damaged.vertices, damaged.faces), "ply")


def name_of(case: object) -> str:
    """Name of a damage, for the name of a test."""
    return str(getattr(case, "__name__", ""))
