"""Intrinsic triangulations: triangles given by their edge lengths and their gluing.

Sharp, Soliman and Crane, "Navigating intrinsic triangulations", ACM TOG 38(4), 2019. Flipping an
edge of two triangles laid out in the plane gives another triangulation of the same polyhedral
surface. The intrinsic Delaunay triangulation, in which no edge can be flipped any more (Bobenko
and Springborn, "A discrete Laplace-Beltrami operator for simplicial surfaces", Discrete Comput.
Geom. 38, 2007), has the roundest triangles that the vertices allow, however thin those of the mesh.
"""

from dataclasses import dataclass

import numpy as np

from solver.arrays import BoolArray, FloatArray, IntArray
from solver.kernel import inlined, kernel
from solver.mesh import TriangleMesh

_FLIPS_PER_SIDE = 100
"""Limit of flips, a safeguard only: flipping terminates in exact arithmetic (Bobenko and Springborn
2007), but this need not hold for triangles that are degenerate in floating point."""

_DELAUNAY_TOLERANCE = 1e-10
"""Least negative cotangent sum that is flipped, without unit: cocircular pairs stay as they are
instead of flipping back and forth by rounding errors."""


@dataclass(frozen=True, eq=False)
class IntrinsicTriangulation:
    """Triangles given by the lengths of their sides.

    Side 3f + k of face f runs from its corner k to the next. A face may be glued to itself, and
    both ends of an edge may be the same vertex.

    Parameters
    ----------
    n_vertices
        Number V of vertices.
    faces
        (F, 3) int64 vertices.
    lengths
        (3F,) float64 of the sides, in the mesh's unit of length.
    across
        (3F,) int64 next side on the same edge, in a cycle: the side itself at a boundary, the
        other side of an interior edge, one of several at a non-manifold edge.
    """

    n_vertices: int
    faces: IntArray
    lengths: FloatArray
    across: IntArray

    @property
    def starts(self) -> IntArray:
        """(3F,) int64 vertex at the start of each side."""
        return self.faces.ravel()

    @property
    def forward(self) -> BoolArray:
        """(3F,) bool, direction of each side along its edge: equal for sides that run alike."""
        sides = np.arange(len(self.across))
        ends = self.faces[:, [1, 2, 0]].ravel()
        forward: BoolArray = np.where(self.starts == ends, sides < self.across, self.starts < ends)
        return forward

    def apexes(self) -> FloatArray:
        """(3F, 2) float64 third corner of each side's face, in the side's frame.

        Coordinates are along the side from its start, and the height above it, >= 0.
        """
        base = self.lengths
        opposite, left = base.reshape(-1, 3)[:, [1, 2, 0]], base.reshape(-1, 3)[:, [2, 0, 1]]
        return _apexes(base, left.ravel(), opposite.ravel())

    def delaunay(self) -> "IntrinsicTriangulation":
        """Return the intrinsic Delaunay triangulation, up to rounding errors.

        Non-manifold edges are not flipped, nor are edges whose two triangles are inconsistently
        oriented.
        """
        faces, lengths, across = self.faces.copy(), self.lengths.copy(), self.across.copy()
        _flip_to_delaunay(faces, lengths, across, _FLIPS_PER_SIDE * len(across))
        return IntrinsicTriangulation(self.n_vertices, faces, lengths, across)


def intrinsic_triangulation(mesh: TriangleMesh) -> IntrinsicTriangulation:
    """Intrinsic triangulation of a mesh by its own triangles.

    Parameters
    ----------
    mesh
        Any mesh.
    """
    starts, ends = mesh.faces.ravel(), mesh.faces[:, [1, 2, 0]].ravel()
    lengths = np.linalg.norm(mesh.vertices[starts] - mesh.vertices[ends], axis=1)
    edge = np.minimum(starts, ends) * mesh.n_vertices + np.maximum(starts, ends)
    order = np.argsort(edge, kind="stable")
    last = np.r_[edge[order][1:] != edge[order][:-1], True]
    first = np.r_[True, last[:-1]]
    across = np.empty_like(order)
    across[order[~last]] = order[1:][~last[:-1]]
    across[order[last]] = order[first]
    return IntrinsicTriangulation(mesh.n_vertices, mesh.faces, lengths, across)


