"""Division of third-order costs: as much as possible moves from triples to their pairs.

A triple receives the costs of its three pairs, and divides what it has then: each pair gets, for
every two candidates, a third of the least cost with any candidate of the third point, and in turn
what is left beyond (min-marginals, as in MPLP: Globerson and Jaakkola, "Fixing max-product:
convergent message passing algorithms for MAP LP-relaxations", NIPS 2007).
No cost becomes negative, so that the costs that stay at the triples may be left out of bounds.
"""

import numpy as np

from solver.arrays import FloatArray
from solver.labelling import triple_costs
from solver.optimisation.reparametrisation import ReparametrisedCosts
from solver.optimisation.rounding import allowance

_PAIRS = ((0, 1), (0, 2), (1, 2))
"""Places of the points of a triple that its pairs have."""
_THIRD = 2, 1, 0
"""Place of the third point, for each of the pairs."""


def divide_triples(costs: ReparametrisedCosts) -> ReparametrisedCosts:
    """Move costs from triples to their pairs, so that second-order bounds contain them.

    Where points may stay unmatched nothing is moved: a pair would keep its share when the third
    point is unmatched, and the triple costs nothing.

    Parameters
    ----------
    costs
        With pairwise costs that are not negative; others are returned as they are.

    Returns
    -------
    Costs that add up to the same for every correspondence of all points.
    """
    triples = costs.triples
    negative = costs.pairwise.min(initial=0.0) < -allowance(costs.constant, costs.scale)
    if not len(triples.points) or np.isfinite(costs.occlusion).any() or negative:
        return costs
    pairwise, tables = costs.pairwise.copy(), []
    for t, points in enumerate(triples.points):
        own = [slice(triples.rows[x], triples.rows[x + 1]) for x in points]
        blocks = [pairwise[own[i], own[j]] for i, j in _PAIRS]
        shares, left = _divide(triples.table(t), blocks)
        for (i, j), share in zip(_PAIRS, shares, strict=True):
            pairwise[own[i], own[j]], pairwise[own[j], own[i]] = share, share.T
        tables.append(left)
    divided = triple_costs(triples.rows, triples.points, tables)
    return costs._replace(pairwise=pairwise, triples=divided)


def _divide(table: FloatArray, blocks: list[FloatArray]) -> tuple[list[FloatArray], FloatArray]:
    """Divide the costs of a triple and of its pairs anew.

    Parameters
    ----------
    table
        (k, m, n) of the triple.
    blocks
        (k, m), (k, n) and (m, n) of its pairs, ``inf`` where candidates exclude one another.

    Returns
    -------
    The pairs' shares, and what stays at the triple.
    """
    if not table.size:
        return blocks, table
    total = table + blocks[0][:, :, None] + blocks[1][:, None, :] + blocks[2][None]
    shares = [total.min(axis=axis) / 3.0 for axis in _THIRD]
    left = total
    for share, axis in zip(shares, _THIRD, strict=True):
        left = left - _finite(share, axis)
    for share, axis in zip(shares, _THIRD, strict=True):
        rest = left.min(axis=axis)
        share += rest
        left = left - _finite(rest, axis)
    return shares, np.where(np.isfinite(total), np.maximum(left, 0.0), 0.0)


def _finite(costs: FloatArray, axis: int) -> FloatArray:
    """Costs of a pair as those of a triple, 0 where they are infinite."""
    finite: FloatArray = np.expand_dims(np.where(np.isfinite(costs), costs, 0.0), axis)
    return finite
