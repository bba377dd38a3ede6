"""Known points without those of another part of the body.

Where a scanned hand touches another, a known partner may lie on the wrong one of them: those of
neighbours are then far apart, and a right answer counts as an error of the length of both arms.
"""

from dataclasses import replace

import numpy as np

from bench.collection import KnownShape
from solver.arrays import BoolArray
from solver.mesh import components_of

TORN = 0.2
"""Distance in space over √area between the partners of neighbours from which on the truth is torn
between them."""


def with_sound_truth(source: KnownShape, target: KnownShape) -> tuple[KnownShape, KnownShape]:
    """Leave out the known points of two shapes that lie on another part of the body than they say.

    Parameters
    ----------
    source, target
        Shapes of one class with known truth; points that either lacks are left out too.

    Returns
    -------
    Both with the points of the largest part of either surface on which the truth is not torn.
    """
    assert source.truth is not None
    assert target.truth is not None
    shared = (source.truth >= 0) & (target.truth >= 0)
    source, target = (_with_points(one, shared) for one in (source, target))
    kept = _of_largest_part(source, target) & _of_largest_part(target, source)
    return _with_points(source, kept), _with_points(target, kept)


def _of_largest_part(source: KnownShape, target: KnownShape) -> BoolArray:
    """(T,) points of the largest part of the source whose partners are near those next to them."""
    assert source.truth is not None
    assert target.truth is not None
    nearest = source.shape.metric("geodesic").distances(source.truth).argmin(axis=0)
    places = target.shape.mesh.vertices[target.truth] / target.shape.size
    pairs = nearest[source.shape.mesh.edges]
    i, j = pairs.T
    together = np.linalg.norm(places[i] - places[j], axis=1) <= TORN
    parts = components_of(pairs[together], len(source.truth))
    largest: BoolArray = parts == np.bincount(parts).argmax()
    return largest


def _with_points(shape: KnownShape, kept: BoolArray) -> KnownShape:
    assert shape.truth is not None
    symmetric = shape.symmetric_truth
    return replace(
        shape,
        truth=shape.truth[kept],
        symmetric_truth=None if symmetric is None else symmetric[kept],
    )
