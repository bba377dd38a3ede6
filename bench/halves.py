"""Halves of bodies whose left and right are known: left, right, front, back, upper and lower."""

from collections.abc import Iterator, Sequence

import numpy as np
from scipy.spatial import cKDTree

from bench.collection import KnownShape
from bench.cut import known_part, largest_piece
from solver.arrays import BoolArray, FloatArray

HALVES = "left", "right", "front", "back", "upper", "lower"

_BEYOND = 0.02
"""Share of the width of the body by which a left or right half reaches beyond its middle."""

_APART = 5
"""Places between a half and the whole in the collection: of people in ten poses each, another."""


def half_pairs(shapes: Sequence[KnownShape]) -> Iterator[tuple[KnownShape, KnownShape]]:
    """Yield all halves of each shape, each with the same other one.

    Parameters
    ----------
    shapes
        With the same known points, all of which each has, and their mirror images.
    """
    halves = _halves(_most_upright(shapes))
    for number, one in enumerate(shapes):
        for name, kept in zip(HALVES, halves, strict=True):
            yield _cut(one, name, kept), shapes[(number + _APART) % len(shapes)]


def _sides(one: KnownShape) -> tuple[FloatArray, FloatArray]:
    """(K, 3) known points, and (K, 3) their mirror images."""
    assert one.truth is not None
    assert one.symmetric_truth is not None
    vertices = one.shape.surface.vertices
    return vertices[one.truth], vertices[one.symmetric_truth]


def _most_upright(shapes: Sequence[KnownShape]) -> KnownShape:
    """The shape whose left and right are most nearly reflections of one another in a plane."""

    def flatness(one: KnownShape) -> float:
        places, mirrored = _sides(one)
        squares = np.linalg.svd(places - mirrored, compute_uv=False) ** 2
        return float(squares[0] / squares.sum())

    return max(shapes, key=flatness)


def _halves(one: KnownShape) -> tuple[BoolArray, ...]:
    """(K,) known points of each half, by the axes of a shape: across, then upwards."""
    places, mirrored = _sides(one)
    centred = places - places.mean(axis=0)
    across = np.linalg.svd(places - mirrored, full_matrices=False)[2][0]
    upright = centred - np.outer(centred @ across, across)
    upwards = np.linalg.svd(upright, full_matrices=False)[2][0]
    # Of the two directions along it, files have the positive one up.
    upwards *= np.sign(upwards[np.abs(upwards).argmax()])
    forward = np.cross(across, upwards)
    side, depth, height = (places - mirrored) @ across, centred @ forward, centred @ upwards
    beyond, middle, waist = _BEYOND * np.ptp(side), np.median(depth), np.median(height)
    sides = side > -beyond, side < beyond, depth > middle, depth < middle
    return *sides, height > waist, height < waist


def _cut(one: KnownShape, name: str, kept: BoolArray) -> KnownShape:
    """Return the largest piece of a half; points that it lacks are -1 in its truth.

    A vertex belongs to the half if the known point nearest to it does.
    """
    assert one.truth is not None
    mesh = one.shape.surface
    nearest = cKDTree(mesh.vertices[one.truth]).query(mesh.vertices)[1]
    return known_part(one, name, *largest_piece(mesh, kept[nearest]))
