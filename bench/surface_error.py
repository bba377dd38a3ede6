"""Errors of matched surface points, at vertices or between them, against the known truth."""

import numpy as np
from scipy.spatial import KDTree

from bench.collection import KnownShape
from solver.arrays import FloatArray, IntArray
from solver.gmds import InterpolatedMetric, SurfacePoints


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
    places = source.shape.surface.vertices
    nearest = np.asarray(KDTree(places[source.truth]).query(places[vertices])[1])
    known = target.truth, target.symmetric_truth
    return [truth[nearest] for truth in known if truth is not None]


def surface_errors(target: KnownShape, points: SurfacePoints, truth: IntArray) -> FloatArray:
    """(N,) geodesic distances over √area of N points from (N,) vertices of the target."""
    surface = target.shape.surface
    edges = InterpolatedMetric(target.shape.metric("geodesic"), surface).edges[points.faces]
    rows = target.shape.metric("geodesic").distances(truth)
    squares = np.take_along_axis(rows, surface.faces[points.faces], axis=1) ** 2
    a, b, c = points.barycentric.T
    inner = b * c * edges[:, 0] + c * a * edges[:, 1] + a * b * edges[:, 2]
    apart = (squares * points.barycentric).sum(axis=1) - inner
    errors: FloatArray = np.sqrt(np.maximum(apart, 0.0)) / target.shape.size
    return errors


def better_errors(
    source: KnownShape, target: KnownShape, vertices: IntArray, points: SurfacePoints
) -> FloatArray:
    """(N,) errors against the direct or the mirrored truth, whichever is nearer on average."""
    errors = [surface_errors(target, points, t) for t in truths_of(source, target, vertices)]
    return min(errors, key=lambda one: float(one.mean()))
