"""Exact geodesic distances on a polyhedral surface, by windows.

A shortest path is straight where triangles unfold and turns only at vertices whose angles exceed
2π, or at the boundary (Mitchell, Mount and Papadimitriou, SIAM J. Comput. 16, 1987). A window is
a part of an edge together with the point from which straight lines, through the triangles
unfolded so far, reach it: the source, or a vertex where paths turn. Windows are carried from edge
to edge across triangles. Those whose lines cannot be shortest paths are dropped: at the corner
opposite an edge only the nearest window splits (Chen and Han, Int. J. Comput. Geom. Appl. 6,
1996), and a window that vertices known already reach sooner ends (Xin and Wang, ACM TOG 28,
2009). They wait in buckets of about equal distance, not in one queue (Xu, Wang, Liu, Liu and He,
IEEE TVCG 21, 2015).
"""

from typing import NamedTuple

import numpy as np

from solver.arrays import BoolArray, FloatArray, IntArray
from solver.kernel import inlined, kernel
from solver.mesh import TriangleMesh
from solver.shape.geodesics.front import (
    Front,
    Window,
    is_at_rest,
    new_front,
    put_vertex,
    put_window,
    take,
    window_in,
)
from solver.shape.geodesics.interface import checked_sources
from solver.shape.geodesics.intrinsic import (
    IntrinsicTriangulation,
    intrinsic_triangulation,
    next_side,
)

_STEPS = 1_000_000
"""Windows carried on before the compiled loop looks up, for the caller's signals to be handled."""

_EPSILON = 1e-12
"""Relative rounding error of distances: what is worse by less may be as good."""

_MARGIN = 1e-10
"""Of a side's length: a line so near to the end of a window may as well be in it."""

_TURN = 2.0 * np.pi - 1e-9
"""Angles at a vertex from which on shortest paths may turn there."""

_SLOTS = 4096
"""Room for windows, to begin with."""


class ExactGeodesics:
    """Exact distances on the polyhedral surface.

    Parameters
    ----------
    mesh
        Any mesh.
    """

    def __init__(self, mesh: TriangleMesh) -> None:
        # Thin triangles are crossed by more windows, and with larger rounding errors.
        triangulation = intrinsic_triangulation(mesh).delaunay()
        self._surface = surface_of(triangulation)
        self._front = new_front(_SLOTS, 0.5 * float(triangulation.lengths.mean()))
        # What one step may add: a window and a vertex for each triangle beyond each side of a fan.
        fan = int(np.diff(self._surface.fans).max())
        self._spare = 2 * fan * triangulation.most_sheets()

    @property
    def n_vertices(self) -> int:
        """Number V of vertices."""
        return len(self._surface.turns)

    def distances(self, sources: IntArray) -> FloatArray:
        """(S, V) exact distances from (S,) vertices to all, but for rounding errors."""
        known = checked_sources(sources, self.n_vertices)
        found = np.full((len(known), self.n_vertices), np.inf)
        for row, source in zip(found, known, strict=True):
            self._search(row, int(source))
        return found

    def _search(self, distances: FloatArray, source: int) -> None:
        splits = np.full((len(self._surface.across), 2), np.inf)
        distances[source] = 0.0
        front = self._front
        front.clear()
        put_vertex(front, source, 0.0)
        while front.waiting:
            if front.room < self._spare:
                front = front.doubled()
            advance(self._surface, front, splits, distances, self._spare, _STEPS)
        self._front = front


class Surface(NamedTuple):
    """What the compiled loops need of a triangulation."""

    faces: IntArray
    """(F, 3) vertices."""
    lengths: FloatArray
    """(3F,) of the sides."""
    apexes: FloatArray
    """(3F, 2) third corner over each side."""
    across: IntArray
    """(3F,) next side on the same edge."""
    forward: BoolArray
    """(3F,) which way each side runs along its edge."""
    fans: IntArray
    """(V + 1,) where the sides that begin at each vertex begin in `spokes`."""
    spokes: IntArray
    """(3F,) the sides, by the vertex where they begin."""
    turns: BoolArray
    """(V,) whether shortest paths may turn there."""


def surface_of(triangulation: IntrinsicTriangulation) -> Surface:
    """Prepare a triangulation for the compiled loops."""
    starts, apexes = triangulation.starts, triangulation.apexes()
    spokes = np.argsort(starts, kind="stable")
    angles = np.arctan2(apexes[:, 1], apexes[:, 0])
    turns = np.bincount(starts, angles, triangulation.n_vertices) > _TURN
    turns[triangulation.irregular_vertices()] = True
    return Surface(
        triangulation.faces,
        triangulation.lengths,
        apexes,
        triangulation.across,
        triangulation.forward,
        np.searchsorted(starts[spokes], np.arange(triangulation.n_vertices + 1)),
        spokes,
        turns,
    )


@kernel
def advance(
    surface: Surface,
    front: Front,
    splits: FloatArray,
    distances: FloatArray,
    spare: int,
    steps: int,
) -> None:
    """Carry windows on until none is left, there is no room for more, or steps are used up.

    Parameters
    ----------
    surface
        The triangulation.
    front
        Windows to be carried on, and vertices from which lines start anew.
    splits
        (3F, 2) of the window that splits at the corner opposite each side: the corner's distance
        through it, and where the line there crosses the side; ``inf`` before there is one.
    distances
        (V,) so far.
    spare
        Windows that one step may add.
    steps
        Windows to be carried on at most.
    """
    for _ in range(steps):
        if is_at_rest(front, spare):
            return
        slot = take(front)
        if front.sides[slot, 0] < 0:
            _spread(surface, front, distances, front.sides[slot, 1], front.windows[slot, 4])
        else:
            _carry(surface, front, splits, distances, slot)


