"""Answers of the dual decomposition alone."""

from solver.arrays import IntArray
from solver.control import Control, iterate
from solver.labelling import CERTIFIED_GAP, LabellingProblem, Solution
from solver.optimisation.dual_decomposition import DualDecomposition, Subproblems


def decomposed(
    problem: LabellingProblem,
    subproblems: Subproblems | None = None,
    *,
    iterations: int = 1000,
    gap: float = CERTIFIED_GAP,
    control: Control | None = None,
) -> Solution[IntArray]:
    method = DualDecomposition(problem, subproblems=subproblems, gap=gap)
    ended = iterate(method, iterations, control or Control())
    return ended.state.solution(ended.status)
