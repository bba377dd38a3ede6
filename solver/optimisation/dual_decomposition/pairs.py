"""Pair subproblems: two source points, or two target points, with all their candidates.

A source point of a subproblem takes one of its candidates (or none, where source points may stay
unmatched); a target point is taken by one of its candidates or by none (unless every target point
must be taken). Two candidates that exclude one another are never taken together.
"""

from dataclasses import dataclass

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
    match_full,
    match_sparse,
    rows_of,
)
from solver.optimisation.dual_decomposition.linear import LinearSubproblem


@dataclass(eq=False)
class PairSubproblems:
    """Pair subproblems of one shape.

    Parameters
    ----------
    side
        The candidates.
    groups
        Pairs of points that have a subproblem.
    pairwise
        (E,) pairwise costs, at the groups' offsets; ``inf`` where candidates exclude one another.
    optional
        Whether a point may take nothing, at no cost.

    Attributes
    ----------
    unary
        (S,) unary costs, at the groups' offsets; zero at first.
    minima
        (G,) the minima.
    choices
        (G, 3) the minimisers: number of p's candidate, of q's, and position of their pairwise cost,
        `NOTHING` for none.
    """

    side: Side
    groups: Groups
    pairwise: FloatArray
    optional: bool

    def __post_init__(self) -> None:
        count = len(self.groups.points)
        self.candidate_at = candidates_at(self.side, self.groups.points)
        self.unary: FloatArray = np.zeros(len(self.candidate_at))
        self.minima: FloatArray = np.zeros(count)
        self._places = rows_of(self.candidate_at, len(self.side.point))
        self.choices: IntArray = np.full((count, 3), NOTHING, dtype=np.int64)

    def minimise(self) -> float:
        """Solve all of them; return the sum of the minima, ``inf`` when one has no solution."""
        solve = _minimise_listed if self.groups.listed else _minimise_full
        solve(
            self.side, self.groups, self.unary, self.pairwise, self.optional,
            self.choices, self.minima,
        )  # fmt: skip
        return float(self.minima.sum())

    @property
    def used_unary(self) -> Used:
        """Positions of the unary costs that the minimisers use."""
        return used_once(_positions(self.side, self.groups, self.choices))

    @property
    def used_pairwise(self) -> IntArray:
        """Positions of the pairwise costs that the minimisers use."""
        chosen: IntArray = self.choices[:, 2][self.choices[:, 2] != NOTHING]
        return chosen

    def places_of(self, candidates: IntArray) -> Used:
        """Positions of all unary costs of some candidates."""
        return used_once(gather(*self._places, candidates))

    def exchanges(self, linear: LinearSubproblem) -> list[Exchange]:
        """Exchange of unary costs with the linear subproblem."""
        return [
            Exchange(
                self.unary,
                linear.unary,
                self.candidate_at,
                gains=lambda: self.used_unary,
                losses=lambda: self.places_of(linear.used),
            )
        ]

    def exchange_with(self, target: "PairSubproblems") -> Exchange:
        """Exchange of pairwise costs with the pairs of the other shape."""
        match = match_sparse if self.groups.listed else match_full
        there, back = match(self.side, self.groups, target.side, target.groups)
        return Exchange(
            self.pairwise,
            target.pairwise,
            there,
            gains=lambda: used_once(self.used_pairwise),
            losses=lambda: used_once(back[target.used_pairwise]),
        )

    def add_slack(self, pairwise: FloatArray) -> None:
        """Add to a (V, V) matrix the cost of every two candidates above their group's minimum.

        Time is O(V²).
        """
        _add_slack(self.side, self.groups, self.unary, self.pairwise, self.minima, pairwise)


@kernel
def _positions(side: Side, groups: Groups, choices: IntArray) -> IntArray:
    points, starts, first = groups.points, groups.unary, side.first
    found = np.empty(2 * len(choices), dtype=np.int64)
    k = 0
    for g in range(len(choices)):
        p = points[g, 0]
        if choices[g, 0] != NOTHING:
            found[k] = starts[g] + choices[g, 0]
            k += 1
        if choices[g, 1] != NOTHING:
            found[k] = starts[g] + first[p + 1] - first[p] + choices[g, 1]
            k += 1
    return found[:k]


