"""Fusion of two correspondences into one that is no worse than either.

Where two correspondences differ they form alternating paths and cycles, each of which can be taken
from either without changing the points of the others. The choice is a quadratic problem with one
binary variable for each: few, as a rule, even where many points differ. After Hutschenreiter et
al., "Fusion moves for graph matching", ICCV 2021.
"""

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import connected_components

from solver.arrays import FloatArray, IntArray
from solver.kernel import kernel
from solver.labelling import UNMATCHED, LabellingProblem, PairwiseCosts, pairwise_cost
from solver.optimisation.rounding import allowance

_ENUMERATED = 14
"""Parts up to which all choices are enumerated, 2¹⁴; of more, single parts are improved in turn."""


def fuse(problem: LabellingProblem, first: IntArray, second: IntArray) -> IntArray:
    """Fuse two correspondences: the better of both wherever they differ independently.

    Parameters
    ----------
    problem
        The labelling problem.
    first, second
        (N,) two of its correspondences, ``UNMATCHED`` for none.

    Returns
    -------
    (N,) int64 correspondence made of pairs of either; its energy is no greater than that of the
    better one. Where the two differ in at most 14 paths and cycles, the best choice among all that
    take each of these from one or the other, by the costs without third-order ones.
    """
    parts = _parts(problem, first, second)
    count = int(parts.max(initial=-1)) + 1
    if count == 0:
        return first
    chosen = np.stack([problem.chosen_candidates(first), problem.chosen_candidates(second)])
    unary, pairwise = _costs_of_parts(
        problem.pairwise_costs, problem.unary, float(problem.occlusion_cost), chosen, parts, count
    )
    start = int(problem.energy(second) < problem.energy(first))
    side = _choose(unary, pairwise, np.full(count, start), problem.scale)
    takes_second = np.append(side, 0)[parts] == 1
    fused = np.where(takes_second, second, first)
    if not len(problem.triples.points):
        return fused
    return min((fused, first, second), key=problem.energy)


def _parts(problem: LabellingProblem, first: IntArray, second: IntArray) -> IntArray:
    """(N,) number of the part each source point is in, -1 where the correspondences agree."""
    n, m = problem.shape
    differs = np.flatnonzero(first != second)
    ends = [(x, y[x]) for y in (first, second) for x in differs if y[x] != UNMATCHED]
    rows, columns = np.array(ends, dtype=np.int64).reshape(-1, 2).T
    graph = sparse.coo_array((np.ones(len(rows)), (rows, n + columns)), shape=(n + m, n + m))
    _, label = connected_components(graph, directed=False)
    parts = np.full(n, -1, dtype=np.int64)
    parts[differs] = np.unique(label[differs], return_inverse=True)[1]
    return parts


@kernel
def _costs_of_parts(
    costs: PairwiseCosts,
    unary: FloatArray,
    occlusion_cost: float,
    chosen: IntArray,
    parts: IntArray,
    count: int,
) -> tuple[FloatArray, FloatArray]:
    """Costs of both choices for a part, (count, 2), and for two, (count, 2, count, 2)."""
    n = len(parts)
    alone = np.zeros((count, 2))
    together = np.zeros((count, 2, count, 2))
    for x in range(n):
        p = parts[x]
        if p < 0:
            continue
        for s in range(2):
            a = chosen[s, x]
            alone[p, s] += unary[a] if a >= 0 else occlusion_cost
            for z in range(n):
                q = parts[z]
                if z == x:
                    continue
                if q < 0:
                    alone[p, s] += pairwise_cost(costs, a, chosen[0, z])
                elif q == p:
                    alone[p, s] += 0.5 * pairwise_cost(costs, a, chosen[s, z])
                else:
                    for t in range(2):
                        together[p, s, q, t] += pairwise_cost(costs, a, chosen[t, z])
    return alone, together


@kernel
def _choose(alone: FloatArray, together: FloatArray, side: IntArray, scale: float) -> IntArray:
    count = len(alone)
    if count > _ENUMERATED:
        return _descend(alone, together, side, scale)
    best, best_energy = side.copy(), np.inf
    # Gray code: one part changes from each choice to the next.
    side[:] = 0
    energy = 0.0
    for p in range(count):
        energy += alone[p, 0]
        for q in range(p):
            energy += together[p, 0, q, 0]
    for code in range(2**count):
        if code:
            flip = 0
            while not (code >> flip) & 1:
                flip += 1
            energy += _change(alone, together, side, flip)
            side[flip] = 1 - side[flip]
        if energy < best_energy:
            best_energy = energy
            best[:] = side
    return best


@kernel
def _change(alone: FloatArray, together: FloatArray, side: IntArray, p: int) -> float:
    """Change of the energy when part p is taken from the other correspondence."""
    old, new = side[p], 1 - side[p]
    change: float = alone[p, new] - alone[p, old]
    for q in range(len(side)):
        if q != p:
            change += together[p, new, q, side[q]] - together[p, old, q, side[q]]
    return change


@kernel
def _descend(alone: FloatArray, together: FloatArray, side: IntArray, scale: float) -> IntArray:
    improved = True
    while improved:
        improved = False
        for p in range(len(side)):
            if _change(alone, together, side, p) < -allowance(alone[p, side[p]], scale):
                side[p] = 1 - side[p]
                improved = True
    return side
