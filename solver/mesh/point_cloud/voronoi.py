"""Local Delaunay triangles round each point of a cloud, as the dual of its Voronoi cell.

In the tangent plane of a point, the bisectors with its neighbours cut its Voronoi cell out of a
square. Neighbours whose bisectors are successive sides of the cell form a Delaunay triangle with
the point. The square is as wide as the neighbours reach: the circumcircle of a triangle is centred
at a corner of the cell, and only if it lies within reach, all points in it are known to be seen.
Compare Sharp and Crane, "A Laplacian for Nonmanifold Triangle Meshes", SGP 2020, section 5.7.
"""

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.kernel import kernel

_MOST_SIDES = 64

_STEEPEST = 0.5
"""Cosine of the angle to the tangent plane from which on a neighbour is on another sheet."""

_OUTSIDE = -1
"""In place of a neighbour, a side of the square."""


def local_triangles(points: FloatArray, neighbours: IntArray, normals: FloatArray) -> IntArray:
    """Delaunay triangles of each point with its neighbours, in its tangent plane.

    Parameters
    ----------
    points
        (V, 3).
    neighbours
        (V, k) nearest points, the nearest first, without the point itself.
    normals
        (V, 3) unit normals, of any sign.

    Returns
    -------
    (T, 3) int64 corners, the point itself first. A triangle is there for each of its points in
    whose tangent plane it is Delaunay, so three times where the surface is flat.
    """
    axes = np.eye(3)[np.argmin(np.abs(normals), axis=1)]
    along = np.cross(normals, axes)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    ways = points[neighbours] - points[:, None]
    x = np.einsum("vki,vi->vk", ways, along)
    y = np.einsum("vki,vi->vk", ways, np.cross(normals, along))
    lengths, flat = np.linalg.norm(ways, axis=2), np.hypot(x, y)
    # Unrolled: as far as in space, so that what is on another sheet is no nearer.
    stretch = np.where(flat > _STEEPEST * lengths, lengths / np.maximum(flat, 1e-300), 0.0)
    return _dual_triangles(x * stretch, y * stretch, 0.5 * lengths[:, -1], neighbours)


@kernel
def _dual_triangles(
    x: FloatArray, y: FloatArray, half: FloatArray, neighbours: IntArray
) -> IntArray:
    """Triangles of points with neighbours at (x, y), 0 for none; `half` is half of the square."""
    count, reach = neighbours.shape
    found, total = np.empty((8 * count, 3), dtype=np.int64), 0
    corners, sides = np.empty((_MOST_SIDES, 2)), np.empty(_MOST_SIDES, dtype=np.int64)
    spare, spare_sides = np.empty((_MOST_SIDES, 2)), np.empty(_MOST_SIDES, dtype=np.int64)
    for here in range(count):
        size = 4
        for corner in range(4):
            corners[corner, 0] = half[here] if corner == 0 or corner == 3 else -half[here]
            corners[corner, 1] = half[here] if corner < 2 else -half[here]
            sides[corner] = _OUTSIDE
        for place in range(reach):
            u, v = x[here, place], y[here, place]
            if (u != 0.0 or v != 0.0) and size + 1 < _MOST_SIDES:
                other = neighbours[here, place]
                size = _cut(u, v, other, corners, sides, size, spare, spare_sides)
        for side in range(size):
            a, b = sides[side], sides[(side + 1) % size]
            if a != _OUTSIDE and b != _OUTSIDE and total < len(found):
                found[total, 0], found[total, 1], found[total, 2] = here, a, b
                total += 1
    return found[:total]


@kernel
def _cut(
    x: float,
    y: float,
    other: int,
    corners: FloatArray,
    sides: IntArray,
    size: int,
    spare: FloatArray,
    spare_sides: IntArray,
) -> int:
    """Cut off what is nearer to (x, y) than to the origin; return the new number of sides.

    Side i runs from corner i to the next. `spare` and `spare_sides` are overwritten.
    """
    level, left = 0.5 * (x * x + y * y), 0
    for side in range(size):
        after = (side + 1) % size
        here = corners[side, 0] * x + corners[side, 1] * y - level
        there = corners[after, 0] * x + corners[after, 1] * y - level
        if here <= 0.0:
            spare[left, 0], spare[left, 1] = corners[side, 0], corners[side, 1]
            spare_sides[left] = sides[side]
            left += 1
        if (here <= 0.0) != (there <= 0.0):
            t = here / (here - there)
            spare[left, 0] = corners[side, 0] + t * (corners[after, 0] - corners[side, 0])
            spare[left, 1] = corners[side, 1] + t * (corners[after, 1] - corners[side, 1])
            # The bisector begins where it leaves the cell, and ends where it enters it.
            spare_sides[left] = other if here <= 0.0 else sides[side]
            left += 1
    for side in range(left):
        corners[side, 0], corners[side, 1] = spare[side, 0], spare[side, 1]
        sides[side] = spare_sides[side]
    return left
