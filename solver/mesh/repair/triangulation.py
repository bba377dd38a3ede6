"""Polygons into triangles: quadrilaterals by their better diagonal, others by ear clipping.

A polygon is seen in its plane; for one that is not flat, in the plane across its vector area. A
corner is an *ear* if it is convex and no other corner lies in the triangle that it makes with its
two neighbours. Every simple polygon has two (Meisters, Amer. Math. Monthly 82, 1975), so cutting
ears leaves n - 2 triangles that cover it once, whether it is convex or not. The best shaped ear is
cut each time.
"""

from dataclasses import dataclass

import numpy as np

from solver.arrays import BoolArray, FloatArray, IntArray
from solver.errors import MeshError
from solver.kernel import kernel

MOST_CORNERS = 5000
"""The time to cut a polygon grows with the square of its corners: some 0.1 s for these."""

_MOST_STEPS = 1_000_000_000
"""Looks at corners while polygons are cut, all together: some seconds."""

_CONVEX = 1e-9
"""Twice a triangle's area over its longest edge squared, from which it turns the right way."""

_ROUNDING = 1e-12
"""Twice the area, in a polygon of size 1, of a triangle whose corners lie on a line."""


@dataclass(frozen=True, eq=False)
class Triangulation:
    """Triangles that polygons were cut into.

    Parameters
    ----------
    triangles
        (sum of n - 2, 3) vertex indices, polygon after polygon, oriented as these.
    crossed
        Number of polygons that cannot be cut without overlaps, since their outlines cross
        themselves.
    """

    triangles: IntArray
    crossed: int


def triangulated(vertices: FloatArray, sizes: IntArray, corners: IntArray) -> Triangulation:
    """Cut polygons into triangles.

    Parameters
    ----------
    vertices
        (V, 3), finite where polygons use them.
    sizes
        (P,) number of corners of each polygon, at least 3.
    corners
        (sum of `sizes`,) vertex indices of the polygons, one after the other.

    Raises
    ------
    MeshError
        A polygon has more than `MOST_CORNERS` corners, or all together so many that cutting them
        would take minutes.
    """
    if len(sizes) and sizes.max() > MOST_CORNERS:
        raise MeshError(
            f"face {int(np.argmax(sizes))} has {sizes.max()} corners, more than {MOST_CORNERS}; "
            "cut it into triangles before"
        )
    first = np.cumsum(sizes) - sizes
    offset = np.cumsum(sizes - 2) - (sizes - 2)
    triangles = np.empty((int((sizes - 2).sum()), 3), dtype=np.int64)
    three = sizes == 3
    triangles[offset[three]] = corners[first[three][:, None] + np.arange(3)]
    crossed = _halve(vertices, sizes == 4, first, offset, corners, triangles)
    many = np.flatnonzero(sizes > 4)
    if len(many):
        # So much it takes at least.
        if (sizes[many] * (sizes[many] - 2)).sum() > _MOST_STEPS:
            raise _too_many_corners(sizes)
        own = np.concatenate([np.arange(first[p], first[p] + sizes[p]) for p in many])
        flat = _in_their_planes(vertices[corners[own]], sizes[many])
        cut = _clip_all(flat, corners[own], sizes[many], offset[many], triangles)
        if cut < 0:
            raise _too_many_corners(sizes)
        crossed += cut
    return Triangulation(triangles, crossed)


def _too_many_corners(sizes: IntArray) -> MeshError:
    return MeshError(
        f"the faces, of up to {sizes.max()} corners, would take minutes to be cut into triangles; "
        "save the mesh as triangles"
    )


def _halve(
    vertices: FloatArray,
    four: BoolArray,
    first: IntArray,
    offset: IntArray,
    corners: IntArray,
    triangles: IntArray,
) -> int:
    """Cut quadrilaterals along the shorter diagonal if both lie inside, else along that which does.

    Which corner the file names first does not matter.
    """
    quads = corners[first[four][:, None] + np.arange(4)]
    if not len(quads):
        return 0
    points = vertices[quads] - vertices[quads[:, :1]]
    points /= np.maximum(np.abs(points).max(axis=(1, 2), keepdims=True), np.finfo(float).tiny)
    across = points[:, 2:] - points[:, :2]
    normal = np.cross(across[:, 0], across[:, 1])
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), np.finfo(float).tiny)
    ways = np.array([[[0, 1, 2], [0, 2, 3]], [[1, 2, 3], [1, 3, 0]]])
    a, b, c = np.moveaxis(points[:, ways], 3, 0)  # each (Q, 2 ways, 2 triangles, 3)
    cross = np.cross(b - a, c - a)
    turn = np.einsum("qwti,qi->qwt", cross, normal)
    longest = np.max([((p - q) ** 2).sum(axis=3) for p, q in ((a, b), (b, c), (c, a))], axis=0)
    worst = (turn / np.maximum(longest, np.finfo(float).tiny)).min(axis=2)
    lengths = np.linalg.norm(across, axis=2)
    shorter = lengths[:, 1] < lengths[:, 0] * (1.0 - 1e-9)
    second = np.where((worst > _CONVEX).all(axis=1), shorter, worst[:, 1] > worst[:, 0])
    cut = quads[np.arange(len(quads))[:, None, None], ways[second.astype(np.int64)]]
    triangles[offset[four]], triangles[offset[four] + 1] = cut[:, 0], cut[:, 1]
    # Halves that face each other, whichever way the quadrilateral is cut.
    facing = np.einsum("qwi,qwi->qw", cross[:, :, 0], cross[:, :, 1])
    return int((facing < -_ROUNDING).all(axis=1).sum())


