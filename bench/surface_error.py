"""Errors of matched surface points, at vertices or between them, against the known truth."""

import numpy as np

from bench.collection import KnownShape
from solver.arrays import FloatArray, IntArray
from solver.gmds import SurfacePoints

FARTHEST = 0.25
"""Error over √area up to which a point is on the right part of the shape."""


def truths_of(source: KnownShape, target: KnownShape, vertices: IntArray) -> list[IntArray]:
    """True correspondents of vertices of one shape on another.

    Parameters
    ----------
    source, target
        Shapes of one class, both with known truth.
    vertices
        (N,) vertex indices of the source. The truth is that of the nearest known point.

    Returns
    -------
    One or two arrays of (N,) vertex indices of the target: direct, and mirrored if known.
    """
    assert source.truth is not None
    # Along the surface: where a hand touches a thigh, the nearest point in space may be on that.
    between = source.shape.metric("geodesic").distances(vertices)[:, source.truth]
    nearest = between.argmin(axis=1)
    known = target.truth, target.symmetric_truth
    return [truth[nearest] for truth in known if truth is not None]


def surface_errors(target: KnownShape, points: SurfacePoints, truth: IntArray) -> FloatArray:
    """(N,) geodesic distances over √area of N points from (N,) vertices of the target."""
    corners = target.shape.surface.faces[points.faces]
    return corner_errors(target, corners, points.barycentric, truth)


def corner_errors(
    target: KnownShape, corners: IntArray, barycentric: FloatArray, truth: IntArray
) -> FloatArray:
    """Geodesic distances over √area of points in triangles from vertices, by Stewart's theorem.

    Parameters
    ----------
    target
        Where the points are.
    corners
        (N, 3) vertex indices of the triangle of each point.
    barycentric
        (N, 3) coordinates in it.
    truth
        (N,) vertex indices.

    Returns
    -------
    (N,) float64; :class:`.InterpolatedMetric` has the formula.
    """
    a, b, c = np.moveaxis(target.shape.surface.vertices[corners], 1, 0)
    edges = np.stack([((c - b) ** 2).sum(1), ((a - c) ** 2).sum(1), ((b - a) ** 2).sum(1)], axis=1)
    rows = target.shape.metric("geodesic").distances(truth)
    squares = np.take_along_axis(rows, corners, axis=1) ** 2
    u, v, w = barycentric.T
    inner = v * w * edges[:, 0] + w * u * edges[:, 1] + u * v * edges[:, 2]
    apart = (squares * barycentric).sum(axis=1) - inner
    errors: FloatArray = np.sqrt(np.maximum(apart, 0.0)) / target.shape.size
    return errors


def better_errors(
    source: KnownShape, target: KnownShape, vertices: IntArray, points: SurfacePoints
) -> FloatArray:
    """(N,) errors against the direct or the mirrored truth, whichever is nearer on average."""
    errors = [surface_errors(target, points, t) for t in truths_of(source, target, vertices)]
    return min(errors, key=lambda one: float(one.mean()))
