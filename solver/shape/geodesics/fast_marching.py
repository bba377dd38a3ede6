"""Fast marching (Kimmel and Sethian, PNAS 95, 1998), with circular waves.

A front leaves the source and reaches vertices in order of distance. A triangle carries it from
two of its corners to the third: in the plane, their distances tell where the source would lie,
and if the line from there to the third corner passes between the two, its length is the third
distance (Novotni and Klein, WSCG 2002). Plane waves, the usual choice, err most near the source,
where fronts are most curved; circular ones are exact wherever the surface unfolds.

Obtuse corners, which a front may reach before the edge opposite, are rare on the intrinsic
Delaunay triangulation and need no special treatment: a vertex whose distance can be lowered
after its turn gets another turn. The segments of ``graph`` are followed as well. They matter
where the surface is so rough that hardly any wave is circular.
"""

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.kernel import inlined, kernel
from solver.mesh import TriangleMesh
from solver.shape.geodesics.graph import straight_ways
from solver.shape.geodesics.heap import lift, pop
from solver.shape.geodesics.interface import checked_sources
from solver.shape.geodesics.intrinsic import IntrinsicTriangulation, intrinsic_triangulation

_LESS, _MUCH_LESS = 1.0 - 1e-12, 1.0 - 1e-6
"""What lowers a distance by less than rounding errors is not worth another turn."""

_TURNS = 4
"""Turns a vertex, on average, after which lowering must be worth more. It takes 1.0 to 1.2; where
thin triangles cannot be flipped, at edges of several sheets, it might take thousands."""


class FastMarching:
    """Distances by fast marching on the intrinsic Delaunay triangulation.

    Parameters
    ----------
    mesh
        Any mesh.
    """

    def __init__(self, mesh: TriangleMesh) -> None:
        triangulation = intrinsic_triangulation(mesh).delaunay()
        self._segments = _segments(triangulation)
        self._waves = _waves(triangulation)

    @property
    def n_vertices(self) -> int:
        """Number V of vertices."""
        return len(self._segments[0]) - 1

    def distances(self, sources: IntArray) -> FloatArray:
        """(S, V) distances from (S,) vertices to all, a little long or short. O(S V log V)."""
        known = checked_sources(sources, self.n_vertices)
        found = np.empty((len(known), self.n_vertices))
        march(*self._segments, *self._waves, known, found)
        return found


def _segments(triangulation: IntrinsicTriangulation) -> tuple[IntArray, IntArray, FloatArray]:
    """Segments of ``graph`` from each vertex, some of them twice, as march takes them."""
    return _by_vertex(triangulation.n_vertices, *straight_ways(triangulation))


def _waves(
    triangulation: IntrinsicTriangulation,
) -> tuple[IntArray, IntArray, FloatArray]:
    """Ways a front can take from a vertex and a neighbour of it to the third corner of a triangle.

    Returns
    -------
    starts : (V + 1,) where each vertex's ways begin.
    corners : (6F, 2) the neighbour and the third corner.
    shapes : (6F, 3) length of the side to the neighbour, and the third corner: along, above.
    """
    return _curved_ways(
        triangulation.n_vertices,
        triangulation.faces,
        triangulation.lengths,
        triangulation.apexes(),
    )


@kernel
def _by_vertex(
    size: int, ends: IntArray, lengths: FloatArray
) -> tuple[IntArray, IntArray, FloatArray]:
    """Put segments in compressed rows, each in those of both of its ends."""
    starts = np.zeros(size + 1, dtype=np.int64)
    for i in range(len(ends)):
        for k in range(2):
            starts[ends[i, k] + 1] += 1
    starts = np.cumsum(starts)
    place = starts[:-1].copy()
    others, found = np.empty(starts[-1], dtype=np.int64), np.empty(starts[-1])
    for i in range(len(ends)):
        for k in range(2):
            here = ends[i, k]
            others[place[here]], found[place[here]] = ends[i, 1 - k], lengths[i]
            place[here] += 1
    return starts, others, found


