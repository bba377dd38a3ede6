"""Polygons into triangles: quadrilaterals by their better diagonal, others by ear clipping.

Every simple polygon has an *ear*, a convex corner whose triangle with its two neighbours holds no
other corner (Meisters, Amer. Math. Monthly 82, 1975). Cutting ears leaves n - 2 triangles that
cover the polygon once, whether it is convex or not. mapbox's earcut does it, in the plane of the
polygon; for one that is not planar, in the plane across its vector area.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from mapbox_earcut import triangulate_float64

from solver.arrays import BoolArray, FloatArray, IntArray
from solver.errors import MeshError

MOST_CORNERS = 5000
"""Corners of a polygon: the time to cut one grows with their square, and for the worst outline of
this many, a star that crosses itself 2,000 times over, it is 2 s."""

_MOST_SQUARES = 250_000_000
"""Corners squared, summed over all polygons of a mesh: ten of the largest."""

_CONVEX = 1e-9
"""Twice a triangle's area over its longest edge squared, from which it turns the right way."""

_ROUNDING = 1e-12
"""Twice the area, in a polygon of size 1, of a triangle whose corners lie on a line."""

_INWARDS = 1e-9
"""Displacement of corners on straight sides of a polygon of size 1, while it is cut."""


@dataclass(frozen=True, eq=False)
class Triangulation:
    """Triangles that polygons were cut into.

    Parameters
    ----------
    triangles
        (sum of n - 2, 3) int64, vertex indices, polygon after polygon, oriented as these.
    crossed
        Number of polygons whose triangles overlap, since their outlines cross themselves.
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
        could take minutes.
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
    many = sizes > 4
    if (sizes[many] ** 2).sum() > _MOST_SQUARES:
        raise MeshError(
            f"the faces, of up to {sizes.max()} corners, would take minutes to be cut into "
            "triangles; save the mesh as triangles"
        )
    if many.any():
        own = corners[np.repeat(many, sizes)]
        cut, overlapping = _clipped(_in_their_planes(vertices[own], sizes[many]), sizes[many])
        triangles[np.repeat(many, sizes - 2)] = own[cut]
        crossed += overlapping
    return Triangulation(triangles, crossed)


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
    normal = np.add.reduceat(np.cross(centred, centred[_following(sizes)]), start)
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), np.finfo(float).tiny)
    # Any direction that is not the normal's leads to a basis of the plane.
    other = np.eye(3)[np.argmin(np.abs(normal), axis=1)]
    right = np.cross(other, normal)
    right /= np.maximum(np.linalg.norm(right, axis=1, keepdims=True), np.finfo(float).tiny)
    up = np.cross(normal, right)
    x, y = (np.einsum("ij,ij->i", centred, axis[owner]) for axis in (right, up))
    return np.stack([x, y], axis=1)


def _clipped(flat: FloatArray, sizes: IntArray) -> tuple[IntArray, int]:
    """(sum of n - 2, 3) triangles of polygons in the plane, and how many have some that overlap."""
    bent = _with_straight_sides_bent(flat, sizes)
    start = np.cumsum(sizes) - sizes
    counts = sizes.astype(np.uint32)
    cuts = []
    for number, (first, size) in enumerate(zip(start.tolist(), sizes.tolist(), strict=True)):
        cut = triangulate_float64(bent[first : first + size], counts[number : number + 1])
        if len(cut) != 3 * (size - 2):
            cut = _completed(cut.reshape(-1, 3), size)
        cuts.append(cut.reshape(-1, 3) + first)
    triangles = np.concatenate(cuts).astype(np.int64)
    turned = _turns(*np.moveaxis(flat[triangles], 1, 0)) < -_ROUNDING
    return triangles, int(np.logical_or.reduceat(turned, np.cumsum(sizes - 2) - sizes + 2).sum())


def _completed(cut: npt.NDArray[np.uint32], size: int) -> npt.NDArray[np.uint32]:
    """Triangles of a polygon of which earcut left some out, so that all its sides are sides."""
    used = set(cut.flat)
    lost = [corner for corner in range(size) if corner not in used]
    if not used or len(cut) + len(lost) != size - 2:
        # The outline crosses itself, or has no area.
        return np.array([[0, k, k + 1] for k in range(1, size - 1)], dtype=np.uint32)
    # Of consecutive corners in one place, it takes one.
    after = {c: next(k % size for k in range(c + 1, c + size) if k % size in used) for c in lost}
    flat = [[(corner - 1) % size, corner, after[corner]] for corner in lost]
    return np.vstack([cut, np.array(flat, dtype=np.uint32)])


def _with_straight_sides_bent(flat: FloatArray, sizes: IntArray) -> FloatArray:
    """Corners within straight sides moved inwards, the more the farther they are from the ends.

    An ear there would be a triangle without area, whose removal leaves a T-junction.
    """
    following = _following(sizes)
    after = flat[following]
    before = np.empty_like(flat)
    before[following] = flat
    straight = np.abs(_turns(before, flat, after)) <= _ROUNDING
    straight &= (flat != before).any(axis=1) & (flat != after).any(axis=1)
    along = after - before
    inwards = np.stack([-along[:, 1], along[:, 0]], axis=1)
    inwards /= np.maximum(np.linalg.norm(along, axis=1, keepdims=True), np.finfo(float).tiny)
    # Concave along every line, and positive within a polygon of size 1.
    distance = _INWARDS * (4.0 - (flat**2).sum(axis=1, keepdims=True))
    return np.where(straight[:, None], flat + distance * inwards, flat)


def _following(sizes: IntArray) -> IntArray:
    """(n,) the corner after each corner of polygons."""
    following = np.arange(1, sizes.sum() + 1)
    ends = np.cumsum(sizes)
    following[ends - 1] = ends - sizes
    return following


def _turns(a: FloatArray, b: FloatArray, c: FloatArray) -> FloatArray:
    """Twice the signed areas of triangles in the plane."""
    u, v = b - a, c - a
    turns: FloatArray = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
    return turns
