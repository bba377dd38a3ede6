"""Farthest point sampling, section 4.1: progressive samples that cover a shape evenly."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.errors import MeshError, OptionError
from solver.kernel import kernel
from solver.shape.metrics import EmbeddedMetric, Metric

_LANDMARKS = 6


@dataclass(frozen=True, eq=False)
class FarthestPointSampling:
    """Vertices in the order in which they were sampled; each prefix is a sampling itself.

    Parameters
    ----------
    indices
        (n,) sampled vertices.
    radii
        (n,) ``radii[i]`` is the covering radius of the first i + 1 samples: no vertex is farther
        than that from the nearest of them. Never increasing.
    distances
        (n, n) between the samples, in the metric they were sampled with; exactly symmetric.
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
            How many, at most the samples there are.
        """
        if not 1 <= count <= len(self):
            raise ValueError(f"there are {len(self)} samples, not {count}")
        return FarthestPointSampling(
            self.indices[:count], self.radii[:count], self.distances[:count, :count]
        )


def farthest_point_sampling(
    metric: Metric, count: int, first: Sequence[int] = ()
) -> FarthestPointSampling:
    """Sample vertices, each time the one farthest from all samples before.

    Parameters
    ----------
    metric
        Of the shape.
    count
        Number n of samples.
    first
        Different vertices that are the first samples, in this order; by default
        :func:`extremity`, so that the ends of the shape come first and samples of similar shapes
        resemble one another.

    Returns
    -------
    FarthestPointSampling
        Ties go to the smallest vertex index. One row of distances in memory at a time.

    Raises
    ------
    OptionError
        The shape has fewer than `count` vertices.
    MeshError
        The shape is not connected.
    """
    if count < 1:
        raise ValueError("count must be at least 1")
    if count > metric.n_vertices:
        raise OptionError(
            "points", f"the shape has only {metric.n_vertices} vertices; {count} were asked for"
        )
    indices = np.empty(count, dtype=np.int64)
    radii = np.empty(count)
    distances = np.zeros((count, count))
    nearest = np.full(metric.n_vertices, np.inf)
    chosen = extremity(metric) if not first else first[0]
    # Squares order vertices as distances do, and an embedding has them first.
    embedded = metric if isinstance(metric, EmbeddedMetric) else None
    for i in range(count):
        row = _row(metric, chosen) if embedded is None else embedded.squares(chosen)
        indices[i] = chosen
        distances[i, :i] = distances[:i, i] = row[indices[:i]]
        np.minimum(nearest, row, out=nearest)
        nearest[chosen] = -1.0  # never again, not even among coinciding vertices
        farthest = int(np.argmax(nearest))
        radii[i] = max(nearest[farthest], 0.0)
        chosen = first[i + 1] if i + 1 < len(first) else farthest
    if embedded is not None:
        radii, distances = np.sqrt(radii), np.sqrt(distances)
    return FarthestPointSampling(indices, radii, distances)


def spread_in_space(positions: FloatArray, count: int) -> IntArray:
    """Sample points farthest first by their distances in space alone: quick, and even enough.

    Parameters
    ----------
    positions
        (V, 3).
    count
        Number n of samples, at most V.

    Returns
    -------
    (n,) int64 rows, the one farthest from the centre first. Ties go to the smallest row. O(V n)
    time.
    """
    offsets = positions - positions.mean(axis=0)
    first = int(np.argmax(np.einsum("ij,ij->i", offsets, offsets)))
    return _farthest_first(np.ascontiguousarray(positions), count, first)


@kernel
def _farthest_first(positions: FloatArray, count: int, first: int) -> IntArray:
    chosen = np.empty(count, dtype=np.int64)
    nearest = np.full(len(positions), np.inf)
    here = first
    for place in range(count):
        chosen[place] = here
        x, y, z = positions[here]
        farthest, there = -1.0, here
        nearest[here] = -1.0  # never again, not even among coinciding points
        for i in range(len(positions)):
            square = (
                (positions[i, 0] - x) ** 2 + (positions[i, 1] - y) ** 2 + (positions[i, 2] - z) ** 2
            )
            if square < nearest[i]:
                nearest[i] = square
            if nearest[i] > farthest:
                farthest, there = nearest[i], i
        here = there
    return chosen


def extremity(metric: Metric) -> int:
    """Find one end of the shape's diameter, the same however its vertices are numbered.

    A few samples, taken from vertex 0 on, find the shape's ends roughly. From each of them, hops
    to the farthest vertex lead to pairs of vertices farthest from one another. The most distant
    pair is the diameter, or nearly; of its two vertices, the one that is farther from all others
    on average is chosen. Where shapes are symmetric, or nearly, numbering can still decide.

    Parameters
    ----------
    metric
        Of the shape.

    Returns
    -------
    int
        Vertex index.

    Raises
    ------
    MeshError
        The shape is not connected.
    """
    nearest = _row(metric, 0)
    farthest: list[int] = []
    for _ in range(_LANDMARKS):
        row = _row(metric, int(np.argmax(nearest)))
        farthest.append(int(np.argmax(row)))
        nearest = np.minimum(nearest, row)
    seen: dict[int, tuple[float, float]] = {}  # distance to the farthest vertex, to all on average
    while farthest:
        here = farthest.pop()
        if here not in seen:
            row = _row(metric, here)
            farthest.append(int(np.argmax(row)))
            seen[here] = (float(row.max()), float(row.mean()))
    diameter = max(longest for longest, _ in seen.values())
    ends = [here for here, (longest, _) in seen.items() if longest >= diameter * (1.0 - 1e-9)]
    return max(ends, key=lambda here: seen[here][1])


def _row(metric: Metric, vertex: int) -> FloatArray:
    row: FloatArray = metric.distances(np.array([vertex], dtype=np.int64))[0]
    if not np.isfinite(row).all():
        raise MeshError("distances are infinite: the shape is not connected")
    return row
