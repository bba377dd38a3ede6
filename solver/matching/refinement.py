"""Refinement stage: every hypothesis is refined to the finest level (4.1)."""

from collections.abc import Sequence
from dataclasses import replace

from solver.arrays import FloatArray
from solver.control import Control
from solver.labelling import UNMATCHED, Method, Solution
from solver.matching.hierarchy import RefinedCorrespondence, refine, rematch
from solver.matching.hypothesis import Hypothesis, SolvedLevel, drop_duplicates
from solver.matching.level import Level
from solver.optimisation.primal import local_search, maximum_matching

_STAGE = "refinement"


def refine_hypotheses(
    hypotheses: Sequence[Hypothesis], levels: Sequence[Level], rho: float, control: Control
) -> list[Hypothesis]:
    """Refine the hypotheses from level to level, and order them at each (4.1).

    Parameters
    ----------
    hypotheses
        Solved at the level before the first of these.
    levels
        The finer levels, the coarsest of them first.
    rho
        ρ of 4.1.
    control
        Reports progress and cancels; past its deadline, only the first one of each level is
        refined further.

    Returns
    -------
    The hypotheses, without those that became equal, by their energy at the last level; but a level
    without a third-order term keeps the order of those that have one, as it cannot tell an answer
    from its mirror image.

    Raises
    ------
    Cancelled
        Through `control`.
    """
    ordered = list(hypotheses)
    for place, level in enumerate(levels):
        with control.stage(_STAGE, place / len(levels)):
            refined = [
                _refined(one, level, rho, control) for one in control.in_time(ordered, least=1)
            ]
        keeps_order = level.third_order is None and _with_third_order(ordered)
        if not keeps_order:
            refined.sort(key=lambda one: one.energy)
        ordered = drop_duplicates(refined)
    return ordered


def _with_third_order(hypotheses: Sequence[Hypothesis]) -> bool:
    """Return whether a level so far has a third-order term."""
    return any(len(solved.problem.triples.points) for solved in hypotheses[0].levels)


def _refined(hypothesis: Hypothesis, level: Level, rho: float, control: Control) -> Hypothesis:
    """Refine a hypothesis to the next level."""
    same_points = len(level.source.vertices) == len(hypothesis.partners)
    with (clock := control.timed()).stage(_STAGE):
        found = (rematch if same_points else refine)(hypothesis.partners, level, rho)
    return Hypothesis((*hypothesis.levels, solved_level(found, clock.timings[_STAGE])))


def solved_level(found: RefinedCorrespondence, seconds: float) -> SolvedLevel:
    """Return a refined correspondence as the level of a hypothesis, without a bound yet."""
    solution = Solution(found.partners, found.energy, 0.0, 0, Method.LOCAL_SEARCH)
    return SolvedLevel(found.problem, solution, seconds)


def hypothesis_from_map(
    levels: Sequence[Level],
    distances: FloatArray,
    others: Sequence[Hypothesis],
    rho: float,
    control: Control,
) -> Hypothesis:
    """Start a further hypothesis from a map of the coarse samples, and refine it (4.1).

    Parameters
    ----------
    levels
        Of the match.
    distances
        (N, M) distances from the image of each coarse source sample to each coarse target sample.
    others
        The hypotheses so far. The bound of their coarsest problem is that of the new one's, which
        is the same problem.
    rho
        ρ of 4.1.
    control
        Reports progress and cancels.

    Raises
    ------
    Cancelled
        Through `control`.
    """
    with (clock := control.timed()).stage("coarse matching"):
        problem = levels[0].problem(levels[0].all_candidates())
        x, y = problem.candidates.T
        partners = maximum_matching(problem, distances[x, y])
        # Matched points keep their partners, or lose them where γ is less than their costs.
        matched = partners != UNMATCHED
        kept = problem.among(problem.chosen_candidates(partners)[matched])
        partners = local_search(kept, partners)
        energy = problem.energy(partners)
    known = others[0].levels[0].solution
    solution = replace(known, answer=partners, value=energy)
    coarse = SolvedLevel(problem, solution, clock.timings["coarse matching"])
    (found,) = refine_hypotheses([Hypothesis((coarse,))], levels[1:], rho, control.quiet())
    return found
