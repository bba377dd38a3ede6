"""Distances between any two points of a surface, interpolated from those between its vertices."""

from collections import OrderedDict
from functools import cached_property

import numpy as np

from solver.arrays import FloatArray
from solver.gmds.surface import Charts, SurfacePoints, charts_of
from solver.mesh import TriangleMesh
from solver.metrics import EmbeddedMetric, Metric

_MEMORY = 64e6
"""Bytes of the distances from vertices that are kept."""


class InterpolatedMetric:
    """A metric d_Y on all points of a surface, from its values between vertices.

    The distance from a point p to a point in a triangle with corners v_k, at barycentric
    coordinates u, is taken from those to its corners by Stewart's theorem:

        d²(p, u) = Σ u_k d²(p, v_k) − Σ_{k<l} u_k u_l |v_k v_l|².

    This is the three-point interpolation of Bronstein, Bronstein and Kimmel (SIAM J. Sci. Comput.
    28, 2006) where the three distances are those to one point of the triangle's plane: exact on
    flat parts of a surface, near and far, and, in a metric that is a Euclidean distance of
    embedded vertices, equal to the embedding's linear interpolation. Used for both of two points,
    it is a polynomial of their coordinates.

    Distances from vertices are computed when a point comes to need them. Those used last are
    kept, 64 MB of them (1,600 vertices of a mesh of 5,000, 160 of one of 50,000).

    Parameters
    ----------
    metric
        On the vertices.
    surface
        Their mesh, in the metric's unit of length.
    """

    def __init__(self, metric: Metric, surface: TriangleMesh) -> None:
        if metric.n_vertices != surface.n_vertices:
            raise ValueError("the metric is that of another mesh")
        self.surface = surface
        self.edges = _squared_edges(metric, surface)
        self._metric = metric
        self._most_rows = max(int(_MEMORY / (8 * surface.n_vertices)), 16)
        self._rows: OrderedDict[int, FloatArray] = OrderedDict()

    @cached_property
    def charts(self) -> Charts:
        """The surface's triangles laid flat."""
        return charts_of(self.surface)

    def squares_from(self, face: int, u: FloatArray) -> FloatArray:
        """Squared distances from a point to all vertices.

        Parameters
        ----------
        face, u
            Its triangle and (3,) barycentric coordinates.

        Returns
        -------
        (V,) float64
        """
        corners = self.surface.faces[face]
        if isinstance(self._metric, EmbeddedMetric):
            squares = self._metric.squares_from(u @ self._metric.embedding[corners])
        else:
            a, b, c = u
            inner = b * c * self.edges[face, 0] + c * a * self.edges[face, 1]
            squares = np.full(self.surface.n_vertices, -inner - a * b * self.edges[face, 2])
            for vertex, weight in zip(corners, u, strict=True):
                if weight > 0.0:
                    squares += weight * self._row(int(vertex))
        np.maximum(squares, 0.0, out=squares)
        return squares

    def between(self, points: SurfacePoints) -> FloatArray:
        """Distances among some points.

        Parameters
        ----------
        points
            N of the surface.

        Returns
        -------
        (N, N) float64, exactly symmetric, zero on the diagonal: the root of the mean of both
        directions' squares, should the metric between vertices not be symmetric.
        """
        squares = np.empty((len(points), len(points)))
        corners = self.surface.faces[points.faces]
        inner = self._within(points)
        for row, face, u in zip(squares, points.faces, points.barycentric, strict=True):
            field = self.squares_from(int(face), u)
            row[:] = (field[corners] * points.barycentric).sum(axis=1) - inner
        np.maximum(squares, 0.0, out=squares)
        np.fill_diagonal(squares, 0.0)
        return np.sqrt(0.5 * (squares + squares.T))

    def _within(self, points: SurfacePoints) -> FloatArray:
        a, b, c = points.barycentric.T
        edges = self.edges[points.faces]
        inner: FloatArray = b * c * edges[:, 0] + c * a * edges[:, 1] + a * b * edges[:, 2]
        return inner

    def _row(self, vertex: int) -> FloatArray:
        """(V,) squared distances from a vertex."""
        known = self._rows.get(vertex)
        if known is None:
            known = self._metric.distances(np.array([vertex], dtype=np.int64))[0] ** 2
            self._rows[vertex] = known
            if len(self._rows) > self._most_rows:
                self._rows.popitem(last=False)
        else:
            self._rows.move_to_end(vertex)
        return known


def _squared_edges(metric: Metric, surface: TriangleMesh) -> FloatArray:
    """(F, 3) squared length, in the metric, of the edge opposite each corner of each triangle."""
    places = metric.embedding if isinstance(metric, EmbeddedMetric) else surface.vertices
    squares = np.empty((surface.n_faces, 3))
    for corner in range(3):
        ends = surface.faces[:, (corner + 1) % 3], surface.faces[:, (corner + 2) % 3]
        offsets = places[ends[0]] - places[ends[1]]
        squares[:, corner] = np.einsum("fi,fi->f", offsets, offsets)
    return squares
