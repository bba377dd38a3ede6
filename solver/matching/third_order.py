"""Third-order term of a level (7.1): distortion of signed volumes of triples of points."""

from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.labelling import NO_TRIPLES, TripleCosts, triple_costs
from solver.shape import Shape, signed_volumes
from solver.shape.choices import CommuteTime

_FIRST_SAMPLES = 8
"""Samples whose triples have costs, all 56 of them. Farthest point sampling finds extremities
first, at the same places of both shapes; later samples lie where it happens to put them."""


@dataclass(frozen=True, eq=False)
class ThirdOrderTerm:
    """Distortion of signed volumes: weight · N/T · Σ |a_X − a_Y|² / s_a² over T triples.

    Parameters
    ----------
    weight
        Weight of the term.
    points
        (T, 3) source samples, ascending.
    source
        (T,) a_X of these.
    target
        (M, M, M) a_Y of all target samples.
    unit
        s_a, the root mean square of both shapes' volumes of these triples of samples.
    """

    weight: float
    points: IntArray
    source: FloatArray
    target: FloatArray
    unit: float

    @classmethod
    def between(
        cls, source: Shape, target: Shape, samples: tuple[IntArray, IntArray], weight: float
    ) -> "ThirdOrderTerm":
        """Return the term of two shapes.

        Parameters
        ----------
        source, target
            The shapes X and Y.
        samples
            (N,) vertices of X and (M,) of Y, farthest first, N <= M.
        weight
            Weight of the term.
        """
        count = min(len(samples[0]), _FIRST_SAMPLES)
        ours, theirs = _volumes(source, samples[0][:count]), _volumes(target, samples[1])
        points = np.array(list(combinations(range(count), 3)), dtype=np.int64).reshape(-1, 3)
        values = ours[tuple(points.T)], theirs[tuple(points.T)]
        unit = float(np.sqrt(np.mean(np.square(values)))) if len(points) else 0.0
        return cls(weight, points, values[0], theirs, unit or 1.0)

    def at(self, target: Shape, vertices: IntArray) -> "ThirdOrderTerm":
        """Return the term for other samples of the target."""
        return replace(self, target=_volumes(target, vertices))

    def costs(self, candidates: IntArray, n_sources: int) -> TripleCosts:
        """Third-order costs of candidates.

        Parameters
        ----------
        candidates
            (V, 2) indices into the two samplings, in lexicographic order.
        n_sources
            Number N of source samples.
        """
        if not len(self.points):
            return NO_TRIPLES
        rows = np.searchsorted(candidates[:, 0], np.arange(n_sources + 1)).astype(np.int64)
        share = self.weight * n_sources / len(self.points) / self.unit**2
        tables = []
        for triple, volume in zip(self.points, self.source, strict=True):
            places = (candidates[rows[x] : rows[x + 1], 1] for x in triple)
            tables.append(share * (volume - self.target[np.ix_(*places)]) ** 2)
        return triple_costs(rows, self.points, tables)


def _volumes(shape: Shape, vertices: IntArray) -> FloatArray:
    """Signed volumes of samples of a shape, by their commute-time distances to all vertices."""
    distances = shape.metric(CommuteTime()).distances(vertices)
    return signed_volumes(shape.surface, distances)
