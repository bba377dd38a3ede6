"""Surfaces like those of scanned skulls: hollow, thin-walled, with openings, arches and teeth.

Individuals are one template, displaced by waves of space that are long against its details, with
walls and pores of their own.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.ndimage import gaussian_filter, map_coordinates
from skimage.measure import marching_cubes

from solver.arrays import FloatArray, IntArray
from solver.mesh import components_of

SKULL_LENGTH = 22.0
"""Millimetres from the teeth to the back of the template."""

_CORNER = np.array([-16.0, -9.5, -9.5])
"""Of a box round all individuals, the opposite corner of which is its negative."""

_WAVES = 24
_WAVE_LENGTHS = 12.0, 30.0
_ASYMMETRY = 0.1
_ROUGHNESS = 0.04
_COARSE = 6
"""Cells of the grid between points at which the displacement is inverted."""


@dataclass(frozen=True, eq=False)
class Displacement:
    """A smooth displacement of space, nearly symmetric about the plane y = 0.

    Parameters
    ----------
    waves
        (n, 3) wave vectors.
    phases
        (n,).
    amplitudes
        (n, 3), in millimetres.
    """

    waves: FloatArray
    phases: FloatArray
    amplitudes: FloatArray

    @classmethod
    def random(cls, seed: int, variation: float) -> "Displacement":
        """Draw a displacement.

        Parameters
        ----------
        seed
            Of the individual.
        variation
            Root mean square of the displacement, in millimetres.
        """
        rng = np.random.default_rng(seed)
        directions = rng.normal(size=(_WAVES, 3))
        directions /= np.linalg.norm(directions, axis=1, keepdims=True)
        waves = directions * (2.0 * np.pi / rng.uniform(*_WAVE_LENGTHS, (_WAVES, 1)))
        amplitudes = rng.normal(size=(_WAVES, 3)) * variation / np.sqrt(3.0 * _WAVES)
        mirror = np.array([1.0, -1.0, 1.0])
        uneven = 1.0 + _ASYMMETRY * rng.normal(size=(2 * _WAVES, 1))
        return cls(
            np.concatenate([waves, waves * mirror]),
            np.tile(rng.uniform(0.0, 2.0 * np.pi, _WAVES), 2),
            np.concatenate([amplitudes, amplitudes * mirror]) * uneven,
        )

    def __call__(self, points: FloatArray) -> FloatArray:
        """(N, 3) displaced points."""
        displaced: FloatArray = points + np.sin(points @ self.waves.T + self.phases) @ (
            self.amplitudes
        )
        return displaced

    def inverse(self, points: FloatArray) -> FloatArray:
        """(N, 3) points that are displaced to the given ones, by iteration to a fixed point."""
        found = points
        for _ in range(20):
            found = points - (self(found) - found)
        return found


@dataclass(frozen=True, eq=False)
class Skull:
    """One individual.

    Parameters
    ----------
    vertices, faces
        (V, 3) in millimetres, and (F, 3).
    rest
        (V, 3) the vertices on the template.
    displacement
        Of the template: where a point of it lies in this individual.
    """

    vertices: FloatArray
    faces: IntArray
    rest: FloatArray
    displacement: Displacement


def skull(seed: int, variation: float = 0.5, spacing: float = 0.2) -> Skull:
    """Generate an individual.

    Parameters
    ----------
    seed
        Of its form, and of its pores.
    variation
        Root mean square of the displacement of the template, in millimetres; of 1.0 it may fold.
    spacing
        Edge of a grid cell, in millimetres: of 0.2 there are some 40,000 vertices. Walls are 0.3 to
        0.6 thick.
    """
    rng = np.random.default_rng((seed, 1))
    displacement = Displacement.random(seed, variation)
    corner = _CORNER + rng.uniform(0.0, spacing, 3)
    axes = [np.arange(low, -first, spacing) for low, first in zip(corner, _CORNER, strict=True)]
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)
    values = _template(_at_rest(grid, displacement))
    values += _ROUGHNESS * (_noise(rng, grid.shape[:3], 1.2) + _noise(rng, grid.shape[:3], 6.0))
    closed = np.pad(values[1:-1, 1:-1, 1:-1], 1, constant_values=1.0)
    vertices, faces, _, _ = marching_cubes(closed, 0.0, spacing=(spacing,) * 3)
    vertices, faces = _largest_component(vertices + corner, faces.astype(np.int64))
    return Skull(vertices, faces, displacement.inverse(vertices), displacement)


def _at_rest(grid: FloatArray, displacement: Displacement) -> FloatArray:
    """Points of a regular grid on the template, inverted at few of them and interpolated."""
    coarse = grid[::_COARSE, ::_COARSE, ::_COARSE]
    moved = displacement.inverse(coarse.reshape(-1, 3)).reshape(coarse.shape) - coarse
    places = np.indices(grid.shape[:3]) / _COARSE
    parts = [map_coordinates(moved[..., d], places, order=3, mode="nearest") for d in range(3)]
    found: FloatArray = grid + np.stack(parts, axis=-1)
    return found


def _noise(rng: np.random.Generator, shape: tuple[int, ...], width: float) -> FloatArray:
    """Noise of deviation 1, smooth over so many cells."""
    noise = gaussian_filter(rng.normal(size=shape), width)
    found: FloatArray = noise / noise.std()
    return found


def _largest_component(vertices: FloatArray, faces: IntArray) -> tuple[FloatArray, IntArray]:
    labels = components_of(np.concatenate([faces[:, :2], faces[:, 1:]]), len(vertices))
    kept = np.flatnonzero(labels == np.bincount(labels).argmax())
    return vertices[kept], np.searchsorted(kept, faces[np.isin(faces[:, 0], kept)])


def _ellipsoid(
    points: FloatArray, centre: tuple[float, ...], radii: tuple[float, ...]
) -> FloatArray:
    """About the distance from an ellipsoid, negative inside."""
    relative = np.linalg.norm((points - np.array(centre)) / np.array(radii), axis=-1)
    distance: FloatArray = (relative - 1.0) * min(radii)
    return distance


def _cone(
    points: FloatArray,
    start: tuple[float, ...],
    end: tuple[float, ...],
    radii: tuple[float, float],
) -> FloatArray:
    """About the distance from a rounded cone, negative inside."""
    first, axis = np.array(start), np.subtract(end, start)
    along = np.clip((points - first) @ axis / (axis @ axis), 0.0, 1.0)
    across = np.linalg.norm(points - first - along[..., None] * axis, axis=-1)
    distance: FloatArray = across - radii[0] - along * (radii[1] - radii[0])
    return distance


def _union(one: FloatArray, other: FloatArray, blend: float) -> FloatArray:
    """Smooth union of two solids: quadratic where their distances differ by less than `blend`."""
    share = np.clip(0.5 + 0.5 * (other - one) / blend, 0.0, 1.0)
    found: FloatArray = other + (one - other) * share - blend * share * (1.0 - share)
    return found


_OPENINGS = (
    ((-1.2, 3.2, 0.9), (1.7, 1.2, 1.4)),
    ((-7.5, 0.7, -2.2), (1.3, 0.35, 1.2)),
    ((3.5, 1.2, -3.4), (0.8, 0.5, 1.2)),
    ((7.5, 3.6, -2.2), (0.7, 1.0, 0.7)),
)
"""Centres and radii of orbits, palatine openings and two pairs of foramina, on one side."""

_ARCH = (
    (-4.5, 2.0, -0.7),
    (-3.0, 4.3, -0.9),
    (0.0, 5.3, -1.3),
    (2.5, 5.2, -1.1),
    (4.2, 4.2, -0.6),
)
"""The zygomatic arch of one side."""


def _template(points: FloatArray) -> FloatArray:
    """About the distance from the bone, negative inside: x points back, z up."""
    side = np.abs(points[..., 1])
    half = np.stack([points[..., 0], side, points[..., 2]], axis=-1)
    snout = _cone(points, (-1.0, 0.0, 0.2), (-9.5, 0.0, -0.4), (2.6, 1.5))
    solid = _union(_ellipsoid(points, (5.0, 0.0, 0.5), (6.0, 4.8, 3.6)), snout, 0.8)
    solid = _union(solid, _ellipsoid(points, (0.5, 0.0, 0.4), (3.0, 3.0, 2.4)), 0.8)
    bone = np.abs(solid + 0.28) - 0.28
    bone = np.maximum(bone, -_cone(points, (9.0, 0.0, -0.6), (13.0, 0.0, -0.6), (1.5, 1.5)))
    bone = np.maximum(bone, -_cone(points, (-9.5, 0.0, 0.1), (-13.0, 0.0, 0.1), (1.0, 1.0)))
    for centre, radii in _OPENINGS:
        bone = np.maximum(bone, -_ellipsoid(half, centre, radii))
    for start, end in pairwise(_ARCH):
        bone = _union(bone, _cone(half, start, end, (0.35, 0.33)), 0.25)
    bulla = _ellipsoid(half, (6.2, 2.7, -2.9), (1.6, 1.2, 1.2))
    bone = _union(bone, np.abs(bulla + 0.15) - 0.15, 0.15)
    bone = _union(bone, _cone(half, (-9.8, 0.45, -0.6), (-9.2, 0.3, -3.6), (0.42, 0.25)), 0.2)
    for x in (-4.2, -3.2, -2.2):
        molar = _cone(half, (x, 1.25, -1.7), (x, 1.3, -3.0), (0.42, 0.38))
        bone = _union(bone, molar, 0.1)
    return np.minimum(bone, _nose(points, side, snout))


def _nose(points: FloatArray, side: FloatArray, snout: FloatArray) -> FloatArray:
    """The septum, and a turbinate on either side."""
    inside = snout + 0.3
    septum = np.maximum(side - 0.13, np.maximum(inside, points[..., 0] + 1.5))
    round_it = np.abs(np.hypot(side - 0.85, points[..., 2] + 0.1) - 0.45) - 0.1
    length = np.maximum(points[..., 0] + 2.5, -9.0 - points[..., 0])
    found: FloatArray = np.minimum(septum, np.maximum(round_it, np.maximum(inside, length)))
    return found
