"""Intrinsic triangulations: triangles given by the lengths of their sides, and how they are glued.

Flipping an edge of two triangles, laid out in the plane, gives another triangulation of the very
same surface. Flipped until every edge is Delaunay (Bobenko and Springborn, Discrete Comput. Geom.
38, 2007), its triangles are as round as the vertices allow, however thin those of the mesh were.
"""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components

from solver.arrays import BoolArray, FloatArray, IntArray
from solver.kernel import inlined, kernel
from solver.mesh import TriangleMesh

_FLIPS_PER_SIDE = 100
"""Flips end by themselves; on triangles at the limit of precision, nobody can promise when."""


@dataclass(frozen=True, eq=False)
class IntrinsicTriangulation:
    """Triangles by the lengths of their sides.

    Side 3f + k of face f runs from its corner k to the next. A face may meet itself, and an edge
    may have both ends in one vertex.

    Parameters
    ----------
    n_vertices
        Number V of vertices.
    faces
        (F, 3) vertices.
    lengths
        (3F,) of the sides.
    across
        (3F,) the next side that lies on the same edge, round and round: itself at a boundary,
        the other one on most edges, one of several where the surface is not a manifold.
    """

    n_vertices: int
    faces: IntArray
    lengths: FloatArray
    across: IntArray

    @property
    def starts(self) -> IntArray:
        """(3F,) vertex where each side begins."""
        return self.faces.ravel()

    @property
    def ends(self) -> IntArray:
        """(3F,) vertex where each side ends."""
        return self.faces[:, [1, 2, 0]].ravel()

    @property
    def forward(self) -> BoolArray:
        """(3F,) whether each side runs one way along its edge or the other."""
        sides = np.arange(len(self.across))
        same_ends = self.starts == self.ends
        forward: BoolArray = np.where(same_ends, sides < self.across, self.starts < self.ends)
        return forward

    def apexes(self) -> FloatArray:
        """(3F, 2) third corner of each side's face: along the side from its start, and above."""
        base = self.lengths
        opposite, left = base.reshape(-1, 3)[:, [1, 2, 0]], base.reshape(-1, 3)[:, [2, 0, 1]]
        return _apexes(base, left.ravel(), opposite.ravel())

    def delaunay(self) -> "IntrinsicTriangulation":
        """Return the intrinsic Delaunay triangulation, or as near to it as precision allows.

        Edges of more than two triangles stay, and those of two that run along them in the same
        direction.
        """
        faces, lengths, across = self.faces.copy(), self.lengths.copy(), self.across.copy()
        _flip_to_delaunay(faces, lengths, across, _FLIPS_PER_SIDE * len(across))
        return IntrinsicTriangulation(self.n_vertices, faces, lengths, across)

    def most_sheets(self) -> int:
        """Greatest number of triangles at an edge."""
        turn, sheets = self.across, 1
        sides = np.arange(len(self.across))
        while (turn != sides).any():
            turn = np.where(turn != sides, self.across[turn], turn)
            sheets += 1
        return sheets

    def irregular_vertices(self) -> IntArray:
        """Vertices round which the triangles do not close to one disc, once each."""
        sides = np.arange(len(self.across))
        across = self.across
        irregular = (across == sides) | (across[across] != sides)
        at_edges = np.r_[self.starts[irregular], self.ends[irregular]]
        return np.union1d(at_edges, self._pinched_vertices())

    def _pinched_vertices(self) -> IntArray:
        """Vertices whose triangles hang together only there; they have several fans."""
        size = len(self.across)
        sides, twins = np.arange(size), self.across
        ahead = sides // 3 * 3 + (sides + 1) % 3
        opposed = self.forward[sides] != self.forward[twins]
        # The corner at which a side begins has the side's number; it ends at the next one's.
        begin = np.where(opposed, ahead[twins], twins)
        end = np.where(opposed, twins, ahead[twins])
        joined = sp.coo_array(
            (np.ones(2 * size), (np.r_[sides, ahead], np.r_[begin, end])), shape=(size, size)
        )
        fan = connected_components(joined, directed=False)[1]
        first = np.unique(fan, return_index=True)[1]
        fans = np.bincount(self.starts[first], minlength=self.n_vertices)
        return np.flatnonzero(fans > 1)


def intrinsic_triangulation(mesh: TriangleMesh) -> IntrinsicTriangulation:
    """Forget where a mesh lies in space.

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
def next_side(side: int) -> int:
    """Next side of the same face."""
    return side + 1 if side % 3 < 2 else side - 2


@inlined
def apex(base: float, left: float, right: float) -> tuple[float, float]:
    """Third corner of a triangle on a base: along it from its left end, and above it (>= 0)."""
    along = 0.5 * (base + (left - right) * (left + right) / base)
    # Kahan's arrangement of Heron's formula, for the height of needles.
    a, c = max(base, left, right), min(base, left, right)
    b = base + left + right - a - c
    squares = (a + (b + c)) * (c - (a - b)) * (c + (a - b)) * (a + (b - c))
    return along, 0.5 * np.sqrt(max(squares, 0.0)) / base


@kernel
def _apexes(base: FloatArray, left: FloatArray, right: FloatArray) -> FloatArray:
    found = np.empty((len(base), 2))
    for side in range(len(base)):
        found[side] = apex(base[side], left[side], right[side])
    return found


@kernel
def _flip_to_delaunay(faces: IntArray, lengths: FloatArray, across: IntArray, most: int) -> int:
    """Flip edges in place until all are Delaunay; the number of flips."""
    pending = np.arange(len(across))
    waits = np.ones(len(across), dtype=np.bool_)
    count, flips = len(across), 0
    while count > 0 and flips < most:
        count -= 1
        side = pending[count]
        waits[side] = False
        if not _flip(faces, lengths, across, side):
            continue
        flips += 1
        face, other = side // 3, across[next_side(side)] // 3
        for corner in range(3):
            for neighbour in (3 * face + corner, 3 * other + corner):
                if not waits[neighbour]:
                    waits[neighbour] = True
                    pending[count] = neighbour
                    count += 1
    return flips


@kernel
def _flip(faces: IntArray, lengths: FloatArray, across: IntArray, side: int) -> bool:
    """Flip a side's edge if its two triangles are more obtuse over it than Delaunay allows."""
    twin = across[side]
    if across[twin] != side or twin // 3 == side // 3:
        return False
    side_next, side_last = next_side(side), next_side(next_side(side))
    twin_next, twin_last = next_side(twin), next_side(next_side(twin))
    start = faces[side // 3, side % 3]
    if start != faces[twin_next // 3, twin_next % 3]:
        return False  # the triangles are not oriented alike
    base = lengths[side]
    x, y = apex(base, lengths[side_last], lengths[side_next])
    other_x, other_y = apex(base, lengths[twin_next], lengths[twin_last])
    if not (y > 0.0 and other_y > 0.0):
        return False
    # Of the angles opposite, the cotangents; their sum is negative if the angles exceed π.
    cotangent = (lengths[side_last] ** 2 - base * x) / (base * y)
    other = (lengths[twin_next] ** 2 - base * other_x) / (base * other_y)
    if cotangent + other >= -1e-10:
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
    """Let a side be known by another number to those on its edge."""
    before = side
    while across[before] != side:
        before = across[before]
    across[before] = place
    if before != side:
        across[place] = across[side]
    else:
        across[place] = place
