"""Third-order term of a level (7.1): which triples of source points have costs, and which costs."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.labelling import NO_TRIPLES, TripleCosts, triple_costs
from solver.shape import SIGNED_ANGLE_RADIUS, Shape, signed_angles
from solver.shape.choices import Geodesic


@dataclass(frozen=True, eq=False)
class ThirdOrderTerm:
    """Distortion of signed angles: weight · N/T · Σ |a_X − a_Y|² / s_a² over T triples.

    Parameters
    ----------
    weight
        Weight of the term.
    points
        (T, 3) source samples, ascending; no two triples share two of them.
    source
        (T,) a_X of these.
    target
        (M, M, M) a_Y of all target samples.
    unit
        s_a, the root mean square of the angles of both shapes.
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
            (N,) vertices of X and (M,) of Y, N <= M.
        weight
            Weight of the term.
        """
        ours, theirs = (_angles(s, v) for s, v in zip((source, target), samples, strict=True))
        count = len(samples[0])
        squares = [float((angles**2).sum()) for angles in (ours, theirs[:count, :count, :count])]
        unit = float(np.sqrt(sum(squares) / max(2 * count * (count - 1) * (count - 2), 1))) or 1.0
        points = spread_triples(np.abs(ours))
        return cls(weight, points, ours[tuple(points.T)], theirs, unit)

    def at(self, target: Shape, vertices: IntArray) -> "ThirdOrderTerm":
        """Return the term for other samples of the target."""
        return replace(self, target=_angles(target, vertices))

    def costs(self, candidates: IntArray) -> TripleCosts:
        """Third-order costs of candidates.

        Parameters
        ----------
        candidates
            (V, 2) indices into the two samplings, in lexicographic order.
        """
        if not len(self.points):
            return NO_TRIPLES
        count = int(candidates[:, 0].max()) + 1
        rows = np.searchsorted(candidates[:, 0], np.arange(count + 1)).astype(np.int64)
        share = self.weight * count / len(self.points) / self.unit**2
        tables = []
        for triple, angle in zip(self.points, self.source, strict=True):
            places = (candidates[rows[x] : rows[x + 1], 1] for x in triple)
            tables.append(share * (angle - self.target[np.ix_(*places)]) ** 2)
        return triple_costs(rows, self.points, tables)


def _angles(shape: Shape, vertices: IntArray) -> FloatArray:
    """Signed angles of samples of a shape."""
    distances = shape.metric(Geodesic()).distances(vertices)
    return signed_angles(shape.surface, distances, SIGNED_ANGLE_RADIUS * shape.size)


def spread_triples(sizes: FloatArray) -> IntArray:
    """Choose triples of which no two share two points, those of greatest size first.

    N points have at most N (N − 1) / 6 such triples, and nearly as many are chosen: each point is
    in about N / 2 of them, with nearly every other point in one. Triples that share no pair cost no
    more than pairs in the optimisation. Those with great angles tell most: a mirror image costs
    4 a²; points nearly on a line, such as those on the middle of a symmetric body, have a = 0.

    Parameters
    ----------
    sizes
        (N, N, N) symmetric.

    Returns
    -------
    (T, 3) ascending in each row, in lexicographic order; none for fewer than three points.
    """
    triples: Sequence[tuple[int, int, int]] = list(combinations(range(len(sizes)), 3))
    taken: set[tuple[int, int]] = set()
    chosen = []
    for triple in sorted(triples, key=lambda one: -float(sizes[one])):
        pairs = set(combinations(triple, 2))
        if not pairs & taken:
            taken |= pairs
            chosen.append(triple)
    return np.array(sorted(chosen), dtype=np.int64).reshape(-1, 3)
