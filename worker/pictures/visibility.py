"""Points that a surface hides from the reader."""

import numpy as np

from solver.arrays import BoolArray, FloatArray, IntArray

CLEARANCE = 0.02
"""Least depth of a face in front of a point that it hides, in units of the root of the area."""

_ROUNDING = 1e-9
"""Margin of the bounding boxes: points at vertices of faces are in their boxes."""


def hidden_points(vertices: FloatArray, faces: IntArray, points: FloatArray) -> BoolArray:
    """(K,) whether a face lies in front of a point, by more than `CLEARANCE`.

    Parameters
    ----------
    vertices, faces
        (V, 3) on the paper, of unit area, z towards the reader, and (F, 3).
    points
        (K, 3) the points.
    """
    corners = vertices[faces]
    lowest = corners[:, :, :2].min(axis=1) - _ROUNDING
    highest = corners[:, :, :2].max(axis=1) + _ROUNDING
    hidden = np.zeros(len(points), dtype=np.bool_)
    for i, place in enumerate(points):
        x, y, _ = place
        near = (lowest[:, 0] <= x) & (x <= highest[:, 0])
        near &= (lowest[:, 1] <= y) & (y <= highest[:, 1])
        hidden[i] = bool((_depths(corners[near], place) > place[2] + CLEARANCE).any())
    return hidden


def _depths(corners: FloatArray, place: FloatArray) -> FloatArray:
    """(F,) z of each face at a point of the paper, NaN where the face is not there."""
    a, b, c = np.moveaxis(corners, 1, 0)
    ab, ac, ap = b - a, c - a, place - a
    twice = ab[:, 0] * ac[:, 1] - ab[:, 1] * ac[:, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        u = (ap[:, 0] * ac[:, 1] - ap[:, 1] * ac[:, 0]) / twice
        v = (ab[:, 0] * ap[:, 1] - ab[:, 1] * ap[:, 0]) / twice
        inside = (np.abs(twice) > 1e-18) & (u >= 0.0) & (v >= 0.0) & (u + v <= 1.0)
        return np.where(inside, a[:, 2] + u * ab[:, 2] + v * ac[:, 2], np.nan)
