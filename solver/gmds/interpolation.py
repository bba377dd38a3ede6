"""Metric on all points of a surface, interpolated from its values between vertices."""

from functools import cached_property

import numpy as np

from solver.arrays import FloatArray
from solver.gmds.surface import Charts, SurfacePoints, charts_of
from solver.mesh import TriangleMesh
from solver.shape import EmbeddedMetric, Metric


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

    Distances are computed on demand, from the corners of a point's triangle only, and not kept.

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

    @cached_property
    def charts(self) -> Charts:
        """Planar coordinates of the surface's triangles."""
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
            needed = u > 0.0
            squares = u[needed] @ self._metric.distances(corners[needed]) ** 2
            edges = self.edges[face]
            squares -= b * c * edges[0] + c * a * edges[1] + a * b * edges[2]
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
        (N, N) float64, exactly symmetric, zero on the diagonal: of both directions, should they
        differ, the shorter, as between vertices.
        """
        squares = np.empty((len(points), len(points)))
        corners = self.surface.faces[points.faces]
        inner = self._within(points)
        for row, face, u in zip(squares, points.faces, points.barycentric, strict=True):
            field = self.squares_from(int(face), u)
            row[:] = (field[corners] * points.barycentric).sum(axis=1) - inner
        np.maximum(squares, 0.0, out=squares)
        np.fill_diagonal(squares, 0.0)
        return np.sqrt(np.minimum(squares, squares.T))

    def _within(self, points: SurfacePoints) -> FloatArray:
        a, b, c = points.barycentric.T
        edges = self.edges[points.faces]
        inner: FloatArray = b * c * edges[:, 0] + c * a * edges[:, 1] + a * b * edges[:, 2]
        return inner


def _squared_edges(metric: Metric, surface: TriangleMesh) -> FloatArray:
    """(F, 3) squared length, in the metric, of the edge opposite each corner of each triangle."""
    places = metric.embedding if isinstance(metric, EmbeddedMetric) else surface.vertices
    squares = np.empty((surface.n_faces, 3))
    for corner in range(3):
        ends = surface.faces[:, (corner + 1) % 3], surface.faces[:, (corner + 2) % 3]
        offsets = places[ends[0]] - places[ends[1]]
        squares[:, corner] = np.einsum("fi,fi->f", offsets, offsets)
    return squares
