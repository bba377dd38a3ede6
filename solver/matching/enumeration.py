"""Enumeration stage: the best solutions of the coarsest level, found exactly (4.1)."""

from collections.abc import Iterable
from dataclasses import replace

from solver.arrays import IntArray
from solver.control import Control
from solver.labelling import LINF, UNMATCHED, LabellingProblem, Method, Solution
from solver.matching.hypothesis import Hypothesis, SolvedLevel
from solver.matching.level import Level
from solver.matching.options import MatchOptions
from solver.optimisation.exact import m_best_solutions, minimax_correspondence, within_distortion
from solver.optimisation.primal import local_search, solve_lap

_FURTHER_NODES = 200_000
"""Search nodes of further solutions, which need not be proven the best: a fraction of a second.
Featureless shapes such as spheres have very many that are nearly as good."""

_OPTIMA_LEFT = (
    "the optimum of least energy among those of the minimax distortion could not be proven in time"
)
_UNPROVEN = "the coarse level's optimum could not be proven in time"


def enumerate_hypotheses(
    level: Level, options: MatchOptions, control: Control
) -> tuple[list[Hypothesis], tuple[str, ...]]:
    """Enumerate the best solutions of the coarsest level: the hypotheses of 4.1.

    Parameters
    ----------
    level
        The coarsest level.
    options
        Of the match.
    control
        Cancels; past its deadline, the best solutions found so far are returned.

    Returns
    -------
    At least one hypothesis, of one level, by their energy or greatest distortion; and warnings.

    Raises
    ------
    Cancelled
        Through `control`.
    """
    with control.stage("coarse matching", 0.0):
        problem = level.problem(level.all_candidates())
        if options.objective == LINF:
            solutions, warnings = _enumerate_minimax(problem, level, options, control)
        else:
            solutions, warnings = _enumerate_by_energy(problem, options.alternatives, control)
    seconds = control.timings["coarse matching"]
    hypotheses = [Hypothesis((SolvedLevel(problem, solution, seconds),)) for solution in solutions]
    return hypotheses, warnings


def _enumerate_by_energy(
    problem: LabellingProblem, count: int, control: Control
) -> tuple[Iterable[Solution[IntArray]], tuple[str, ...]]:
    """Correspondences of least energy (5), by branch and bound, or one local optimum."""
    found = m_best_solutions(problem, count, control=control)
    if not len(found):
        partners = local_search(problem, solve_lap(problem, problem.unary))
        energy = problem.energy(partners)
        bound = min(found.lower_bound, energy)
        local = Solution(partners, energy, bound, 0, Method.LOCAL_SEARCH, found.status)
        return [local], () if local.certified else (_UNPROVEN,)
    # The best one may be proven though the others are not.
    return found, () if found[0].certified else (_UNPROVEN,)


def _enumerate_minimax(
    problem: LabellingProblem, level: Level, options: MatchOptions, control: Control
) -> tuple[Iterable[Solution[IntArray]], tuple[str, ...]]:
    """Correspondences of least dis∞ (section 2); those of equal dis∞ by their energy (5)."""
    source, target = level.source.distances, level.target.distances
    seconds = options.proof_work
    least = minimax_correspondence(source, target, seconds=seconds, control=control)
    found = m_best_solutions(
        within_distortion(problem, source, target, least.value),
        options.alternatives,
        known=least.answer[:, 1],
        node_limit=_FURTHER_NODES,
        control=control,
    )
    distortions = [level.distortion(partners).linf for partners in found.partners]
    solutions = [
        replace(least, answer=partners, value=distortion)
        for partners, distortion in zip(found.partners, distortions, strict=True)
        if distortion <= least.value
    ]
    # Those of less energy may still distort less than the best one known, if that is not proven.
    solutions.sort(key=lambda one: one.value)
    if not least.certified:
        return solutions, ("the minimax distortion could not be proven in time",)
    return solutions, () if found.proven else (_OPTIMA_LEFT,)


def further_solutions(
    coarse: Level, measured: Level, count: int, control: Control
) -> list[tuple[IntArray, IntArray]]:
    """Best correspondences of the coarsest level's samples in the structures of another level.

    Parameters
    ----------
    coarse
        The coarsest level.
    measured
        A level whose samples begin with those.
    count
        Greatest number of correspondences.
    control
        Cancels; past its deadline, the best ones found so far are returned.

    Returns
    -------
    Source and target vertices that correspond, of each.

    Raises
    ------
    Cancelled
        Through `control`.
    """
    level = replace(
        measured,
        source=measured.source.first(len(coarse.source.vertices)),
        target=measured.target.first(len(coarse.target.vertices)),
    )
    problem = level.problem(level.all_candidates())
    found = m_best_solutions(problem, count, node_limit=_FURTHER_NODES, control=control)
    vertices = level.source.vertices, level.target.vertices
    matched = [partners != UNMATCHED for partners in found.partners]
    return [
        (vertices[0][kept], vertices[1][partners[kept]])
        for partners, kept in zip(found.partners, matched, strict=True)
    ]
