"""Errors of matched surface points, at vertices or between them, against the known truth."""

import numpy as np

from bench.collection import KnownShape
from solver.arrays import BoolArray, FloatArray, IntArray
from solver.gmds import SurfacePoints

FARTHEST = 0.25
"""Error over √area up to which a point is on the right part of the shape."""


def truths_of(
    source: KnownShape, target: KnownShape, vertices: IntArray
) -> tuple[BoolArray, list[IntArray]]:
    """True correspondents of vertices of one shape on another.

    Parameters
    ----------
    source, target
        Shapes of one class, both with known truth; -1 stands for a point that a shape lacks.
    vertices
        (N,) vertex indices of the source. The truth is that of the nearest known point.

    Returns
    -------
    kept
        (N,) whether the target has the partner.
    truths
        One or two arrays of (K,) vertex indices of the target, of the K vertices that are kept:
        direct, and mirrored if known.
    """
    assert source.truth is not None
    here = np.flatnonzero(source.truth >= 0)
    # Along the surface: where a hand touches a thigh, the nearest point in space may be on that.
    between = source.shape.metric("geodesic").distances(vertices)[:, source.truth[here]]
    nearest = here[between.argmin(axis=1)]
    known = [one for one in (target.truth, target.symmetric_truth) if one is not None]
    kept = np.all([truth[nearest] >= 0 for truth in known], axis=0)
    return kept, [truth[nearest[kept]] for truth in known]


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
) -> tuple[BoolArray, FloatArray]:
    """(K,) errors against the direct or the mirrored truth, whichever is nearer on average.

    Of those of the N vertices whose partner the target has; (N,) which these are comes first.
    """
    kept, truths = truths_of(source, target, vertices)
    points = SurfacePoints(points.faces[kept], points.barycentric[kept])
    errors = [surface_errors(target, points, truth) for truth in truths]
    return kept, min(errors, key=lambda one: float(one.mean()))
