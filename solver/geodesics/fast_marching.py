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
from solver.geodesics.graph import segments
from solver.geodesics.heap import lift, pop
from solver.geodesics.interface import checked_sources
from solver.geodesics.intrinsic import IntrinsicTriangulation, intrinsic_triangulation
from solver.kernel import inlined, kernel
from solver.mesh import TriangleMesh

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
        graph = segments(triangulation)
        self._segments = (
            graph.indptr.astype(np.int64),
            graph.indices.astype(np.int64),
            graph.data,
        )
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
    base, apexes = triangulation.lengths, triangulation.apexes()
    third = triangulation.faces[:, [2, 0, 1]].ravel()
    here = np.r_[triangulation.starts, triangulation.ends]
    neighbour = np.r_[triangulation.ends, triangulation.starts]
    along = np.r_[apexes[:, 0], base - apexes[:, 0]]
    order = np.argsort(here, kind="stable")
    starts = np.searchsorted(here[order], np.arange(triangulation.n_vertices + 1))
    corners = np.stack([neighbour, np.r_[third, third]], axis=1)[order]
    shapes = np.stack([np.r_[base, base], along, np.r_[apexes[:, 1], apexes[:, 1]]], axis=1)
    return starts, corners, shapes[order]


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
                found = _wave(reached[here], reached[other], wave_shapes, way)
                if found < less * reached[there]:
                    reached[there] = found
                    size = lift(heap, places, reached, size, there)


@inlined
def _wave(here: float, other: float, shapes: FloatArray, way: int) -> float:
    """Distance of a triangle's third corner from the source beyond the side between the others.

    These are `here` and `other` far from the source; ``inf`` if, laid out in the plane, it does
    not see the third corner between them.
    """
    base, along, above = shapes[way, 0], shapes[way, 1], shapes[way, 2]
    source = 0.5 * (base + (here - other) * (here + other) / base)
    square = here * here - source * source
    if square <= 0.0:
        return np.inf
    below = np.sqrt(square)
    crossing = source * above + along * below  # times above + below
    if crossing <= 0.0 or crossing >= base * (above + below):
        return np.inf
    return float(np.sqrt((along - source) ** 2 + (above + below) ** 2))