@kernel
def _best_alone(
    unary: FloatArray, start: int, middle: int, end: int, optional: bool
) -> tuple[float, int, int]:
    """Least cost with at most one candidate taken; ``inf`` where both points must take one."""
    best, i, j = np.inf, NOTHING, NOTHING
    if optional:
        best = 0.0
        for k in range(start, middle):
            if unary[k] < best:
                best, i = unary[k], k - start
        for k in range(middle, end):
            if unary[k] < best:
                best, i, j = unary[k], NOTHING, k - middle
    return best, i, j


# The loops below take no array out of a tuple and make no view: both count references, which takes
# longer than a small subproblem.


@kernel
def _minimise_full(
    side: Side,
    groups: Groups,
    unary: FloatArray,
    pairwise: FloatArray,
    optional: bool,
    choices: IntArray,
    minima: FloatArray,
) -> None:
    points, first = groups.points, side.first
    unary_first, pairwise_first = groups.unary, groups.pairwise
    for g in range(len(points)):
        p = points[g, 0]
        start, end = unary_first[g], unary_first[g + 1]
        middle = start + first[p + 1] - first[p]
        best, best_i, best_j = _best_alone(unary, start, middle, end, optional)
        best_e = NOTHING
        # The position of j's cost in i's row is j - shift.
        shift = middle - pairwise_first[g]
        for i in range(start, middle):
            left = best - unary[i]
            for j in range(middle, end):
                cost = unary[j] + pairwise[j - shift]
                if cost < left:
                    left = cost
                    best, best_i, best_j = unary[i] + cost, i - start, j - middle
                    best_e = j - shift
            shift -= end - middle
        choices[g, 0], choices[g, 1], choices[g, 2] = best_i, best_j, best_e
        minima[g] = best


@kernel
def _minimise_listed(
    side: Side,
    groups: Groups,
    unary: FloatArray,
    pairwise: FloatArray,
    optional: bool,
    choices: IntArray,
    minima: FloatArray,
) -> None:
    points, first, order, others = groups.points, side.first, side.order, side.other
    unary_first, pairwise_first = groups.unary, groups.pairwise
    rows, columns = groups.rows, groups.columns
    largest = np.diff(first).max()
    # The last group that had a cost for a pair of candidates: such a pair never goes without it.
    costly = np.full((largest, largest), NOTHING, dtype=np.int64)
    for g in range(len(points)):
        p, q = points[g, 0], points[g, 1]
        start, end = unary_first[g], unary_first[g + 1]
        middle = start + first[p + 1] - first[p]
        best, best_i, best_j = _best_alone(unary, start, middle, end, optional)
        best_e = NOTHING
        for e in range(pairwise_first[g], pairwise_first[g + 1]):
            i, j = rows[e], columns[e]
            costly[i, j] = g
            cost = unary[start + i] + unary[middle + j] + pairwise[e]
            if cost < best:
                best, best_i, best_j, best_e = cost, i, j, e
        least = np.inf
        for j in range(middle, end):
            least = min(least, unary[j])
        for i in range(middle - start):
            alone = unary[start + i]
            if not alone + least < best:
                continue
            other = others[order[first[p] + i]]
            for j in range(end - middle):
                cost = alone + unary[middle + j]
                if cost < best and costly[i, j] != g and others[order[first[q] + j]] != other:
                    best, best_i, best_j, best_e = cost, i, j, NOTHING
        choices[g, 0], choices[g, 1], choices[g, 2] = best_i, best_j, best_e
        minima[g] = best


@kernel
def _add_slack(
    side: Side,
    groups: Groups,
    unary: FloatArray,
    pairwise: FloatArray,
    minima: FloatArray,
    total: FloatArray,
) -> None:
    for g in range(len(groups.points)):
        p, q = groups.points[g]
        start = groups.unary[g]
        kp, kq = side.first[p + 1] - side.first[p], side.first[q + 1] - side.first[q]
        extra = np.zeros((kp, kq))
        for e in range(groups.pairwise[g], groups.pairwise[g + 1]):
            if groups.listed:
                extra[groups.rows[e], groups.columns[e]] = pairwise[e]
            else:
                k = e - groups.pairwise[g]
                extra[k // kq, k % kq] = pairwise[e]
        for i in range(kp):
            a = side.order[side.first[p] + i]
            for j in range(kq):
                b = side.order[side.first[q] + j]
                value = unary[start + i] + unary[start + kp + j] + extra[i, j] - minima[g]
                total[a, b] += value
                total[b, a] += value
