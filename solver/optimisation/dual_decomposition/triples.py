"""Triple subproblems: three points of one shape with all their candidates.

Triples with third-order costs take over all costs of their pairs. Three pairs of points may have
minimisers that no common choice for the three points attains: the minimum of a triple is at least
the sum of the pairs' minima, even without its own costs.
"""

from itertools import combinations
from typing import NamedTuple

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.kernel import kernel
from solver.optimisation.dual_decomposition.exchange import Exchange, Used, used_once
from solver.optimisation.dual_decomposition.groups import (
    NOTHING,
    Groups,
    Side,
    candidates_at,
    gather,
    numbers,
    offsets,
    rows_of,
)
from solver.optimisation.dual_decomposition.linear import LinearSubproblem
from solver.optimisation.dual_decomposition.pairs import PairSubproblems


class Triples(NamedTuple):
    """Three points of one side each, and their costs.

    Attributes
    ----------
    points
        (T, 3) ascending.
    groups
        (T, 3) the pairs' subproblems: of the first and second point, the first and third, the
        second and third.
    unary
        (T+1,) offsets of the unary costs, the candidates of the three points in turn.
    pairwise
        (T+1,) offsets of the pairwise costs, three blocks in the order of `groups`.
    third
        (T+1,) offsets of the third-order costs.
    """

    points: IntArray
    groups: IntArray
    unary: IntArray
    pairwise: IntArray
    third: IntArray


def triples_of(side: Side, groups: Groups, points: IntArray) -> Triples:
    """Return the layout of the (T, 3) triples of points."""
    number = numbers(side, groups)
    p, q, r = points.T
    members = np.stack([number[p, q], number[p, r], number[q, r]], axis=1)
    sizes = np.diff(side.first)[points]
    k, m, n = sizes.T
    return Triples(
        points,
        members,
        offsets(sizes.sum(axis=1)),
        offsets(k * m + k * n + m * n),
        offsets(k * m * n),
    )


def disjoint_sets(points: IntArray) -> list[IntArray]:
    """Divide triples into sets in which no two share two points.

    Parameters
    ----------
    points
        (T, 3) points of each.

    Returns
    -------
    Numbers of the triples in each set, ascending.
    """
    members: list[list[int]] = []
    taken: list[set[tuple[int, int]]] = []
    for t, triple in enumerate(points.tolist()):
        pairs = set(combinations(triple, 2))
        place = next((k for k, used in enumerate(taken) if not used & pairs), len(taken))
        if place == len(taken):
            members.append([])
            taken.append(set())
        members[place].append(t)
        taken[place] |= pairs
    return [np.array(one, dtype=np.int64) for one in members]


class TripleSubproblems:
    """Triple subproblems of one shape, which take over the costs of their pairs.

    Parameters
    ----------
    pairs
        The pairs of the same shape, with full blocks; the triples' costs are taken from theirs.
    triples
        The triples; no two share a pair.
    third
        Third-order costs at their offsets.

    Attributes
    ----------
    unary, pairwise
        Their costs.
    candidate_at, place_at
        Candidate of each unary cost; position of each pairwise cost among those of the pairs.
    """

    def __init__(self, pairs: PairSubproblems, triples: Triples, third: FloatArray) -> None:
        self._pairs, self._triples, self._third = pairs, triples, third
        self.candidate_at = candidates_at(pairs.side, triples.points)
        places = np.arange(len(pairs.pairwise))
        self.place_at = gather(pairs.groups.pairwise, places, triples.groups.ravel())
        self.unary, self.pairwise = _take_over(
            pairs.side, pairs.groups, triples, pairs.unary, pairs.pairwise
        )
        self._unary_rows = rows_of(self.candidate_at, len(pairs.side.point))
        self._pair_order = np.argsort(self.place_at, kind="stable").astype(np.int64)
        self._minima: FloatArray = np.zeros(len(triples.points))
        self._choices: IntArray = np.full((len(triples.points), 3), NOTHING, dtype=np.int64)

    def minimise(self) -> float:
        """Solve all of them; return the sum of the minima."""
        side, optional = self._pairs.side, self._pairs.optional
        costs = self.unary, self.pairwise, self._third
        _minimise(side, self._triples, *costs, optional, self._choices, self._minima)
        return float(self._minima.sum())

    def slacks(self) -> list[FloatArray]:
        """Return the costs of each triple above its minimum.

        Returns
        -------
        Of each, (k, m, n) for the candidates of its points; 0 where they exclude one another.
        """
        return [self._slack(t) for t in range(len(self._triples.points))]

    def _slack(self, t: int) -> FloatArray:
        triples = self._triples
        k, m, n = _shape_of(self._pairs.side, triples.points[t])
        one, two, three = np.split(self.unary[triples.unary[t] : triples.unary[t + 1]], [k, k + m])
        own = self.pairwise[triples.pairwise[t] : triples.pairwise[t + 1]]
        first, second, third = np.split(own, [k * m, k * m + k * n])
        costs = one[:, None, None] + two[:, None] + three + first.reshape(k, m, 1)
        costs += second.reshape(k, 1, n) + third.reshape(m, n) - self._minima[t]
        costs += self._third[triples.third[t] : triples.third[t + 1]].reshape(k, m, n)
        return np.where(np.isfinite(costs), np.maximum(costs, 0.0), 0.0)

    def exchanges(self, linear: LinearSubproblem) -> list[Exchange]:
        """Exchanges of unary costs with the linear subproblem, of pairwise costs with the pairs."""
        pairs = self._pairs
        possible = np.where(np.isfinite(self.pairwise), self.place_at, NOTHING)
        return [
            Exchange(
                self.unary,
                linear.unary,
                self.candidate_at,
                gains=lambda: self.used[0],
                losses=lambda: self.unary_places_of(linear.used),
            ),
            Exchange(
                self.pairwise,
                pairs.pairwise,
                possible,
                gains=lambda: self.used[1],
                losses=lambda: self.pairwise_places_of(pairs.used_pairwise),
            ),
        ]

    @property
    def used(self) -> tuple[Used, Used]:
        """Positions of the unary and of the pairwise costs that the minimisers use."""
        unary, pairwise = _positions(self._pairs.side, self._triples, self._choices)
        return used_once(unary), used_once(pairwise)

    def unary_places_of(self, candidates: IntArray) -> Used:
        """Positions of all unary costs of some candidates."""
        return used_once(gather(*self._unary_rows, candidates))

    def pairwise_places_of(self, places: IntArray) -> Used:
        """Positions of the costs that were taken from some of the pairs' costs."""
        ordered = self.place_at[self._pair_order]
        found = np.minimum(np.searchsorted(ordered, places), len(ordered) - 1)
        return used_once(self._pair_order[found[ordered[found] == places]])


