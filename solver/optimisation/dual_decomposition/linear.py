"""The linear subproblem: candidates without pairwise costs, each point at most once."""

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.labelling import UNMATCHED, LabellingProblem
from solver.optimisation.primal import assign


class LinearSubproblem:
    """An assignment problem, solved exactly.

    It has all unary costs at first, and what the other subproblems leave of them later. It alone
    knows that a target point serves at most one source point, and what an unmatched one costs.

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
        self.partners = assign(problem, self.unary)
        chosen = problem.chosen_candidates(self.partners)
        self.used = chosen[chosen >= 0]
        unmatched = problem.n_sources - len(self.used)
        minimum = float(self.unary[self.used].sum())
        return minimum + unmatched * problem.occlusion_cost if unmatched else minimum
