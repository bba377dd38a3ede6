"""Layout of the pair subproblems: their points, and the positions of their costs."""

from typing import NamedTuple

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.kernel import kernel
from solver.labelling import LabellingProblem, PairwiseCosts, metric_cost

NOTHING = -1
"""Marks a point that takes no candidate in a local subproblem."""


class Side(NamedTuple):
    """The candidates, grouped by the points of one shape.

    Attributes
    ----------
    point, other
        (V,) the point of this shape, and of the other one, of each candidate.
    first, order
        (P+1,) and (V,): the candidates of point p are ``order[first[p]:first[p+1]]``.
    """

    point: IntArray
    other: IntArray
    first: IntArray
    order: IntArray


class Groups(NamedTuple):
    """Pairs (p, q) of points of one side, p < q, that have a local subproblem, and their costs.

    Attributes
    ----------
    points
        (G, 2) p and q.
    unary
        (G+1,) offsets of the subproblems' unary costs: p's candidates, then q's.
    pairwise
        (G+1,) offsets of the subproblems' pairwise costs.
    listed
        Whether costs are listed for some pairs of candidates; otherwise they are full blocks, with
        a row for each candidate of p.
    rows, columns
        (E,) candidate of p and of q, by its rank, of each listed cost; empty for full blocks.
    """

    points: IntArray
    unary: IntArray
    pairwise: IntArray
    listed: bool
    rows: IntArray
    columns: IntArray


def sides_of(problem: LabellingProblem) -> tuple[Side, Side]:
    """Return the candidates grouped by source points, and by target points."""
    x, y = (np.ascontiguousarray(column) for column in problem.candidates.T)
    return _side(x, y, problem.n_sources), _side(y, x, problem.n_targets)


def _side(point: IntArray, other: IntArray, count: int) -> Side:
    return Side(point, other, *rows_of(point, count))


def full_groups(side: Side) -> Groups:
    """All pairs of points that have candidates, and all pairs of their candidates."""
    counts = np.diff(side.first)
    present = np.flatnonzero(counts)
    p, q = np.triu_indices(len(present), 1)
    points = np.stack([present[p], present[q]], axis=1).astype(np.int64)
    sizes = counts[points]
    none = np.empty(0, dtype=np.int64)
    return Groups(
        points, offsets(sizes.sum(axis=1)), offsets(sizes.prod(axis=1)), False, none, none
    )


def sparse_groups(side: Side, first: IntArray, second: IntArray) -> tuple[Groups, IntArray]:
    """Pairs of points that have pairwise costs, and these.

    Parameters
    ----------
    side
        The candidates.
    first, second
        (E,) the candidates of each cost; compatible.

    Returns
    -------
    groups, order
        The groups, and the (E,) order in which they have the costs.
    """
    swap = side.point[first] > side.point[second]
    one, two = np.where(swap, second, first), np.where(swap, first, second)
    key = side.point[one] * (len(side.first) - 1) + side.point[two]
    order = np.lexsort((two, one, key)).astype(np.int64)
    keys, starts = np.unique(key[order], return_index=True)
    points = np.stack(np.divmod(keys, len(side.first) - 1), axis=1).astype(np.int64)
    rank = _ranks(side)
    sizes = np.diff(side.first)[points].sum(axis=1)
    pairwise = np.append(starts, len(first)).astype(np.int64)
    return Groups(points, offsets(sizes), pairwise, True, rank[one[order]], rank[two[order]]), order


def offsets(sizes: IntArray) -> IntArray:
    """Return where each of several runs begins, and where the last one ends."""
    return np.concatenate([[0], np.cumsum(sizes)]).astype(np.int64)


@kernel
def full_costs(side: Side, groups: Groups, costs: PairwiseCosts, share: float) -> FloatArray:
    """Blocks of pairwise costs, explicit terms left out.

    Parameters
    ----------
    side, groups
        The candidates, and groups with full blocks.
    costs
        Of the problem.
    share
        Factor on them.

    Returns
    -------
    (E,) float64; ``inf`` where candidates exclude one another.
    """
    values = np.empty(groups.pairwise[-1])
    for g in range(len(groups.points)):
        p, q = groups.points[g]
        e = groups.pairwise[g]
        for i in range(side.first[p], side.first[p + 1]):
            a = side.order[i]
            for j in range(side.first[q], side.first[q + 1]):
                b = side.order[j]
                values[e] = np.inf
                if side.other[a] != side.other[b]:
                    values[e] = share * metric_cost(costs, a, b)
                e += 1
    return values


