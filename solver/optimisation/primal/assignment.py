"""Linear assignment over the candidates of a labelling problem."""

import numpy as np
from scipy.optimize import linear_sum_assignment

from solver.arrays import FloatArray, IntArray
from solver.labelling import UNMATCHED, LabellingProblem


class InfeasibleError(ValueError):
    """Every source point must be matched, and the candidates do not allow it."""


def solve_lap(problem: LabellingProblem, costs: FloatArray) -> IntArray:
    """Solve the linear assignment problem with a cost on each candidate, in O(N² (N + M)).

    Parameters
    ----------
    problem
        Its candidates and occlusion cost; its own costs are not used.
    costs
        (V,) finite cost of each candidate; may be negative.

    Returns
    -------
    (N,) int64 target point of each source point, `UNMATCHED` for none.

    Raises
    ------
    InfeasibleError
        Every source point must be matched, and the candidates do not allow it.
    """
    n, m = problem.shape
    matrix = assignment_costs(problem, costs)
    try:
        rows, columns = linear_sum_assignment(matrix)
    except ValueError as error:
        raise InfeasibleError("the candidates admit no complete correspondence") from error
    if len(rows) < n:
        raise InfeasibleError("there are fewer target points than source points")
    return np.where(columns < m, columns, UNMATCHED).astype(np.int64)


def maximum_matching(problem: LabellingProblem, costs: FloatArray) -> IntArray:
    """Match as many source points as the candidates allow, at the least total cost.

    Parameters
    ----------
    problem
        Its candidates; its own costs are not used.
    costs
        (V,) finite cost ≥ 0 of each candidate, in any unit: γ is not compared with it.

    Returns
    -------
    (N,) int64 target point of each source point, `UNMATCHED` for none.

    Raises
    ------
    InfeasibleError
        Every source point must be matched, and the candidates do not allow it.
    """
    if not problem.must_match_all:
        # A further match saves more than all others may cost.
        costs = costs - ((1.0 + problem.n_sources) * costs.max(initial=0.0) or 1.0)
    return solve_lap(problem, costs)


def assignment_costs(problem: LabellingProblem, costs: FloatArray) -> FloatArray:
    """Matrix of the assignment problem with a cost on each candidate.

    Parameters
    ----------
    problem
        Its candidates and occlusion cost; its own costs are not used.
    costs
        (V,) cost of each candidate.

    Returns
    -------
    (N, M) float64, ``inf`` for pairs that are no candidates; where source points may stay
    unmatched, (N, M + N): each has a column of its own for that.
    """
    n, m = problem.shape
    width = m if problem.must_match_all else m + n
    matrix = np.full((n, width), np.inf)
    matrix[problem.candidates[:, 0], problem.candidates[:, 1]] = costs
    if not problem.must_match_all:
        own_column = np.arange(n)
        matrix[own_column, m + own_column] = problem.occlusion_cost
    return matrix