@inlined
def _reach(
    surface: Surface, front: Front, distances: FloatArray, vertex: int, found: float
) -> None:
    """Lower a vertex's distance, and let lines start from there if paths may turn."""
    if found < distances[vertex] * (1.0 - _EPSILON):
        distances[vertex] = found
        if surface.turns[vertex]:
            put_vertex(front, vertex, found)


@inlined
def _spread(
    surface: Surface, front: Front, distances: FloatArray, vertex: int, distance: float
) -> None:
    """Let straight lines start from a vertex into all its triangles."""
    if distance > distances[vertex]:
        return
    for place in range(surface.fans[vertex], surface.fans[vertex + 1]):
        side = surface.spokes[place]
        opposite = next_side(side)
        last = next_side(opposite)
        faces, lengths = surface.faces, surface.lengths
        found = distance + lengths[side]
        _reach(surface, front, distances, faces[opposite // 3, opposite % 3], found)
        found = distance + lengths[last]
        _reach(surface, front, distances, faces[last // 3, last % 3], found)
        x, y = surface.apexes[opposite, 0], surface.apexes[opposite, 1]
        _cross(surface, front, opposite, True, vertex, (0.0, lengths[opposite], x, y, distance))


@inlined
def _carry(
    surface: Surface, front: Front, splits: FloatArray, distances: FloatArray, slot: int
) -> None:
    """Carry a window across its triangle, to the other two sides."""
    side, origin = front.sides[slot, 0], front.sides[slot, 1]
    low, high, x, y, start = window_in(front, slot)
    if start > distances[origin]:
        return
    right = next_side(side)
    left = next_side(right)
    base = surface.lengths[side]
    along, above = surface.apexes[side, 0], surface.apexes[side, 1]
    if not above > 0.0:
        return
    crossing = (x * above + along * y) / (above + y)
    leftwards, rightwards = low < crossing, crossing < high
    margin = _MARGIN * base
    if low - margin <= crossing <= high + margin:
        found = start + np.sqrt((along - x) ** 2 + (above + y) ** 2)
        _reach(surface, front, distances, surface.faces[left // 3, left % 3], found)
        # A window that merely ends at the corner has nothing to say about what is beyond.
        if low + margin < crossing < high - margin:
            if found < splits[side, 0]:
                splits[side, 0], splits[side, 1] = found, crossing
            elif found > splits[side, 0] * (1.0 + _EPSILON):
                # The nearer one's lines are shorter at the corner and all over their side of it.
                leftwards = crossing < splits[side, 1]
                rightwards = not leftwards
    if leftwards:
        window = (low, min(high, crossing), x, y, start)
        _cast(surface, front, distances, left, False, origin, along, above, window)
    if rightwards:
        window = (base - high, base - max(low, crossing), base - x, y, start)
        _cast(surface, front, distances, right, True, origin, base - along, above, window)


@inlined
def _cast(
    surface: Surface,
    front: Front,
    distances: FloatArray,
    edge: int,
    outward: bool,
    origin: int,
    along: float,
    above: float,
    window: Window,
) -> None:
    """Cast the lines through a window onto an edge from its side's near end to the apex.

    The window is in the frame of its side, with the near end at 0; the edge is `outward` if it
    runs from there to the apex.
    """
    low, high, x, y, start = window
    length = surface.lengths[edge]
    over, up = along / length, above / length
    first = _meeting(low, x, y, over, up, length) if low > 0.0 else 0.0
    last = _meeting(high, x, y, over, up, length)
    if last - first <= _EPSILON * length:
        return
    after = next_side(edge)
    third = next_side(after)
    near, apex, base = edge, after, surface.lengths[third]
    if not outward:
        near, apex, base = after, edge, surface.lengths[after]
    to_first = start + _apart(x, -y, first * over, first * up)
    to_last = start + _apart(x, -y, last * over, last * up)
    from_third = _apart(base, 0.0, first * over, first * up)
    most = 1.0 - _EPSILON
    if (
        _distance_at(surface, distances, near) + last < to_last * most
        or _distance_at(surface, distances, apex) + (length - first) < to_first * most
        or _distance_at(surface, distances, third) + from_third < to_first * most
    ):
        return  # from this corner, every point of the window is reached sooner
    beyond = (first, last, x * over - y * up, abs(x * up + y * over), start)
    _cross(surface, front, edge, outward, origin, beyond)


@inlined
def _meeting(place: float, x: float, y: float, over: float, up: float, length: float) -> float:
    """How far along an edge a line from (x, -y) through (place, 0) meets it."""
    aside = place - x
    across = over * y - up * aside
    if across <= 0.0:
        return length
    return min(place * y / across, length)


@inlined
def _apart(x: float, y: float, other_x: float, other_y: float) -> float:
    return float(np.sqrt((x - other_x) ** 2 + (y - other_y) ** 2))


@inlined
def _distance_at(surface: Surface, distances: FloatArray, side: int) -> float:
    """Distance of the vertex where a side begins."""
    return float(distances[surface.faces[side // 3, side % 3]])


@inlined
def _cross(
    surface: Surface, front: Front, edge: int, along_edge: bool, origin: int, window: Window
) -> None:
    """Put a window in front of every other triangle at an edge.

    The window is measured from the edge's start, or if not `along_edge` from its end, and its
    lines come out of the edge's own triangle.
    """
    low, high, x, y, start = window
    length = surface.lengths[edge]
    side = surface.across[edge]
    while side != edge:
        if along_edge == (surface.forward[side] == surface.forward[edge]):
            put_window(front, side, origin, window)
        else:
            mirrored = (length - high, length - low, length - x, y, start)
            put_window(front, side, origin, mirrored)
        side = surface.across[side]
