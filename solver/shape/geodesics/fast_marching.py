"""Fast marching on triangle meshes (Kimmel and Sethian, PNAS 95, 1998), with circular wavefronts.

A front leaves the source and reaches vertices in order of distance. A triangle updates its third
corner from the two others: in the plane, their distances determine the position of a virtual
source, and if the line from there to the third corner passes between the two, its length is a
candidate for the third distance (Novotni and Klein, WSCG 2002). Planar wavefronts, as in the
original method, err most near the source, where the front is most curved; circular ones are exact
wherever the surface unfolds.

Obtuse corners, which a front may reach before the opposite edge, are rare on the intrinsic
Delaunay triangulation, and are not split: a vertex whose distance decreases after it was accepted
is accepted again (label correcting). The segments of :mod:`.graph` are relaxed too. They matter
where the surface is so rough that hardly any wavefront is circular.
"""

import numpy as np

from solver.arrays import FloatArray, IndexArray, IntArray
from solver.kernel import inlined, kernel
from solver.mesh import TriangleMesh
from solver.shape.geodesics.graph import linked_segments
from solver.shape.geodesics.heap import pop, push
from solver.shape.geodesics.interface import checked_sources
from solver.shape.geodesics.intrinsic import intrinsic_triangulation

_DECREASE = 1.0 - 1e-12
"""Greatest ratio of a new distance to the old one for an update: more is a rounding error."""

_COARSE_DECREASE = 1.0 - 1e-6
"""The same after `_ACCEPTANCES`, so that the march ends on any mesh."""

_ACCEPTANCES = 4
"""Acceptances per vertex, on average, before only coarse decreases count. Meshes take 1.0 to 1.2;
thin triangles that cannot be flipped, at non-manifold edges, might take thousands."""


class FastMarching:
    """Distances by fast marching on the intrinsic Delaunay triangulation.

    Parameters
    ----------
    mesh
        Any mesh.
    """

    def __init__(self, mesh: TriangleMesh) -> None:
        triangulation = intrinsic_triangulation(mesh).delaunay()
        count = triangulation.n_vertices
        self._segments = _by_vertex(count, *linked_segments(mesh, triangulation))
        self._corners = _third_corners(
            count, triangulation.faces, triangulation.lengths, triangulation.apexes()
        )

    @property
    def n_vertices(self) -> int:
        """Number V of vertices."""
        return len(self._segments[0]) - 1

    def distances(self, sources: IntArray) -> FloatArray:
        """(S, V) approximate distances from (S,) vertices to all, with errors of both signs.

        O(S V log V).
        """
        known = checked_sources(sources, self.n_vertices)
        found = np.empty((len(known), self.n_vertices))
        march(*self._segments, *self._corners, known, found)
        return found


@kernel
def _by_vertex(
    size: int, ends: IntArray, lengths: FloatArray
) -> tuple[IndexArray, IndexArray, FloatArray]:
    """Segments as compressed sparse rows, each in the rows of both of its ends.

    Returns
    -------
    starts : (V + 1,) first segment of each vertex.
    others : (2S,) vertex at the other end.
    lengths : (2S,) of the segments.
    """
    starts = np.zeros(size + 1, dtype=np.int64)
    for i in range(len(ends)):
        for k in range(2):
            starts[ends[i, k] + 1] += 1
    starts = np.cumsum(starts)
    place = starts[:-1].copy()
    others, found = np.empty(starts[-1], dtype=np.uint32), np.empty(starts[-1])
    for i in range(len(ends)):
        for k in range(2):
            here = ends[i, k]
            others[place[here]], found[place[here]] = ends[i, 1 - k], lengths[i]
            place[here] += 1
    return starts.astype(np.uint32), others, found


