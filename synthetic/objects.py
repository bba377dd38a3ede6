"""Surfaces of things that are not bodies: bones, a tooth, a face, stones, a leaf and others.

An object has a form at rest, drawn anew for stones, cortices and vessels, else fixed. Its
individuals are this form, displaced by waves of space, in any position and unit, and triangulated
on their own.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import pairwise
from types import MappingProxyType
from typing import TypeAlias

import numpy as np
from scipy.spatial import KDTree
from scipy.spatial.transform import Rotation
from skimage.measure import marching_cubes

from solver.arrays import FloatArray, IntArray
from solver.mesh import TriangleMesh, largest_component, simplified, triangle_mesh
from synthetic.implicit import marching_cubes_surface
from synthetic.skeleton import Cones

_WAVES = 24
_UNITS = 0.5, 20.0
_WITHOUT_SHIFT = np.zeros(3)

Cone: TypeAlias = tuple[float, float, float, float, float, float, float, float]
"""Start and end of the axis, and the radii there."""


@dataclass(frozen=True)
class Object:
    """A kind of objects.

    Parameters
    ----------
    at_rest
        Its form, drawn with a generator of random numbers.
    amplitude
        Root mean square of the displacement of individuals, over the diagonal of the form's box.
    wave_length
        Of the displacement, over the same.
    """

    at_rest: Callable[[np.random.Generator], TriangleMesh]
    amplitude: float
    wave_length: float


@dataclass(frozen=True, eq=False)
class Individual:
    """One object.

    Parameters
    ----------
    mesh
        Its surface.
    places
        (P,) vertices of the mesh at, or nearest to, the vertices of the form at rest.
    """

    mesh: TriangleMesh
    places: IntArray


def individuals(
    kind: str, seed: int, vertices: tuple[int, ...], deformation: float = 1.0
) -> list[Individual]:
    """Generate individuals of an object.

    Parameters
    ----------
    kind
        One of `OBJECTS`.
    seed
        Of the form and of all individuals.
    vertices
        Number of vertices of each individual, at most.
    deformation
        Factor on the amplitude of the displacement.

    Returns
    -------
    list of Individual
        Their `places` correspond.
    """
    known = OBJECTS[kind]
    form = known.at_rest(np.random.default_rng(seed))
    found = []
    for number, count in enumerate(vertices):
        rng = np.random.default_rng((seed, number))
        moved = form.vertices + deformation * _displacement(form.vertices, known, rng)
        turn = Rotation.random(rng=rng).as_matrix() * rng.uniform(*_UNITS)
        whole = triangle_mesh(moved @ turn, form.faces)
        mesh = simplified(whole, count)
        _, places = KDTree(mesh.vertices).query(whole.vertices)
        found.append(Individual(mesh, np.asarray(places, dtype=np.int64)))
    return found


def _displacement(points: FloatArray, known: Object, rng: np.random.Generator) -> FloatArray:
    """Sum of waves of random directions, phases and polarisations, at points."""
    diagonal = float(np.linalg.norm(np.ptp(points, axis=0)))
    waves = rng.normal(size=(_WAVES, 3)) / (known.wave_length * diagonal)
    phases = rng.uniform(0.0, 2.0 * np.pi, _WAVES)
    directions = rng.normal(size=(_WAVES, 3)) / np.sqrt(0.5 * 3.0 * _WAVES)
    heights: FloatArray = np.cos(points @ waves.T + phases) @ directions
    return known.amplitude * diagonal * heights


def _of_cones(rows: list[Cone], blend: float, spacing: float) -> TriangleMesh:
    """Smooth union of cones."""
    table = np.array(rows)
    none = np.zeros(len(table), dtype=np.int64)
    cones = Cones(table[:, :3], table[:, 3:6], table[:, 6], table[:, 7], none)
    found = marching_cubes_surface(cones, blend, spacing, _WITHOUT_SHIFT)
    return largest_component(triangle_mesh(*found))


def _level_set(
    distance: Callable[[FloatArray], FloatArray], half_width: float, spacing: float
) -> TriangleMesh:
    """Zero level set of a function of (..., 3) points in a cube."""
    axis = np.arange(-half_width, half_width + spacing, spacing)
    points = np.stack(np.meshgrid(axis, axis, axis, indexing="ij"), axis=-1)
    vertices, faces, _, _ = marching_cubes(distance(points), 0.0, spacing=(spacing,) * 3)
    return largest_component(
        triangle_mesh(vertices.astype(np.float64) - half_width, faces.astype(np.int64))
    )


def _waves_on_the_sphere(
    rng: np.random.Generator, count: int, frequency: float
) -> Callable[[FloatArray], FloatArray]:
    """Sum of waves at the directions of points, of variance 1 / 2."""
    waves = frequency * rng.normal(size=(count, 3))
    phases, heights = rng.uniform(0.0, 2.0 * np.pi, count), rng.normal(size=count)

    def height(points: FloatArray) -> FloatArray:
        radius = np.maximum(np.linalg.norm(points, axis=-1, keepdims=True), 1e-9)
        found: FloatArray = np.cos(points / radius @ waves.T + phases) @ heights / np.sqrt(count)
        return found

    return height


def _femur(_: np.random.Generator) -> TriangleMesh:
    rows = [
        (0.0, 0.0, 0.0, 0.02, 1.0, 0.05, 0.09, 0.075),
        (0.02, 1.0, 0.05, 0.0, 2.0, 0.0, 0.075, 0.1),
        (0.0, 2.0, 0.0, 0.28, 2.28, 0.06, 0.1, 0.1),
        (0.3, 2.3, 0.06, 0.31, 2.31, 0.06, 0.19, 0.19),
        (-0.05, 2.1, 0.0, -0.08, 2.3, -0.03, 0.13, 0.09),
        (-0.03, 1.75, -0.08, -0.02, 1.78, -0.1, 0.07, 0.04),
        (0.0, 0.0, 0.0, 0.14, -0.2, -0.1, 0.12, 0.17),
        (0.0, 0.0, 0.0, -0.14, -0.18, -0.08, 0.12, 0.15),
    ]
    return _of_cones(rows, 0.04, 0.028)


def _vertebra(_: np.random.Generator) -> TriangleMesh:
    angles = np.linspace(0.0, 2.0 * np.pi, 15)
    circle = np.stack([0.38 * np.cos(angles), 0.38 * np.sin(angles) - 0.25, 0.0 * angles], axis=1)
    rows = [(*start, *end, 0.11, 0.11) for start, end in pairwise(circle.tolist())]
    rows += [(0.0, 0.45, -0.1, 0.0, 0.45, 0.12, 0.38, 0.36)]
    rows += [(0.0, -0.6, 0.0, 0.0, -1.15, -0.3, 0.12, 0.08)]
    rows += [(0.35, -0.3, 0.0, 0.95, -0.45, 0.1, 0.12, 0.07)]
    rows += [(-0.35, -0.3, 0.0, -0.95, -0.45, 0.1, 0.12, 0.07)]
    rows += [(0.3, -0.35, 0.05, 0.32, -0.4, 0.4, 0.1, 0.08)]
    rows += [(-0.3, -0.35, 0.05, -0.32, -0.4, 0.4, 0.1, 0.08)]
    rows += [(0.28, -0.4, 0.0, 0.28, -0.45, -0.35, 0.1, 0.08)]
    rows += [(-0.28, -0.4, 0.0, -0.28, -0.45, -0.35, 0.1, 0.08)]
    return _of_cones(rows, 0.03, 0.035)


def _tooth(_: np.random.Generator) -> TriangleMesh:
    rows = [
        (0.0, 0.0, 0.0, 0.0, 0.25, 0.0, 0.42, 0.46),
        (0.25, 0.35, 0.2, 0.28, 0.52, 0.22, 0.2, 0.1),
        (-0.25, 0.35, 0.2, -0.26, 0.6, 0.2, 0.2, 0.1),
        (0.25, 0.35, -0.2, 0.3, 0.48, -0.22, 0.2, 0.1),
        (-0.25, 0.35, -0.22, -0.25, 0.5, -0.25, 0.18, 0.08),
        (0.4, 0.3, 0.0, 0.45, 0.4, 0.0, 0.15, 0.08),
        (0.2, 0.0, 0.1, 0.35, -0.9, 0.15, 0.2, 0.06),
        (-0.2, 0.0, 0.1, -0.25, -1.05, 0.2, 0.2, 0.06),
        (0.0, 0.0, -0.15, 0.05, -1.15, -0.35, 0.22, 0.07),
    ]
    return _of_cones(rows, 0.04, 0.033)


def _face(_: np.random.Generator) -> TriangleMesh:
    """The front of a head, with a wavy rim."""
    rows = [
        (0.0, 0.0, 0.0, 0.0, 0.1, 0.0, 0.75, 0.8),
        (0.0, -0.5, 0.25, 0.0, -0.62, 0.4, 0.4, 0.3),
        (0.0, 0.25, 0.7, 0.0, -0.08, 0.95, 0.1, 0.14),
        (0.1, -0.1, 0.85, -0.1, -0.1, 0.85, 0.1, 0.1),
        (-0.2, -0.38, 0.72, 0.2, -0.38, 0.72, 0.09, 0.09),
        (-0.4, 0.3, 0.62, 0.4, 0.3, 0.62, 0.14, 0.14),
        (0.75, 0.05, -0.05, 0.85, 0.2, -0.1, 0.12, 0.12),
        (-0.75, 0.05, -0.05, -0.85, 0.2, -0.1, 0.12, 0.12),
        (0.45, -0.05, 0.5, 0.45, -0.05, 0.5, 0.22, 0.22),
        (-0.45, -0.05, 0.5, -0.45, -0.05, 0.5, 0.22, 0.22),
    ]
    head = _of_cones(rows, 0.05, 0.045)
    in_front = head.vertices[:, 2] > 0.12 + 0.05 * np.sin(5.0 * head.vertices[:, 1])
    return largest_component(triangle_mesh(head.vertices, head.faces[in_front[head.faces].all(1)]))


def _hand(rng: np.random.Generator) -> TriangleMesh:
    """A hand with fingers bent at random."""
    rows: list[Cone] = [
        (-0.25, -0.3, 0.0, -0.25, 0.25, 0.0, 0.16, 0.14),
        (-0.05, -0.35, 0.0, -0.07, 0.3, 0.0, 0.17, 0.14),
        (0.15, -0.35, 0.0, 0.14, 0.3, 0.0, 0.17, 0.13),
        (0.25, -0.3, 0.0, 0.27, 0.18, 0.0, 0.15, 0.12),
        (0.0, -0.4, 0.0, 0.0, -1.1, 0.0, 0.2, 0.22),
        (-0.3, -0.3, 0.05, -0.65, 0.1, 0.15, 0.15, 0.1),
        (-0.65, 0.1, 0.15, -0.75, 0.4, 0.15, 0.1, 0.075),
    ]
    fingers = (
        (-0.32, 0.3, -0.1, 0.95, 0.085),
        (-0.1, 0.36, 0.0, 1.05, 0.09),
        (0.12, 0.34, 0.02, 0.98, 0.085),
        (0.32, 0.22, 0.12, 0.78, 0.075),
    )
    for x, y, sideways, length, radius in fingers:
        root, along = np.array([x, y, 0.0]), np.array([sideways, 0.75 * length, 0.0])
        curl, middle = rng.uniform(0.0, 1.4), root + 0.45 * along
        bent = np.cos(curl) * along + np.sin(curl) * np.linalg.norm(along) * np.eye(3)[2]
        tip = middle + 0.55 * bent
        rows += [(*root, *middle, 1.15 * radius, radius), (*middle, *tip, radius, 0.85 * radius)]
    return _of_cones(rows, 0.025, 0.03)


def _vessels(rng: np.random.Generator) -> TriangleMesh:
    """A tree of tubes, drawn at random."""
    rows: list[Cone] = []

    def grow(start: FloatArray, along: FloatArray, length: float, radius: float, left: int) -> None:
        end = start + along * length
        rows.append((*start, *end, radius, 0.85 * radius))
        for side in (1.0, -1.0) if left else ():
            sideways = np.cross(along, rng.normal(size=3))
            branch = along + side * rng.uniform(0.4, 0.9) * sideways
            branch /= np.linalg.norm(branch)
            grow(end, branch, length * rng.uniform(0.6, 0.95), 0.78 * radius, left - 1)

    grow(np.zeros(3), np.eye(3)[2], 1.0, 0.13, 3)
    return _of_cones(rows, 0.02, 0.045)


def _stone(rng: np.random.Generator) -> TriangleMesh:
    height = _waves_on_the_sphere(rng, 14, 2.2)
    return _level_set(
        lambda points: np.linalg.norm(points, axis=-1) - 1.0 - 0.4 * height(points), 2.0, 0.055
    )


def _cortex(rng: np.random.Generator) -> TriangleMesh:
    """An ellipsoid with furrows."""
    height = _waves_on_the_sphere(rng, 40, 7.0)
    return _level_set(
        lambda points: (
            np.linalg.norm(points * (1.0, 1.25, 0.85), axis=-1)
            - 1.0
            - 0.13 * np.tanh(2.0 * np.sqrt(2.0) * height(points))
        ),
        1.6,
        0.05,
    )


def _leaf(_: np.random.Generator) -> TriangleMesh:
    """A flat sheet with lobes, to be bent by its displacement."""
    count = 180
    x, y = np.meshgrid(np.linspace(0.0, 2.0, count), np.linspace(-1.0, 1.0, count), indexing="ij")
    angle, radius = np.arctan2(y, x - 0.9), np.hypot(x - 0.9, y)
    rim = 0.55 + 0.25 * np.cos(angle) + 0.12 * np.cos(5.0 * angle + 0.3) + 0.06 * np.sin(2 * angle)
    inside = (radius < rim).reshape(-1)
    number = np.arange(count * count).reshape(count, count)
    a, b, c, d = (
        one.reshape(-1)
        for one in (number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:])
    )
    faces = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    points = np.stack([x, y, np.zeros_like(x)], axis=-1).reshape(-1, 3)
    return largest_component(triangle_mesh(points, faces[inside[faces].all(axis=1)]))


def _mug(_: np.random.Generator) -> TriangleMesh:
    def distance(points: FloatArray) -> FloatArray:
        x, y, z = np.moveaxis(points, -1, 0)
        radius = np.hypot(x, y)
        outside = np.maximum(radius - 0.6, np.abs(z) - 0.75)
        wall = np.maximum(outside, -np.maximum(radius - 0.5, -(z + 0.62)))
        handle = np.hypot(np.hypot(x - 0.6, z) - 0.4, y) - 0.09
        handle = np.where(radius < 0.55, 1.0, handle)
        found: FloatArray = -0.02 * np.logaddexp(-wall / 0.02, -handle / 0.02)
        return found

    return _level_set(distance, 1.25, 0.03)


OBJECTS: Mapping[str, Object] = MappingProxyType(
    {
        "femur": Object(_femur, 0.05, 0.35),
        "vertebra": Object(_vertebra, 0.04, 0.3),
        "tooth": Object(_tooth, 0.045, 0.3),
        "face": Object(_face, 0.03, 0.25),
        "hand": Object(_hand, 0.03, 0.3),
        "vessels": Object(_vessels, 0.05, 0.3),
        "stone": Object(_stone, 0.05, 0.35),
        "cortex": Object(_cortex, 0.04, 0.3),
        "leaf": Object(_leaf, 0.06, 0.35),
        "mug": Object(_mug, 0.03, 0.4),
    }
)
"""Objects by name."""