@inlined
def _next_side(side: int) -> int:
    """Next side of the same face, counterclockwise."""
    return side + 1 if side % 3 < 2 else side - 2


@inlined
def _apex(base: float, left: float, right: float) -> tuple[float, float]:
    """Third corner of a triangle with known sides.

    Parameters
    ----------
    base, left, right
        Lengths of the side on the x axis from the origin, and of the sides from its start and
        from its end to the third corner.

    Returns
    -------
    Coordinates of the third corner, the second one >= 0.
    """
    along = 0.5 * (base + (left - right) * (left + right) / base)
    # Heron's formula as arranged by Kahan ("Miscalculating area and angles of a needle-like
    # triangle", 2014), which stays accurate for needles.
    a, c = max(base, left, right), min(base, left, right)
    b = base + left + right - a - c
    squares = (a + (b + c)) * (c - (a - b)) * (c + (a - b)) * (a + (b - c))
    return along, 0.5 * np.sqrt(max(squares, 0.0)) / base


@kernel
def _apexes(base: FloatArray, left: FloatArray, right: FloatArray) -> FloatArray:
    found = np.empty((len(base), 2))
    for side in range(len(base)):
        found[side] = _apex(base[side], left[side], right[side])
    return found


@kernel
def _flip_to_delaunay(faces: IntArray, lengths: FloatArray, across: IntArray, most: int) -> None:
    """Flip edges in place until all are Delaunay, `most` times at most."""
    pending = np.arange(len(across))  # a stack
    is_pending = np.ones(len(across), dtype=np.bool_)
    count, flips = len(across), 0
    while count > 0 and flips < most:
        count -= 1
        side = pending[count]
        is_pending[side] = False
        if not _flip(faces, lengths, across, side):
            continue
        flips += 1
        face, other = side // 3, across[_next_side(side)] // 3
        for corner in range(3):
            for neighbour in (3 * face + corner, 3 * other + corner):
                if not is_pending[neighbour]:
                    is_pending[neighbour] = True
                    pending[count] = neighbour
                    count += 1


@kernel
def _flip(faces: IntArray, lengths: FloatArray, across: IntArray, side: int) -> bool:
    """Flip the edge of a side in place if it is not Delaunay; return whether it was flipped."""
    twin = across[side]
    if across[twin] != side or twin // 3 == side // 3:
        return False
    side_next, side_last = _next_side(side), _next_side(_next_side(side))
    twin_next, twin_last = _next_side(twin), _next_side(_next_side(twin))
    start = faces[side // 3, side % 3]
    if start != faces[twin_next // 3, twin_next % 3]:
        return False  # the triangles are inconsistently oriented
    base = lengths[side]
    x, y = _apex(base, lengths[side_last], lengths[side_next])
    other_x, other_y = _apex(base, lengths[twin_next], lengths[twin_last])
    if not (y > 0.0 and other_y > 0.0):
        return False
    # Delaunay: the angles opposite the edge sum to at most π, their cotangents to at least 0.
    cotangent = (lengths[side_last] ** 2 - base * x) / (base * y)
    other = (lengths[twin_next] ** 2 - base * other_x) / (base * other_y)
    if cotangent + other >= -_DELAUNAY_TOLERANCE:
        return False
    across_x, across_y = x - other_x, y + other_y
    top = faces[side_last // 3, side_last % 3]
    bottom = faces[twin_last // 3, twin_last % 3]
    faces[side_next // 3, side_next % 3] = bottom
    faces[twin_next // 3, twin_next % 3] = top
    _move(across, twin_next, side)
    _move(across, side_next, twin)
    across[side_next], across[twin_next] = twin_next, side_next
    lengths[side], lengths[twin] = lengths[twin_next], lengths[side_next]
    lengths[side_next] = lengths[twin_next] = np.sqrt(across_x**2 + across_y**2)
    return True


@inlined
def _move(across: IntArray, side: int, place: int) -> None:
    """Replace side `side` by `place` in the cycle of its edge."""
    before = side
    while across[before] != side:
        before = across[before]
    across[before] = place
    if before != side:
        across[place] = across[side]
    else:
        across[place] = place