def block_positions(side: Side, groups: Groups, first: IntArray, second: IntArray) -> IntArray:
    """Positions in full blocks of the costs of given candidates.

    Parameters
    ----------
    side, groups
        The candidates, and groups with full blocks.
    first, second
        (E,) candidates at different points of this side.

    Returns
    -------
    (E,) int64 positions.
    """
    rank = _ranks(side)
    swap = side.point[first] > side.point[second]
    one, two = np.where(swap, second, first), np.where(swap, first, second)
    width = np.diff(side.first)[side.point[two]]
    start = groups.pairwise[numbers(side, groups)[side.point[one], side.point[two]]]
    found: IntArray = start + rank[one] * width + rank[two]
    return found


@kernel
def numbers(side: Side, groups: Groups) -> IntArray:
    """Return the (P, P) number of each pair's group, `NOTHING` where it has none or p >= q."""
    count = len(side.first) - 1
    number = np.full((count, count), NOTHING, dtype=np.int64)
    for g in range(len(groups.points)):
        number[groups.points[g, 0], groups.points[g, 1]] = g
    return number


@kernel
def _ranks(side: Side) -> IntArray:
    """Place of each candidate among those of its point."""
    rank = np.empty(len(side.point), dtype=np.int64)
    for p in range(len(side.first) - 1):
        for i in range(side.first[p], side.first[p + 1]):
            rank[side.order[i]] = i - side.first[p]
    return rank


@kernel
def match_full(
    side: Side, groups: Groups, other: Side, others: Groups
) -> tuple[IntArray, IntArray]:
    """Find the costs of full blocks of one side in those of the other side, and back.

    Parameters
    ----------
    side, groups, other, others
        Both sides' candidates and groups with full blocks.

    Returns
    -------
    there, back
        (E,) position in the other side's blocks of each cost of this side's, `NOTHING` where the
        candidates exclude one another; and the same from the other side.
    """
    number, rank = numbers(other, others), _ranks(other)
    there = np.full(groups.pairwise[-1], NOTHING, dtype=np.int64)
    back = np.full(others.pairwise[-1], NOTHING, dtype=np.int64)
    for g in range(len(groups.points)):
        p, q = groups.points[g]
        e = groups.pairwise[g]
        for i in range(side.first[p], side.first[p + 1]):
            for j in range(side.first[q], side.first[q + 1]):
                a, b = side.order[i], side.order[j]
                if other.point[a] > other.point[b]:
                    a, b = b, a
                y, z = other.point[a], other.point[b]
                if y != z:
                    width = other.first[z + 1] - other.first[z]
                    there[e] = others.pairwise[number[y, z]] + rank[a] * width + rank[b]
                    back[there[e]] = e
                e += 1
    return there, back


def match_sparse(
    side: Side, groups: Groups, other: Side, others: Groups
) -> tuple[IntArray, IntArray]:
    """Find the listed costs of one side's groups in those of the other side, and back.

    Parameters
    ----------
    side, groups, other, others
        Both sides' candidates and groups with listed costs, which are the same.

    Returns
    -------
    there, back
        (E,) position on the other side of each cost of this side; and back.
    """
    here = _keys(*candidates_of(side, groups), len(side.point))
    elsewhere = _keys(*candidates_of(other, others), len(side.point))
    order = np.argsort(elsewhere)
    there = order[np.searchsorted(elsewhere[order], here)].astype(np.int64)
    return there, np.argsort(there).astype(np.int64)


def _keys(one: IntArray, two: IntArray, width: int) -> IntArray:
    keys: IntArray = np.minimum(one, two) * width + np.maximum(one, two)
    return keys


def candidates_of(side: Side, groups: Groups) -> tuple[IntArray, IntArray]:
    """Return the two candidates, (E,) each, that each pairwise cost belongs to."""
    group = np.repeat(np.arange(len(groups.points)), np.diff(groups.pairwise))
    p, q = groups.points[group].T
    rows, columns = groups.rows, groups.columns
    if not groups.listed:
        places = np.arange(len(group)) - groups.pairwise[group]
        rows, columns = np.divmod(places, np.diff(side.first)[q])
    one: IntArray = side.order[side.first[p] + rows]
    two: IntArray = side.order[side.first[q] + columns]
    return one, two


def candidates_at(side: Side, points: IntArray) -> IntArray:
    """Return the candidate that each unary cost of (G, k) groups of points belongs to."""
    return gather(side.first, side.order, points.ravel())


def rows_of(index: IntArray, count: int) -> tuple[IntArray, IntArray]:
    """Positions of each value of an index, in compressed rows."""
    places = np.argsort(index, kind="stable").astype(np.int64)
    return np.searchsorted(index[places], np.arange(count + 1)).astype(np.int64), places


@kernel
def gather(first: IntArray, places: IntArray, rows: IntArray) -> IntArray:
    """Return the entries of some of the compressed rows, one after the other."""
    total = 0
    for row in rows:
        total += first[row + 1] - first[row]
    found = np.empty(total, dtype=np.int64)
    k = 0
    for row in rows:
        for i in range(first[row], first[row + 1]):
            found[k] = places[i]
            k += 1
    return found