@kernel
def _curved_ways(
    size: int, faces: IntArray, lengths: FloatArray, apexes: FloatArray
) -> tuple[IntArray, IntArray, FloatArray]:
    """Ways of each vertex to the third corners of its triangles; see `_waves`."""
    starts = np.zeros(size + 1, dtype=np.int64)
    for side in range(len(lengths)):
        starts[faces[side // 3, side % 3] + 1] += 2
    starts = np.cumsum(starts)
    place = starts[:-1].copy()
    corners, shapes = np.empty((starts[-1], 2), dtype=np.int64), np.empty((starts[-1], 3))
    for side in range(len(lengths)):
        face, k, base = side // 3, side % 3, lengths[side]
        start, end, third = faces[face, k], faces[face, (k + 1) % 3], faces[face, (k + 2) % 3]
        along, above = apexes[side]
        for here, other, place_along in ((start, end, along), (end, start, base - along)):
            way = place[here]
            place[here] += 1
            corners[way, 0], corners[way, 1] = other, third
            shapes[way, 0], shapes[way, 1], shapes[way, 2] = base, place_along, above
    return starts, corners, shapes


@kernel
def march(
    segment_starts: IntArray,
    segment_ends: IntArray,
    segment_lengths: FloatArray,
    wave_starts: IntArray,
    wave_corners: IntArray,
    wave_shapes: FloatArray,
    sources: IntArray,
    distances: FloatArray,
) -> None:
    """Let a front run from each source until it comes to rest.

    Parameters
    ----------
    segment_starts, segment_ends, segment_lengths
        Segments from each vertex, as in a compressed sparse row matrix.
    wave_starts, wave_corners, wave_shapes
        Triangles at each vertex, see :func:`_waves`.
    sources
        (S,) vertices.
    distances
        (S, V), written.
    """
    n = distances.shape[1]
    heap, places = np.empty(n, dtype=np.int64), np.empty(n, dtype=np.int64)
    for row in range(len(sources)):
        reached = distances[row]
        reached[:] = np.inf
        places[:] = -1
        reached[sources[row]] = 0.0
        size = lift(heap, places, reached, 0, sources[row])
        turns, less = 0, _LESS
        while size > 0:
            here, size = pop(heap, places, reached, size)
            turns += 1
            if turns > _TURNS * n:
                less = _MUCH_LESS
            for way in range(segment_starts[here], segment_starts[here + 1]):
                there, found = segment_ends[way], reached[here] + segment_lengths[way]
                if found < less * reached[there]:
                    reached[there] = found
                    size = lift(heap, places, reached, size, there)
            for way in range(wave_starts[here], wave_starts[here + 1]):
                other, there = wave_corners[way, 0], wave_corners[way, 1]
                if places[other] >= 0 or reached[other] == np.inf:
                    continue  # it will have its own turn
                limit = less * reached[there]
                found = _wave(reached[here], reached[other], wave_shapes, way, limit)
                if found < limit:
                    reached[there] = found
                    size = lift(heap, places, reached, size, there)


@inlined
def _wave(here: float, other: float, shapes: FloatArray, way: int, limit: float) -> float:
    """Distance of a triangle's third corner from the source beyond the side between the others.

    These are `here` and `other` far from the source; ``inf`` if, laid out in the plane, it does
    not see the third corner between them, or is farther from it than a limit.
    """
    base, along, above = shapes[way, 0], shapes[way, 1], shapes[way, 2]
    source = 0.5 * (base + (here - other) * (here + other) / base)
    square = here * here - source * source
    if square <= 0.0:
        return np.inf
    squares = (along - source) ** 2 + above * above + square
    if squares >= limit * limit:
        return np.inf
    below = np.sqrt(square)
    crossing = source * above + along * below  # times above + below
    if crossing <= 0.0 or crossing >= base * (above + below):
        return np.inf
    return float(np.sqrt(squares + 2.0 * above * below))