@kernel
def _shape_of(side: Side, points: IntArray) -> tuple[int, int, int]:
    """Numbers of candidates of three points."""
    p, q, r = points
    return (
        side.first[p + 1] - side.first[p],
        side.first[q + 1] - side.first[q],
        side.first[r + 1] - side.first[r],
    )


@kernel
def _solve(
    one: FloatArray,
    two: FloatArray,
    three: FloatArray,
    blocks: tuple[FloatArray, FloatArray, FloatArray],
    costs: FloatArray,
    optional: bool,
) -> tuple[float, int, int, int]:
    """Minimum over one candidate for each point, or none where that is allowed."""
    first, second, third = blocks
    least = -1 if optional else 0
    best, best_i, best_j, best_k = np.inf, NOTHING, NOTHING, NOTHING
    for i in range(least, len(one)):
        alone = one[i] if i >= 0 else 0.0
        for j in range(least, len(two)):
            both = alone
            if j >= 0:
                both += two[j]
                if i >= 0:
                    both += first[i, j]
            if np.isinf(both):
                continue
            if optional and both < best:
                best, best_i, best_j, best_k = both, i, j, NOTHING
            for k in range(len(three)):
                cost = both + three[k]
                if i >= 0:
                    cost += second[i, k]
                if j >= 0:
                    cost += third[j, k]
                    if i >= 0:
                        cost += costs[i, j, k]
                if cost < best:
                    best, best_i, best_j, best_k = cost, i, j, k
    return best, best_i, best_j, best_k


@kernel
def _take_over(
    side: Side, groups: Groups, triples: Triples, unary: FloatArray, pairwise: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Move all costs of the triples' pairs to the triples."""
    own_unary = np.zeros(triples.unary[-1])
    own_pairwise = np.empty(triples.pairwise[-1])
    for t in range(len(triples.points)):
        k, m, n = _shape_of(side, triples.points[t])
        start = triples.unary[t]
        starts = (start, start + k, start + k + m)
        lengths = (k, m, n)
        place = triples.pairwise[t]
        for which in range(3):
            g = triples.groups[t, which]
            for e in range(groups.pairwise[g], groups.pairwise[g + 1]):
                own_pairwise[place] = pairwise[e]
                if np.isfinite(pairwise[e]):
                    pairwise[e] = 0.0
                place += 1
            position = groups.unary[g]
            for member in ((0, 1), (0, 2), (1, 2))[which]:
                for i in range(lengths[member]):
                    own_unary[starts[member] + i] += unary[position]
                    unary[position] = 0.0
                    position += 1
    return own_unary, own_pairwise


@kernel
def _minimise(
    side: Side,
    triples: Triples,
    unary: FloatArray,
    pairwise: FloatArray,
    third: FloatArray,
    optional: bool,
    choices: IntArray,
    minima: FloatArray,
) -> None:
    for t in range(len(triples.points)):
        k, m, n = _shape_of(side, triples.points[t])
        u, e = triples.unary[t], triples.pairwise[t]
        blocks = (
            pairwise[e : e + k * m].reshape(k, m),
            pairwise[e + k * m : e + k * m + k * n].reshape(k, n),
            pairwise[e + k * m + k * n : triples.pairwise[t + 1]].reshape(m, n),
        )
        minima[t], choices[t, 0], choices[t, 1], choices[t, 2] = _solve(
            unary[u : u + k],
            unary[u + k : u + k + m],
            unary[u + k + m : u + k + m + n],
            blocks,
            third[triples.third[t] : triples.third[t + 1]].reshape(k, m, n),
            optional,
        )


@kernel
def _positions(side: Side, triples: Triples, choices: IntArray) -> tuple[IntArray, IntArray]:
    unary = np.empty(3 * len(choices), dtype=np.int64)
    pairwise = np.empty(3 * len(choices), dtype=np.int64)
    u = e = 0
    for t in range(len(choices)):
        k, m, n = _shape_of(side, triples.points[t])
        i, j, h = choices[t]
        start, place = triples.unary[t], triples.pairwise[t]
        if i >= 0:
            unary[u] = start + i
            u += 1
        if j >= 0:
            unary[u] = start + k + j
            u += 1
        if h >= 0:
            unary[u] = start + k + m + h
            u += 1
        if i >= 0 and j >= 0:
            pairwise[e] = place + i * m + j
            e += 1
        if i >= 0 and h >= 0:
            pairwise[e] = place + k * m + i * n + h
            e += 1
        if j >= 0 and h >= 0:
            pairwise[e] = place + k * m + k * n + j * n + h
            e += 1
    return unary[:u], pairwise[:e]
