"""Farthest point sampling, section 4.1: nested samples that cover a shape evenly.

Eldar, Lindenbaum, Porat and Zeevi, "The farthest point strategy for progressive image sampling",
IEEE Trans. Image Process. 6(9), 1997. The covering radius of n samples is at most twice the least
that n points can have (Gonzalez, "Clustering to minimize the maximum intercluster distance", Theor.
Comput. Sci. 38, 1985).
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.errors import OptionError
from solver.shape.metrics import EmbeddedMetric, Metric

_START_POINTS = 6
"""Farthest points from which :func:`extremity` searches the diameter: a quadruped has six
extremities."""

_EQUAL_DIAMETERS = 1e-9
"""Relative difference of diameters that are equal but for rounding errors."""


@dataclass(frozen=True, eq=False)
class FarthestPointSampling:
    """Vertices in the order in which they were sampled; each prefix is a sampling, too.

    Parameters
    ----------
    indices
        (n,) int64 sampled vertices.
    radii
        (n,) float64, not increasing: ``radii[i]`` is the covering radius of the first i + 1
        samples, the greatest distance of a vertex from the nearest of them.
    distances
        (n, n) float64 between the samples, in the metric of the sampling; exactly symmetric.
    """

    indices: IntArray
    radii: FloatArray
    distances: FloatArray

    def __len__(self) -> int:
        return len(self.indices)

    def first(self, count: int) -> "FarthestPointSampling":
        """Return the first samples.

        Parameters
        ----------
        count
            Number of samples, at most ``len(self)``.

        Raises
        ------
        ValueError
            The count is not in 1..n.
        """
        if not 1 <= count <= len(self):
            raise ValueError(f"there are {len(self)} samples, not {count}")
        return FarthestPointSampling(
            self.indices[:count], self.radii[:count], self.distances[:count, :count]
        )


def farthest_point_sampling(
    metric: Metric, count: int, first: Sequence[int] = ()
) -> FarthestPointSampling:
    """Sample vertices, each one farthest from all samples before.

    Parameters
    ----------
    metric
        Metric of the shape.
    count
        Number n of samples.
    first
        Different vertices that are the first samples, in this order; by default
        :func:`extremity`, so that extremities come first and samples of similar shapes resemble
        one another.

    Returns
    -------
    FarthestPointSampling
        Ties go to the smallest vertex index. O(n V) time besides n rows of the metric, of which
        one is in memory at a time. Rows that a :class:`.GeodesicMetric` no longer has in its cache
        are computed twice.

    Raises
    ------
    OptionError
        The shape has fewer than `count` vertices.

    Examples
    --------
    >>> import numpy as np
    >>> from solver.shape.metrics import EmbeddedMetric
    >>> segment = EmbeddedMetric(np.arange(9.0)[:, None])
    >>> sampling = farthest_point_sampling(segment, 4)
    >>> sampling.indices
    array([8, 0, 4, 2])
    >>> sampling.radii
    array([8., 4., 2., 2.])
    """
    if count < 1:
        raise ValueError("count must be at least 1")
    if count > metric.n_vertices:
        raise OptionError(
            "points", f"the shape has only {metric.n_vertices} vertices; {count} were asked for"
        )
    # Squares order vertices as distances do, and cost no roots.
    embedded = metric if isinstance(metric, EmbeddedMetric) else None
    row_of = embedded.squares if embedded is not None else lambda vertex: _row(metric, vertex)
    start = first or (extremity(metric),)
    indices = np.empty(count, dtype=np.int64)
    radii = np.empty(count)
    squares = np.zeros((count, count))
    for i, (vertex, row, radius) in enumerate(farthest_first(row_of, start, count)):
        indices[i], radii[i] = vertex, radius
        if embedded is not None:
            squares[i, :i] = squares[:i, i] = row[indices[:i]]
    if embedded is not None:
        return FarthestPointSampling(indices, np.sqrt(radii), np.sqrt(squares))
    # Of two directions that differ, the metric decides, so that the order does not matter.
    return FarthestPointSampling(indices, radii, metric.between(indices))


def farthest_first(
    row_of: Callable[[int], FloatArray], start: Sequence[int], count: int
) -> Iterator[tuple[int, FloatArray, float]]:
    """Traverse points, each one farthest from all points before.

    Parameters
    ----------
    row_of
        (V,) distances from a point to all, or any increasing function of them. The row is not
        changed, and may be overwritten by the next call.
    start
        Different points to begin with, at least one.
    count
        Number n of points.

    Yields
    ------
    point : index, different from all before as long as n <= V. Ties go to the smallest one.
    row : (V,) its distances.
    radius : covering radius of the points so far.
    """
    point, nearest = start[0], np.empty(0)
    for place in range(count):
        row = row_of(point)
        nearest = np.minimum(nearest, row, out=nearest) if place else row.copy()
        nearest[point] = -1.0  # never again, not even among coinciding points
        farthest = int(np.argmax(nearest))
        yield point, row, max(float(nearest[farthest]), 0.0)
        point = start[place + 1] if place + 1 < len(start) else farthest


def euclidean_farthest_points(positions: FloatArray, count: int) -> IntArray:
    """Farthest point sampling by Euclidean distances in space.

    Parameters
    ----------
    positions
        (V, 3) float64.
    count
        Number n of samples, at most V.

    Returns
    -------
    (n,) int64 rows of `positions`, the one farthest from their mean first. O(n V) time.
    """
    offsets = positions - positions.mean(axis=0)
    first = int(np.argmax(np.einsum("ij,ij->i", offsets, offsets)))
    columns = np.ascontiguousarray(positions.T)

    def squares(point: int) -> FloatArray:
        x, y, z = (columns - columns[:, point, None]) ** 2
        found: FloatArray = x + y + z
        return found

    points = [point for point, _, _ in farthest_first(squares, (first,), count)]
    return np.array(points, dtype=np.int64)


def extremity(metric: Metric) -> int:
    """Find one end of an approximate diameter, nearly independent of the vertices' numbering.

    A farthest point sampling from vertex 0 on approximates the extremities, which are mostly the
    same whatever vertex it starts at. From each of its points, repeated steps to the farthest
    vertex end in a pair of mutually farthest ones. The most distant pair approximates the diameter;
    of its two vertices, the one of greater mean distance is returned. On shapes that are symmetric,
    or nearly, the numbering can still decide.

    Parameters
    ----------
    metric
        Metric of the shape.

    Returns
    -------
    int
        Vertex index.
    """
    traversal = farthest_first(lambda vertex: _row(metric, vertex), (0,), _START_POINTS + 1)
    farthest = [int(np.argmax(row)) for _, row, _ in traversal][1:]
    seen: dict[int, tuple[float, float]] = {}  # greatest and mean distance
    while farthest:
        here = farthest.pop()
        if here not in seen:
            row = _row(metric, here)
            farthest.append(int(np.argmax(row)))
            seen[here] = (float(row.max()), float(row.mean()))
    diameter = max(greatest for greatest, _ in seen.values())
    least = diameter * (1.0 - _EQUAL_DIAMETERS)
    return max((v for v in seen if seen[v][0] >= least), key=lambda v: seen[v][1])


def _row(metric: Metric, vertex: int) -> FloatArray:
    row: FloatArray = metric.distances(np.array([vertex], dtype=np.int64))[0]
    return row
