"""Geodesic discs {z : d(x, z) <= r} on a mesh, clipped exactly.

The distance from x is interpolated linearly in every triangle. Areas and integrals over a disc then
have closed forms, which are continuous in x and in r.
"""

from collections.abc import Iterator

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.kernel import inlined, kernel
from solver.shape.metrics import Metric

_BLOCK = 64
"""Sources per block of distances, which bounds the memory."""


def distances_from(metric: Metric, vertices: IntArray) -> Iterator[tuple[slice, FloatArray]]:
    """Distances from some vertices to all, a block of sources at a time.

    Parameters
    ----------
    metric
        Metric of the shape.
    vertices
        (S,) int64 sources.

    Yields
    ------
    rows : slice of the sources in the block.
    distances : (rows, V) float64.
    """
    for start in range(0, len(vertices), _BLOCK):
        rows = slice(start, min(start + _BLOCK, len(vertices)))
        yield rows, np.ascontiguousarray(metric.distances(vertices[rows]))


@kernel
def annulus_areas(
    distances: FloatArray, faces: IntArray, areas: FloatArray, radius: float, bins: int
) -> FloatArray:
    """Areas of concentric annuli of equal width.

    Parameters
    ----------
    distances
        (S, V) from each centre to all vertices; faces with infinite ones are left out.
    faces
        (F, 3).
    areas
        (F,) of the faces.
    radius
        Outer radius of the last annulus.
    bins
        Number B of annuli; the first is a disc.

    Returns
    -------
    (S, B) float64
    """
    result = np.zeros((len(distances), bins))
    width = radius / bins
    for row in range(len(distances)):
        for face in range(len(faces)):
            near, middle, far = _ascending(distances[row], faces[face])
            if not (near < radius and far < np.inf):
                continue
            inside = 0.0
            for annulus in range(int(near / width), bins):
                share = _share_within((annulus + 1) * width, near, middle, far)
                result[row, annulus] += areas[face] * (share - inside)
                inside = share
                if share >= 1.0:
                    break
    return result


@kernel
def disc_weights(
    distances: FloatArray, faces: IntArray, areas: FloatArray, radius: float
) -> FloatArray:
    """Integrals of the vertices' hat functions over geodesic discs.

    The integral over disc s of a function that is linear in every triangle is ``weights[s] @ f``,
    f its values at the vertices; the sum of ``weights[s]`` is the disc's area.

    Parameters
    ----------
    distances
        (S, V) from each centre to all vertices; faces with infinite ones are left out.
    faces
        (F, 3).
    areas
        (F,) of the faces.
    radius
        Radius of the discs.

    Returns
    -------
    (S, V) float64, nonnegative.
    """
    result = np.zeros(distances.shape)
    for row in range(len(distances)):
        for face in range(len(faces)):
            a, b, c = faces[face]
            # Sort the corners by distance.
            if distances[row, b] < distances[row, a]:
                a, b = b, a
            if distances[row, c] < distances[row, b]:
                b, c = c, b
            if distances[row, b] < distances[row, a]:
                a, b = b, a
            near, middle, far = distances[row, a], distances[row, b], distances[row, c]
            if not (near < radius and far < np.inf):
                continue
            third = areas[face] / 3.0
            if radius >= far:
                result[row, a] += third
                result[row, b] += third
                result[row, c] += third
            elif radius <= middle:
                # The triangle clipped at a; its other corners are a + p (b - a) and a + q (c - a).
                p, q = (radius - near) / (middle - near), (radius - near) / (far - near)
                corner = third * p * q
                result[row, a] += corner * (3.0 - p - q)
                result[row, b] += corner * p
                result[row, c] += corner * q
            else:
                # The face without the triangle clipped at c.
                p, q = (far - radius) / (far - near), (far - radius) / (far - middle)
                corner = third * p * q
                result[row, a] += third - corner * p
                result[row, b] += third - corner * q
                result[row, c] += third - corner * (3.0 - p - q)
    return result


@inlined
def _ascending(distances: FloatArray, face: IntArray) -> tuple[float, float, float]:
    """Distances of a face's corners in ascending order."""
    a, b, c = distances[face[0]], distances[face[1]], distances[face[2]]
    near, far = min(a, b, c), max(a, b, c)
    return near, max(min(a, b), min(max(a, b), c)), far


@inlined
def _share_within(radius: float, near: float, middle: float, far: float) -> float:
    """Share of a triangle's area where a linear function, given at the corners, is <= radius."""
    if radius >= far:
        return 1.0
    if radius <= near:
        return 0.0
    if radius <= middle:
        return (radius - near) ** 2 / ((middle - near) * (far - near))
    return 1.0 - (far - radius) ** 2 / ((far - near) * (far - middle))