@kernel
def _third_corners(
    size: int, faces: IntArray, lengths: FloatArray, apexes: FloatArray
) -> tuple[IndexArray, IndexArray, FloatArray]:
    """Wavefront updates from each vertex, by one of its triangles and its neighbour in it.

    Returns
    -------
    starts : (V + 1,) first update of each vertex.
    corners : (6F, 2) the neighbour, and the third corner, which is updated.
    shapes : (6F, 4) length of the side to the neighbour, and its inverse; coordinates of the third
        corner along this side from the vertex, and above it.
    """
    starts = np.zeros(size + 1, dtype=np.int64)
    for side in range(len(lengths)):
        starts[faces[side // 3, side % 3] + 1] += 2
    starts = np.cumsum(starts)
    place = starts[:-1].copy()
    corners, shapes = np.empty((starts[-1], 2), dtype=np.uint32), np.empty((starts[-1], 4))
    for side in range(len(lengths)):
        face, k, base = side // 3, side % 3, lengths[side]
        start, end, third = faces[face, k], faces[face, (k + 1) % 3], faces[face, (k + 2) % 3]
        along, above = apexes[side]
        for here, other, place_along in ((start, end, along), (end, start, base - along)):
            row = place[here]
            place[here] += 1
            corners[row, 0], corners[row, 1] = other, third
            shapes[row, 0], shapes[row, 1] = base, 1.0 / base
            shapes[row, 2], shapes[row, 3] = place_along, above
    return starts.astype(np.uint32), corners, shapes


@kernel
def march(
    segment_starts: IndexArray,
    segment_ends: IndexArray,
    segment_lengths: FloatArray,
    corner_starts: IndexArray,
    corners: IndexArray,
    shapes: FloatArray,
    sources: IntArray,
    distances: FloatArray,
) -> None:
    """March from each source until no distance decreases.

    Parameters
    ----------
    segment_starts, segment_ends, segment_lengths
        Segments from each vertex, see :func:`_by_vertex`.
    corner_starts, corners, shapes
        Wavefront updates from each vertex, see :func:`_third_corners`.
    sources
        (S,) vertices.
    distances
        (S, V), overwritten.
    """
    n = distances.shape[1]
    heap, keys, places = np.empty(n, np.uint32), np.empty(n), np.empty(n, np.int64)
    for search in range(len(sources)):
        reached = distances[search]
        reached[:] = np.inf
        places[:] = -1
        reached[sources[search]] = 0.0
        size = push(heap, keys, places, 0, sources[search], 0.0)
        acceptances, decrease = 0, _DECREASE
        while size > 0:
            here, nearest = heap[0], keys[0]
            size = pop(heap, keys, places, size)
            acceptances += 1
            if acceptances > _ACCEPTANCES * n:
                decrease = _COARSE_DECREASE
            for row in range(segment_starts[here], segment_starts[here + 1]):
                there, found = segment_ends[row], nearest + segment_lengths[row]
                if found < decrease * reached[there]:
                    reached[there] = found
                    size = push(heap, keys, places, size, there, found)
            for row in range(corner_starts[here], corner_starts[here + 1]):
                other, there = corners[row, 0], corners[row, 1]
                if places[other] >= 0 or reached[other] == np.inf:
                    continue  # updated when the other vertex is accepted
                limit = decrease * reached[there]
                found = _wavefront(nearest, reached[other], shapes, row, limit)
                if found < limit:
                    reached[there] = found
                    size = push(heap, keys, places, size, there, found)


@inlined
def _wavefront(here: float, other: float, shapes: FloatArray, row: int, limit: float) -> float:
    """Distance of a triangle's third corner from the virtual source of a circular wavefront.

    Parameters
    ----------
    here, other
        Distances of the first two corners, which place the virtual source in the plane.
    shapes, row
        The triangle, see :func:`_third_corners`.
    limit
        Distances from here on are of no use.

    Returns
    -------
    float
        ``inf`` if the distance is not below the limit, or the line from the virtual source to the
        third corner does not pass between the first two.
    """
    base, inverse, along, above = shapes[row, 0], shapes[row, 1], shapes[row, 2], shapes[row, 3]
    source = 0.5 * (base + (here - other) * (here + other) * inverse)
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
