"""One-sided scans: what a far camera that measures depth sees of bodies."""

from collections.abc import Iterator, Sequence
from itertools import product

import numpy as np

from bench.collection import KnownShape
from bench.cut import known_part, largest_piece
from solver.arrays import BoolArray, FloatArray, IntArray
from solver.mesh import TriangleMesh

_VIEWS = 2
"""Random directions from which each shape is seen."""

_PIXELS = 150
"""Along the largest extent of the body."""

_STEPS = 6
"""Into which sides of faces are divided to cover the pixels."""

_BEHIND = 0.015
"""Depth over the largest extent by which a visible vertex may lie behind its pixel."""

_APART = 5
"""Places between a view and the whole in the collection: of people in ten poses each, another."""


def view_pairs(shapes: Sequence[KnownShape], first: int) -> Iterator[tuple[KnownShape, KnownShape]]:
    """Yield the largest visible piece of each shape in a few views, each with the same other shape.

    Parameters
    ----------
    shapes
        With known points.
    first
        Seed of the directions.
    """
    for number, one in enumerate(shapes):
        mesh, rng = one.shape.surface, np.random.default_rng([first, number])
        for view in range(_VIEWS):
            seen = largest_piece(mesh, _visible(mesh, rng.normal(size=3)))
            yield known_part(one, f"view {view}", *seen), shapes[(number + _APART) % len(shapes)]


def _visible(mesh: TriangleMesh, direction: FloatArray) -> BoolArray:
    """(V,) vertices that no face hides from a camera far away, by an image of depths."""
    frame = np.linalg.qr(np.column_stack([direction, np.eye(3)[:, :2]]))[0]
    places = mesh.vertices @ frame[:, [1, 2, 0]]
    places = (places - places.min(axis=0)) / np.ptp(places, axis=0).max()
    weights = [one for one in product(range(_STEPS + 1), repeat=3) if sum(one) == _STEPS]
    points = (np.array(weights) / _STEPS @ places[mesh.faces]).reshape(-1, 3)
    depths = np.full((_PIXELS + 1, _PIXELS + 1), np.inf)
    np.minimum.at(depths, _pixels(points), points[:, 2])
    visible: BoolArray = places[:, 2] <= depths[_pixels(places)] + _BEHIND
    return visible


def _pixels(places: FloatArray) -> tuple[IntArray, IntArray]:
    column, row = (places[:, :2] * _PIXELS).astype(np.int64).T
    return column, row
