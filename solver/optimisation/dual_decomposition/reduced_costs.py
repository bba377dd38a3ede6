"""Reparametrised costs of a relaxation, for lower bounds of a search."""

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.labelling import UNMATCHED, LabellingProblem
from solver.optimisation.primal import assignment_costs
from solver.optimisation.reparametrisation import ReparametrisedCosts

SUM_ROUNDING = 1e-9
"""Allowance for rounding errors of a relaxation's bound, relative to it: it is a sum over many
subproblems and iterations, and sums of 10⁶ terms err by 1e-10."""


def reduced_costs(
    problem: LabellingProblem,
    linear: FloatArray,
    partners: IntArray,
    pairwise: FloatArray,
    constant: float,
) -> ReparametrisedCosts:
    """Split the energy into the relaxation's bound and non-negative costs above it.

    Parameters
    ----------
    problem
        The labelling problem.
    linear, partners
        (V,) costs of the linear subproblem and (N,) its optimal assignment.
    pairwise
        (V, V) cost of every two candidates above the minima of the other subproblems.
    constant
        The sum of those minima.

    Returns
    -------
    ReparametrisedCosts
        Its constant is the relaxation's bound, less 1e-9 of it for rounding errors.
    """
    costs = assignment_costs(problem, linear)
    rows, columns = _potentials(costs, partners, problem.n_targets)
    x, y = problem.candidates.T
    unary = np.maximum(linear - rows[x] - columns[y], 0.0)
    if problem.must_match_all:
        occlusion = np.full(problem.n_sources, np.inf)
    else:
        own = problem.n_targets + np.arange(problem.n_sources)
        occlusion = np.maximum(problem.occlusion_cost - rows - columns[own], 0.0)
    exclusive = (x[:, None] == x[None, :]) | (y[:, None] == y[None, :])
    pairwise = np.where(exclusive, np.inf, pairwise)
    np.fill_diagonal(pairwise, 0.0)
    constant += float(rows.sum() + columns.sum())
    constant -= SUM_ROUNDING * abs(constant)
    return ReparametrisedCosts(constant, unary, pairwise, occlusion, problem.scale)


def _potentials(
    costs: FloatArray, partners: IntArray, n_targets: int
) -> tuple[FloatArray, FloatArray]:
    """Dual solution of an assignment problem, from its optimum: u_x + v_y <= c_xy, v <= 0.

    The greatest v: shortest paths in the residual graph, none of whose cycles is negative.
    """
    n = len(costs)
    columns = np.where(partners == UNMATCHED, n_targets + np.arange(n), partners)
    own = costs[np.arange(n), columns]
    v = np.zeros(costs.shape[1])
    for _ in range(n):
        lower = (costs + (v[columns] - own)[:, None]).min(axis=0)
        if (lower >= v).all():
            break
        v = np.minimum(v, lower)
    return own - v[columns], v