def _in_their_planes(points: FloatArray, sizes: IntArray) -> FloatArray:
    """(n, 2) coordinates of polygons' corners, in which they run counterclockwise, of size 1."""
    start = np.cumsum(sizes) - sizes
    owner = np.repeat(np.arange(len(sizes)), sizes)
    centred = points - points[start][owner]
    size = np.maximum.reduceat(np.abs(centred).max(axis=1), start)
    centred /= np.maximum(size, np.finfo(float).tiny)[owner, None]
    following = np.arange(1, len(points) + 1)
    following[start + sizes - 1] = start
    normal = np.add.reduceat(np.cross(centred, centred[following]), start)
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), np.finfo(float).tiny)
    # Any direction that is not the normal's leads to a basis of the plane.
    helper = np.eye(3)[np.argmin(np.abs(normal), axis=1)]
    right = np.cross(helper, normal)
    right /= np.maximum(np.linalg.norm(right, axis=1, keepdims=True), np.finfo(float).tiny)
    up = np.cross(normal, right)
    x, y = (np.einsum("ij,ij->i", centred, axis[owner]) for axis in (right, up))
    return np.stack([x, y], axis=1)


@kernel
def _clip_all(
    flat: FloatArray, corners: IntArray, sizes: IntArray, offset: IntArray, triangles: IntArray
) -> int:
    """Cut polygons one after the other, and count those whose outlines cross themselves.

    -1 if that takes too long.
    """
    crossed, start = 0, 0
    left = np.array([_MOST_STEPS])
    for polygon in range(len(sizes)):
        end = start + sizes[polygon]
        out = triangles[offset[polygon] : offset[polygon] + sizes[polygon] - 2]
        crossed += _clip(flat[start:end], corners[start:end], out, left)
        if left[0] < 0:
            return -1
        start = end
    return crossed


@kernel
def _clip(flat: FloatArray, corners: IntArray, out: IntArray, left: IntArray) -> int:
    """Cut one polygon; 1 if a corner had to be cut that is no ear, or there is no time `left`."""
    n = len(flat)
    before, after = np.empty(n, np.int64), np.empty(n, np.int64)
    for i in range(n):
        before[i], after[i] = (i - 1) % n, (i + 1) % n
    quality = np.empty(n)
    for i in range(n):
        quality[i] = _ear_quality(flat, i, before, after, left)
    forced, stale = 0, False
    for row in range(n - 2):
        left[0] -= n
        if left[0] < 0:
            return 1
        best = _greatest(quality)
        if quality[best] < 0.0 and stale:
            # What lay in an ear may have been cut away since it was looked at.
            for i in range(n):
                if quality[i] > -np.inf:
                    quality[i] = _ear_quality(flat, i, before, after, left)
            best = _greatest(quality)
            stale = False
        if quality[best] < 0.0:
            forced = 1
        a, b = before[best], after[best]
        out[row, 0], out[row, 1], out[row, 2] = corners[a], corners[best], corners[b]
        after[a], before[b] = b, a
        quality[best] = -np.inf
        quality[a] = _ear_quality(flat, a, before, after, left)
        quality[b] = _ear_quality(flat, b, before, after, left)
        stale = True
    return forced


@kernel
def _greatest(values: FloatArray) -> int:
    best = 0
    for i in range(1, len(values)):
        if values[i] > values[best]:
            best = i
    return best


@kernel
def _ear_quality(
    flat: FloatArray, i: int, before: IntArray, after: IntArray, left: IntArray
) -> float:
    """Shape of the ear at corner i, 0 (flat) to 1 (equilateral); negative if it is none."""
    a, b, c = before[i], i, after[i]
    turn = _turn(flat, a, b, c)
    longest = max(_square(flat, a, b), _square(flat, b, c), _square(flat, c, a))
    if longest == 0.0:
        return 0.0
    shape: float = turn / longest * 1.1547005383792515
    if shape < -_ROUNDING:
        return shape - 1.0
    j = after[c]
    while j != a:
        left[0] -= 1
        # Only corners that are not convex can be the first to reach into an ear.
        if _turn(flat, before[j], j, after[j]) <= _ROUNDING and _inside(flat, j, a, b, c):
            return -1.0
        j = after[j]
    return max(shape, 0.0)


@kernel
def _inside(flat: FloatArray, j: int, a: int, b: int, c: int) -> bool:
    """Whether corner j lies in a triangle or on its rim, but not where one of its corners does."""
    for corner in (a, b, c):
        if flat[j, 0] == flat[corner, 0] and flat[j, 1] == flat[corner, 1]:
            return False
    least = min(_turn(flat, a, b, j), _turn(flat, b, c, j), _turn(flat, c, a, j))
    return least >= -_ROUNDING


@kernel
def _turn(flat: FloatArray, a: int, b: int, c: int) -> float:
    """Twice the signed area of a triangle."""
    turn: float = (flat[b, 0] - flat[a, 0]) * (flat[c, 1] - flat[a, 1]) - (
        flat[b, 1] - flat[a, 1]
    ) * (flat[c, 0] - flat[a, 0])
    return turn


@kernel
def _square(flat: FloatArray, a: int, b: int) -> float:
    square: float = (flat[a, 0] - flat[b, 0]) ** 2 + (flat[a, 1] - flat[b, 1]) ** 2
    return square
