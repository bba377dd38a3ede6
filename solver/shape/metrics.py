"""Metrics d_X on a shape's vertices, sections 3.2 to 3.4."""

from typing import Protocol

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.errors import MeshError
from solver.shape.geodesics import Geodesics
from solver.shape.laplacian import Spectrum

_KEPT_BYTES = 64 * 1024**2
"""Of a shape's geodesic distances: those from 1600 sources at 5,000 vertices, 40 at 200,000."""

_LEAST_HEAT = 1e-9
"""Of what it is at a point, what heat elsewhere is known to: eigenfunctions are not exact."""


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
            (S,) vertex indices.

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
            (A,) vertex indices.

        Returns
        -------
        (A, A) float64, exactly symmetric, zero on the diagonal.
        """
        ...


class GeodesicMetric:
    """The geodesic metric, section 3.2.

    Searches are dear and asked for again, by finer levels and longer samplings: the distances
    found last are kept, as many as fit into `_KEPT_BYTES`.

    Parameters
    ----------
    geodesics
        A method on the shape's mesh.
    """

    def __init__(self, geodesics: Geodesics) -> None:
        self._geodesics = geodesics
        self._kept: dict[int, FloatArray] = {}  # by source, the one asked for last at the end

    @property
    def n_vertices(self) -> int:
        """Number V of vertices."""
        return self._geodesics.n_vertices

    def distances(self, sources: IntArray) -> FloatArray:
        """(S, V) distances from (S,) vertices to all; one search for each not kept."""
        found = np.empty((len(sources), self.n_vertices))
        for row, source in zip(found, sources, strict=True):
            row[:] = self._row(int(source))
        return found

    def between(self, points: IntArray) -> FloatArray:
        """(A, A) distances among (A,) vertices, exactly symmetric.

        Of the two directions, which agree but for the method's error, the shorter counts:
        methods rather find ways too long.
        """
        found = np.empty((len(points), len(points)))
        for row, point in zip(found, points, strict=True):
            row[:] = self._row(int(point))[points]
        return np.minimum(found, found.T)

    def _row(self, source: int) -> FloatArray:
        row = self._kept.pop(source, None)
        if row is None:
            row = self._geodesics.distances(np.array([source], dtype=np.int64))[0]
            if len(self._kept) >= max(_KEPT_BYTES // row.nbytes, 1):
                self._kept.pop(next(iter(self._kept)))
        self._kept[source] = row
        return row


class EmbeddedMetric:
    """A metric that is the Euclidean distance between embedded vertices.

    Parameters
    ----------
    embedding
        (V, m) image of each vertex.
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

        By |a - b|² = |a|² + |b|² - 2 a·b, a matrix product: several times faster than
        differences, at the price of an absolute error of about 10⁻⁸ times the shape's diameter
        where distances are next to nothing.
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

    def squares_from(self, image: FloatArray) -> FloatArray:
        """(V,) squared distances from any point of the embedding space to all vertices.

        Parameters
        ----------
        image
            (m,) the point. Rounding can leave a square just below zero.
        """
        squares: FloatArray = self._squared_norms + image @ image - 2.0 * (self.embedding @ image)
        return squares

    def between(self, points: IntArray) -> FloatArray:
        """(A, A) distances among (A,) vertices, exactly symmetric, by differences."""
        images = self.embedding[points]
        found = np.empty((len(points), len(points)))
        for row, image in zip(found, images, strict=True):
            offsets = images - image
            np.sqrt(np.einsum("ij,ij->i", offsets, offsets), out=row)
        return found


class DiffusionMetric(EmbeddedMetric):
    """The diffusion metric d_{X,t}: equation (3).

    Parameters
    ----------
    spectrum
        Of the shape.
    time
        t > 0, in the spectrum's unit of area.
    """

    def __init__(self, spectrum: Spectrum, time: float) -> None:
        if not 0.0 < time < np.inf:
            raise ValueError("the diffusion time must be positive and finite")
        decay = np.exp(-spectrum.eigenvalues[1:] * time)
        super().__init__(spectrum.eigenfunctions[:, 1:] * decay)


class CommuteTimeMetric(EmbeddedMetric):
    """The commute-time metric δ_X: equation (4). It does not change with the shape's scale.

    Parameters
    ----------
    spectrum
        Of the shape, which must be connected.

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

    d² = Σ (φ_i(x) - φ_i(y))² / λ_i² = g(x, x) + g(y, y) - 2 g(x, y), g being the Green's function
    of the squared operator Δ². With φ_i in 1/length and λ_i in 1/length², it is a length: it
    grows with the shape as geodesic distances do, and is smooth where these have kinks.

    Parameters
    ----------
    spectrum
        Of the shape, which must be connected.

    Raises
    ------
    MeshError
        The shape is not connected.
    """

    def __init__(self, spectrum: Spectrum) -> None:
        eigenvalues = _positive_eigenvalues(spectrum, "biharmonic distance")
        super().__init__(spectrum.eigenfunctions[:, 1:] / eigenvalues)


def varadhan_distances(spectrum: Spectrum, points: IntArray, time: float) -> FloatArray:
    """Geodesic distances as heat tells them, among some vertices.

    d² = -4t log (h_t(x, y) / √(h_t(x, x) h_t(y, y))), which tends to the square of the geodesic
    distance as t does to 0 (Varadhan, CPAM 20(2), 1967). At a positive t it is smooth, depends on
    the whole surface between two points, and is made of eigenpairs alone; but where commute times
    level off it goes on growing. Beyond 2√(t log 10⁹), where h_t is no longer known, it stays as it
    is.

    Parameters
    ----------
    spectrum
        Of the shape.
    points
        (A,) vertices.
    time
        t > 0, in the spectrum's unit of area.

    Returns
    -------
    (A, A) float64, exactly symmetric, zero on the diagonal.
    """
    images = heat_images(spectrum, points, time)
    found = lengths_by_heat(images, images, time)
    found = np.maximum(found, found.T)
    np.fill_diagonal(found, 0.0)
    return found


def heat_images(spectrum: Spectrum, points: IntArray, time: float) -> FloatArray:
    """Unit vectors whose inner products are h_t(x, y) / √(h_t(x, x) h_t(y, y)).

    Parameters
    ----------
    spectrum
        Of the shape, with k eigenpairs.
    points
        (A,) vertices.
    time
        t > 0, in the spectrum's unit of area.

    Returns
    -------
    (A, k) float64
    """
    images: FloatArray = spectrum.eigenfunctions[points] * np.exp(
        -0.5 * time * spectrum.eigenvalues
    )
    images /= np.linalg.norm(images, axis=1)[:, None]
    return images


def lengths_by_heat(one: FloatArray, other: FloatArray, time: float) -> FloatArray:
    """Varadhan's formula for every point of one set and every one of another.

    Parameters
    ----------
    one, other
        (A, k) and (B, k) of :func:`heat_images`.
    time
        That they were made with.

    Returns
    -------
    (A, B) float64
    """
    alike = np.clip(one @ other.T, _LEAST_HEAT, 1.0)
    found: FloatArray = np.sqrt(-4.0 * time * np.log(alike))
    return found


def _positive_eigenvalues(spectrum: Spectrum, what: str) -> FloatArray:
    """Eigenvalues but the first, if they are positive."""
    eigenvalues = spectrum.eigenvalues[1:]
    if len(eigenvalues) and not eigenvalues[0] * spectrum.area > 1e-9:
        raise MeshError(f"the {what} is infinite: the shape is not connected")
    return eigenvalues
