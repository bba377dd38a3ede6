"""Linear subproblem: the assignment problem without pairwise costs."""

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.labelling import UNMATCHED, LabellingProblem
from solver.optimisation.primal import solve_lap


class LinearSubproblem:
    """Linear assignment problem, solved exactly.

    It has all unary costs at first; the other subproblems take shares of them. It alone contains
    the constraints of target points and the occlusion cost.

    Parameters
    ----------
    problem
        The labelling problem.

    Attributes
    ----------
    unary
        (V,) its costs.
    partners
        (N,) its minimiser, `UNMATCHED` for none.
    used
        Candidates that the minimiser uses.
    """

    def __init__(self, problem: LabellingProblem) -> None:
        self._problem = problem
        self.unary: FloatArray = problem.unary.astype(np.float64, copy=True)
        self.partners: IntArray = np.full(problem.n_sources, UNMATCHED, dtype=np.int64)
        self.used: IntArray = np.empty(0, dtype=np.int64)

    def minimise(self) -> float:
        """Solve it; return the minimum, occlusion costs included."""
        problem = self._problem
        self.partners = solve_lap(problem, self.unary)
        chosen = problem.chosen_candidates(self.partners)
        self.used = chosen[chosen >= 0]
        unmatched = problem.n_sources - len(self.used)
        minimum = float(self.unary[self.used].sum())
        return minimum + unmatched * problem.occlusion_cost if unmatched else minimum
