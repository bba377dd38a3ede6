"""Holes: connected boundaries, and their middles, round which fans close them."""

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.mesh.repair.edges import components_of


def holes_of(
    positions: FloatArray, start: IntArray, end: IntArray, patch: IntArray
) -> tuple[IntArray, FloatArray]:
    """Number the holes of a surface.

    Parameters
    ----------
    positions
        (V, 3) vertices.
    start, end
        (B,) ends of the boundary sides.
    patch
        (B,) patch of each; holes of different patches differ.

    Returns
    -------
    hole : (B,) hole of each side, numbered from 0. Boundaries that share a vertex are one.
    middles : (H, 3) mean of the starts of each hole's sides.
    """
    keys = np.concatenate([patch * len(positions) + start, patch * len(positions) + end])
    known, number = np.unique(keys, return_inverse=True)
    ends = number.reshape(2, -1)
    hole = components_of(ends.T, len(known))[ends[0]]
    size = np.bincount(hole)
    sums = [np.bincount(hole, weights=along) for along in positions[start].T]
    return hole, np.stack([one / size for one in sums], axis=1)
