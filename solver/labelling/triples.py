"""Third-order costs of a labelling problem: tables on triples of source points (7.1)."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.kernel import kernel

_NONE = -1
"""Fills up lists of triples."""


class TripleCosts(NamedTuple):
    """Costs of triples of source points, in arrays for compiled code; see :func:`triple_costs`.

    Given the candidate of its third point, the cost of a triple is a pairwise cost of the other
    two.

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
    containing
        (N, K) the triples that contain each source point, then -1.
    """

    points: IntArray
    rows: IntArray
    first: IntArray
    costs: FloatArray
    containing: IntArray

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
        (T, 3) source points, ascending; each triple once.
    tables
        Of each triple, finite costs >= 0 with an axis for the candidates of each of its points.

    Returns
    -------
    Costs of the triples of which every point has candidates; the others cost nothing.

    Raises
    ------
    ValueError
        A triple is given twice, its points are not ascending, or a table has another shape or other
        costs.
    """
    points = np.ascontiguousarray(points, dtype=np.int64).reshape(-1, 3)
    n, sizes = len(rows) - 1, np.diff(rows)
    if len(points) and not ((points[:, 0] >= 0) & (points[:, 2] < n)).all():
        raise ValueError("a triple has a source point that does not exist")
    if (np.diff(points, axis=1) <= 0).any():
        raise ValueError("a triple needs three source points in ascending order")
    if len(np.unique(points, axis=0)) < len(points):
        raise ValueError("a triple is given twice")
    for triple, table in zip(points, tables, strict=True):
        if table.shape != tuple(sizes[triple]):
            raise ValueError("a triple needs a cost for every three candidates of its points")
        if not (np.isfinite(table) & (table >= 0.0)).all():
            raise ValueError("costs of triples must be finite and not negative")
    costly = np.array([table.size > 0 for table in tables], dtype=np.bool_)
    points, tables = points[costly], [table for table in tables if table.size]
    first = np.concatenate([[0], np.cumsum([table.size for table in tables])]).astype(np.int64)
    costs = np.concatenate([np.empty(0), *(np.ravel(table) for table in tables)])
    return TripleCosts(points, rows.astype(np.int64), first, costs, _containing(points, n))


def _containing(points: IntArray, n: int) -> IntArray:
    """(N, K) the triples that contain each of N points, ascending, then -1."""
    lists = [np.flatnonzero((points == x).any(axis=1)) for x in range(n)]
    found = np.full((n, max((len(one) for one in lists), default=0)), _NONE, dtype=np.int64)
    for row, one in zip(found, lists, strict=True):
        row[: len(one)] = one
    return found


NO_TRIPLES = triple_costs(np.zeros(1, dtype=np.int64), np.empty((0, 3), dtype=np.int64), [])
"""No third-order costs."""


@kernel
def triple_cost(
    triples: TripleCosts, t: int, chosen: IntArray, x: int, a: int, y: int, b: int
) -> float:
    """Cost of triple t with the candidates chosen, but a for point x and b for point y.

    Parameters
    ----------
    triples
        Third-order costs.
    t
        A triple.
    chosen
        (N,) candidate of each source point, negative for none.
    x, a, y, b
        Points and their candidates, negative for none. One point may be given twice.

    Returns
    -------
    0 if one of its points has no candidate.
    """
    rows, place = triples.rows, 0
    for k in range(3):
        point = triples.points[t, k]
        candidate = a if point == x else b if point == y else chosen[point]
        if candidate < 0:
            return 0.0
        place = place * (rows[point + 1] - rows[point]) + candidate - rows[point]
    cost: float = triples.costs[triples.first[t] + place]
    return cost


@kernel
def cost_given_third(
    triples: TripleCosts, chosen: IntArray, x: int, a: int, y: int, b: int
) -> float:
    """Cost of candidates a of x and b of y in their triples, given the candidates of third points.

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
    """
    cost = 0.0
    if len(triples.points) == 0 or a < 0 or b < 0:
        return cost
    for k in range(triples.containing.shape[1]):
        t = triples.containing[x, k]
        if t < 0:
            break
        if triples.points[t, 0] == y or triples.points[t, 1] == y or triples.points[t, 2] == y:
            cost += triple_cost(triples, t, chosen, x, a, y, b)
    return cost


@kernel
def add_triple_costs(triples: TripleCosts, chosen: IntArray, x: int, costs: FloatArray) -> None:
    """Add to the cost of each candidate of x those of its triples, given the other points.

    Parameters
    ----------
    triples
        Third-order costs.
    chosen
        (N,) candidate of each source point, negative for none.
    x
        A source point.
    costs
        Of its candidates; changed in place.
    """
    if len(triples.points) == 0:
        return
    for k in range(triples.containing.shape[1]):
        t = triples.containing[x, k]
        if t < 0:
            break
        for i in range(len(costs)):
            a = triples.rows[x] + i
            costs[i] += triple_cost(triples, t, chosen, x, a, x, a)


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
    if len(triples.points) == 0:
        return
    for k in range(triples.containing.shape[1]):
        t = triples.containing[x, k]
        if t < 0:
            break
        for place in range(3):
            y = triples.points[t, place]
            if y == x:
                continue
            for b in range(triples.rows[y], triples.rows[y + 1]):
                marginal[b] += triple_cost(triples, t, chosen, x, new, y, b)
                marginal[b] -= triple_cost(triples, t, chosen, x, old, y, b)


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
        x = triples.points[t, 0]
        found[t] = triple_cost(triples, t, chosen, x, chosen[x], x, chosen[x])
    return found
