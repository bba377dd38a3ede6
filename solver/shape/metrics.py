"""Metrics d_X on a shape's vertices, sections 3.2 to 3.4."""

from typing import Protocol

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.errors import MeshError
from solver.shape.geodesics import Geodesics
from solver.shape.laplacian import Spectrum

_CACHED_BYTES = 256 * 1024**2
"""Size of the cache of a shape's geodesic distances: rows of 6,700 sources at 5,000 vertices, of
167 at 200,000. So many hold the target samples of a match, whose rows are needed again for the
distances to points that are chosen later."""

_CONNECTED = 1e-9
"""Second eigenvalue, times the area, above which a shape is connected."""


class Metric(Protocol):
    """Distances between the vertices of one shape."""

    @property
    def n_vertices(self) -> int:
        """Number V of vertices."""
        ...

    def distances(self, sources: IntArray) -> FloatArray:
        """Distances from some vertices to all.

        Parameters
        ----------
        sources
            (S,) int64 vertex indices.

        Returns
        -------
        (S, V) float64
        """
        ...

    def between(self, points: IntArray) -> FloatArray:
        """Distances among some vertices.

        Parameters
        ----------
        points
            (A,) int64 vertex indices.

        Returns
        -------
        (A, A) float64, exactly symmetric, zero on the diagonal.
        """
        ...


