"""Third-order costs of a labelling problem: tables on triples of source points (7.1)."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.kernel import kernel

NO_TRIPLE = -1
"""Marks two source points that no triple contains."""


class TripleCosts(NamedTuple):
    """Costs of triples of source points, in arrays for compiled code; see :func:`triple_costs`.

    No two triples share two points: given the candidate of its third point, the cost of a triple is
    a pairwise cost of the other two, and every pair of points has at most one of these.

    Attributes
    ----------
    points
        (T, 3) source points, ascending.
    rows
        (N+1,) candidates of source point x are ``rows[x]`` to ``rows[x+1]``.
    first
        (T+1,) offsets of the triples' tables.
    costs
        The tables, row by row: a cost >= 0 for every three candidates of the three points.
    number
        (N, N) the triple that contains two points, `NO_TRIPLE` for none.
    """

    points: IntArray
    rows: IntArray
    first: IntArray
    costs: FloatArray
    number: IntArray

    def table(self, t: int) -> FloatArray:
        """Costs of triple t, a view: an axis for the candidates of each of its points."""
        sizes = np.diff(self.rows)[self.points[t]]
        return self.costs[self.first[t] : self.first[t + 1]].reshape(sizes)

    def among(self, kept: IntArray) -> "TripleCosts":
        """Return the costs of some of the candidates.

        Parameters
        ----------
        kept
            (V',) candidates, ascending.
        """
        if not len(self.points):
            return self
        rows = np.searchsorted(kept, self.rows).astype(np.int64)
        tables = []
        for t, points in enumerate(self.points):
            left = (kept[rows[x] : rows[x + 1]] - self.rows[x] for x in points)
            tables.append(self.table(t)[np.ix_(*left)])
        return triple_costs(rows, self.points, tables)


def triple_costs(rows: IntArray, points: IntArray, tables: Sequence[FloatArray]) -> TripleCosts:
    """Third-order costs of some triples of source points.

    Parameters
    ----------
    rows
        (N+1,) candidates of source point x are ``rows[x]`` to ``rows[x+1]``.
    points
        (T, 3) source points, ascending; no two triples share two points.
    tables
        Of each triple, finite costs >= 0 with an axis for the candidates of each of its points.

    Raises
    ------
    ValueError
        Two triples share two points, points are not ascending, or a table has another shape or
        other costs.
    """
    n, sizes = len(rows) - 1, np.diff(rows)
    number = np.full((n, n), NO_TRIPLE, dtype=np.int64)
    for t, (p, q, r) in enumerate(points):
        if not 0 <= p < q < r < n:
            raise ValueError("a triple needs three source points in ascending order")
        for one, other in (p, q), (p, r), (q, r):
            if number[one, other] != NO_TRIPLE:
                raise ValueError("two triples share two points")
            number[one, other] = number[other, one] = t
        if tables[t].shape != tuple(sizes[[p, q, r]]):
            raise ValueError("a triple needs a cost for every three candidates of its points")
        if not (np.isfinite(tables[t]) & (tables[t] >= 0.0)).all():
            raise ValueError("costs of triples must be finite and not negative")
    first = np.concatenate([[0], np.cumsum([table.size for table in tables])]).astype(np.int64)
    flat = [np.ravel(table) for table in tables]
    costs = np.concatenate(flat) if flat else np.empty(0)
    triples = np.ascontiguousarray(points, dtype=np.int64).reshape(-1, 3)
    return TripleCosts(triples, rows.astype(np.int64), first, costs.astype(np.float64), number)


NO_TRIPLES = triple_costs(np.zeros(1, dtype=np.int64), np.empty((0, 3), dtype=np.int64), [])
"""No third-order costs."""


@kernel
def triple_cost(triples: TripleCosts, t: int, a: int, b: int, c: int) -> float:
    """Cost of candidates of the three points of triple t, in their order; 0 if one is negative."""
    if a < 0 or b < 0 or c < 0:
        return 0.0
    rows, points = triples.rows, triples.points
    p, q, r = points[t, 0], points[t, 1], points[t, 2]
    place = (a - rows[p]) * (rows[q + 1] - rows[q]) + b - rows[q]
    place = place * (rows[r + 1] - rows[r]) + c - rows[r]
    cost: float = triples.costs[triples.first[t] + place]
    return cost


@kernel
def cost_given_third(
    triples: TripleCosts, chosen: IntArray, x: int, a: int, y: int, b: int
) -> float:
    """Cost of candidates a of x and b of y in their triple, given the candidate of its third point.

    Parameters
    ----------
    triples
        Third-order costs.
    chosen
        (N,) candidate of each source point, negative for none.
    x, y
        Two source points.
    a, b
        A candidate of each, negative for none.

    Returns
    -------
    0 where no triple contains both points, or one of its three points has no candidate.
    """
    if len(triples.points) == 0:
        return 0.0
    t = triples.number[x, y]
    if t < 0:
        return 0.0
    p, q, r = triples.points[t, 0], triples.points[t, 1], triples.points[t, 2]
    one = a if p == x else b if p == y else chosen[p]
    two = a if q == x else b if q == y else chosen[q]
    three = a if r == x else b if r == y else chosen[r]
    cost: float = triple_cost(triples, t, one, two, three)
    return cost


@kernel
def replace_triple_costs(
    triples: TripleCosts, chosen: IntArray, x: int, old: int, new: int, marginal: FloatArray
) -> None:
    """Replace the third-order costs with candidate `old` of x by those with `new`.

    Parameters
    ----------
    triples
        Third-order costs.
    chosen
        (N,) candidate of each source point, negative for none.
    x
        A source point.
    old, new
        Candidates of it, negative for none.
    marginal
        (V,) cost of each candidate given those chosen for the other points; changed in place,
        except for candidates of x itself.
    """
    for t in range(len(triples.points)):
        if not (triples.points[t] == x).any():
            continue
        for place in range(3):
            y = triples.points[t, place]
            if y == x:
                continue
            for b in range(triples.rows[y], triples.rows[y + 1]):
                marginal[b] += cost_given_third(triples, chosen, x, new, y, b)
                marginal[b] -= cost_given_third(triples, chosen, x, old, y, b)


@kernel
def costs_of_triples(triples: TripleCosts, chosen: IntArray) -> FloatArray:
    """(T,) cost of each triple.

    Parameters
    ----------
    triples
        Third-order costs.
    chosen
        (N,) candidate of each source point, negative for none.
    """
    found = np.empty(len(triples.points))
    for t in range(len(found)):
        p, q, r = triples.points[t, 0], triples.points[t, 1], triples.points[t, 2]
        found[t] = triple_cost(triples, t, chosen[p], chosen[q], chosen[r])
    return found