class GeodesicMetric:
    """The geodesic metric, section 3.2.

    Finer levels and longer samplings ask for the same rows again: the most recently used ones are
    cached, as many as fit into `_CACHED_BYTES`.

    Parameters
    ----------
    geodesics
        A method of computing geodesic distances on the shape's mesh.
    """

    def __init__(self, geodesics: Geodesics) -> None:
        self._geodesics = geodesics
        self._cache: dict[int, FloatArray] = {}  # by source, the most recently used last

    @property
    def n_vertices(self) -> int:
        """Number V of vertices."""
        return self._geodesics.n_vertices

    def distances(self, sources: IntArray) -> FloatArray:
        """(S, V) distances from (S,) vertices to all; one search per uncached source."""
        found = np.empty((len(sources), self.n_vertices))
        for place in self._known_first(sources):
            found[place] = self._row(int(sources[place]))
        return found

    def between(self, points: IntArray) -> FloatArray:
        """(A, A) distances among (A,) vertices, exactly symmetric.

        The two directions agree up to the method's error; the shorter distance counts, since
        methods tend to overestimate.
        """
        found = np.empty((len(points), len(points)))
        for place in self._known_first(points):
            found[place] = self._row(int(points[place]))[points]
        return np.minimum(found, found.T)

    def _known_first(self, points: IntArray) -> list[int]:
        """Places of points, those of cached rows first: new rows would take their room."""
        return sorted(range(len(points)), key=lambda place: int(points[place]) not in self._cache)

    def _row(self, source: int) -> FloatArray:
        row = self._cache.pop(source, None)
        if row is None:
            row = self._geodesics.distances(np.array([source], dtype=np.int64))[0]
            if len(self._cache) >= max(_CACHED_BYTES // row.nbytes, 1):
                self._cache.pop(next(iter(self._cache)))
        self._cache[source] = row
        return row


class EmbeddedMetric:
    """Euclidean distances between vertices embedded in R^m.

    Parameters
    ----------
    embedding
        (V, m) float64 coordinates of each vertex.
    """

    def __init__(self, embedding: FloatArray) -> None:
        self.embedding = np.ascontiguousarray(embedding)
        self._squared_norms = np.einsum("ij,ij->i", embedding, embedding)

    @property
    def n_vertices(self) -> int:
        """Number V of vertices."""
        return len(self.embedding)

    def distances(self, sources: IntArray) -> FloatArray:
        """(S, V) distances from (S,) vertices to all.

        By |a - b|² = |a|² + |b|² - 2 a·b, a matrix product: several times faster than by
        differences, with an absolute error of about 10⁻⁸ diameters at distances near 0. O(S V m).
        """
        squares = self._squared_norms[sources][:, None] + self._squared_norms
        squares -= 2.0 * (self.embedding[sources] @ self.embedding.T)
        squares[np.arange(len(sources)), sources] = 0.0
        found: FloatArray = np.sqrt(np.maximum(squares, 0.0))
        return found

    def squares(self, source: int) -> FloatArray:
        """(V,) squared distances from a vertex to all, with the precision of :meth:`distances`."""
        squares: FloatArray = self._squared_norms + self._squared_norms[source]
        products = self.embedding @ self.embedding[source]
        products *= 2.0
        squares -= products
        squares[source] = 0.0
        return np.maximum(squares, 0.0, out=squares)

    def squares_from(self, point: FloatArray) -> FloatArray:
        """(V,) squared distances from an (m,) point of the embedding space to all vertices.

        Rounding can leave a square just below zero.
        """
        squares: FloatArray = self._squared_norms + point @ point - 2.0 * (self.embedding @ point)
        return squares

    def between(self, points: IntArray) -> FloatArray:
        """(A, A) distances among (A,) vertices, exactly symmetric, by differences."""
        embedded = self.embedding[points]
        found = np.empty((len(points), len(points)))
        for row, point in zip(found, embedded, strict=True):
            offsets = embedded - point
            np.sqrt(np.einsum("ij,ij->i", offsets, offsets), out=row)
        return found


class DiffusionMetric(EmbeddedMetric):
    """The diffusion metric d_{X,t}: equation (3) (Coifman and Lafon, ACHA 21, 2006).

    Parameters
    ----------
    spectrum
        Spectrum of the shape.
    time
        t > 0, in the spectrum's unit of area.
    """

    def __init__(self, spectrum: Spectrum, time: float) -> None:
        decay = np.exp(-spectrum.eigenvalues[1:] * time)
        super().__init__(spectrum.eigenfunctions[:, 1:] * decay)


class CommuteTimeMetric(EmbeddedMetric):
    """The commute-time metric δ_X: equation (4) (Qiu and Hancock, IEEE TPAMI 29(11), 2007).

    It is invariant to scale.

    Parameters
    ----------
    spectrum
        Spectrum of a connected shape.

    Raises
    ------
    MeshError
        The shape is not connected.
    """

    def __init__(self, spectrum: Spectrum) -> None:
        eigenvalues = _positive_eigenvalues(spectrum, "commute time")
        super().__init__(spectrum.eigenfunctions[:, 1:] / np.sqrt(eigenvalues))


class BiharmonicMetric(EmbeddedMetric):
    """The biharmonic metric (Lipman, Rustamov and Funkhouser, ACM TOG 29(3), 2010).

    d² = Σ (φ_i(x) - φ_i(y))² / λ_i² = g(x, x) + g(y, y) - 2 g(x, y), with g the Green's function
    of Δ². With φ_i in 1/length and λ_i in 1/length², it is a length: it scales with the shape as
    geodesic distances do, and is smooth where these have kinks.

    Parameters
    ----------
    spectrum
        Spectrum of a connected shape.

    Raises
    ------
    MeshError
        The shape is not connected.
    """

    def __init__(self, spectrum: Spectrum) -> None:
        eigenvalues = _positive_eigenvalues(spectrum, "biharmonic distance")
        super().__init__(spectrum.eigenfunctions[:, 1:] / eigenvalues)


def _positive_eigenvalues(spectrum: Spectrum, quantity: str) -> FloatArray:
    """Eigenvalues without the first, which must be positive."""
    eigenvalues = spectrum.eigenvalues[1:]
    if len(eigenvalues) and not eigenvalues[0] * spectrum.area > _CONNECTED:
        raise MeshError(f"the {quantity} is infinite: the shape is not connected")
    return eigenvalues
