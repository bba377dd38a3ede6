"""Certification stage: lower bounds of the chosen hypothesis' problems (section 4)."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from solver.arrays import IntArray
from solver.control import Control
from solver.labelling import LINF, LabellingProblem, Method, Solution
from solver.matching.hypothesis import Hypothesis, SolvedLevel
from solver.matching.level import Level
from solver.matching.options import SAMPLES, MatchOptions
from solver.optimisation import minimise
from solver.optimisation.regions import can_prove, prove

_DUAL_WORK = 2e8
"""Squared candidates and costs of triples, times iterations of a level's dual decomposition: some
0.7 s on one core."""

_DUAL_ITERATIONS = 50, 1000
"""Least and greatest number of iterations, whatever the work."""

_STAGE = "bounds"


def certify(hypothesis: Hypothesis, levels: Sequence[Level], control: Control) -> Hypothesis:
    """Bound and improve a hypothesis at every level that no search has bounded (section 4).

    Parameters
    ----------
    hypothesis
        The chosen hypothesis, solved at all levels.
    levels
        Of the match.
    control
        Reports progress and cancels. Past its deadline, the bounds known by then are kept.

    Raises
    ------
    Cancelled
        Through `control`.
    """
    certified = []
    with control.stage(_STAGE):
        for level, solved in zip(levels, hypothesis.levels, strict=True):
            if solved.solution.method is Method.LOCAL_SEARCH and not control.expired:
                name = f"bounds for {solved.problem.n_sources} points"
                control.report(name, level.index / len(levels))
                solved = _bound(solved, control)
            certified.append(solved)
    return Hypothesis(tuple(certified))


def _bound(solved: SolvedLevel, control: Control) -> SolvedLevel:
    with (clock := control.timed()).stage(_STAGE):
        solution = _minimise(solved.problem, solved.solution, clock)
    return replace(solved, solution=solution, seconds=solved.seconds + clock.timings[_STAGE])


def _minimise(
    problem: LabellingProblem, known: Solution[IntArray], control: Control
) -> Solution[IntArray]:
    """Prove a solution optimal or improve it, within the work that a level may take."""
    each = max(problem.n_candidates**2 + len(problem.triples.costs), 1)
    iterations = int(np.clip(_DUAL_WORK / each, *_DUAL_ITERATIONS))
    return minimise(problem, known.answer, iterations=iterations, control=control)


def prove_over_samples(
    hypotheses: Sequence[Hypothesis], level: Level, options: MatchOptions, control: Control
) -> SolvedLevel | None:
    """Find the correspondence of least energy over all target samples of a level, with a proof.

    Parameters
    ----------
    hypotheses
        The answer and the others, solved at this level.
    level
        The finest level.
    options
        Of the match.
    control
        Reports progress and cancels. Past its deadline, the bound known by then is returned.

    Returns
    -------
    The level's problem on all allowed pairs, and its solution; ``None`` if it is not asked for, or
    the level has too many samples.

    Notes
    -----
    Regions have no third-order costs. A level that has the term is one of the coarsest points, few
    enough for :func:`.minimise`; finer levels have none.

    Raises
    ------
    Cancelled
        Through `control`.
    """
    if options.proof != SAMPLES or options.objective == LINF:
        return None
    with (clock := control.timed()).stage("proof"), control.stage("proof", 0.0):
        problem = level.problem(level.all_candidates())
        starts = [one.partners for one in hypotheses]
        if level.third_order is not None:
            best = min(starts, key=problem.energy, default=None)
            limit = options.proof_work
            # A dual decomposition would hardly raise the bound of these few points.
            found = minimise(problem, best, iterations=0, search_seconds=limit, control=control)
        elif can_prove(problem):
            found = prove(problem, starts, seconds=options.proof_work, control=control)
        else:
            return None
    return SolvedLevel(problem, found, clock.timings["proof"])


def replaces(proof: SolvedLevel, answer: Hypothesis, level: Level, options: MatchOptions) -> bool:
    """Return whether a solution over all samples takes the place of an answer.

    It is to be better, or proven optimal; and its energy must decide. It does not where the
    surfaces are registered, nor where coarser levels have a third-order term that this one lacks.

    Parameters
    ----------
    proof
        Of :func:`prove_over_samples`.
    answer
        The answer.
    level
        The finest level.
    options
        Of the match.
    """
    third_order_elsewhere = options.third_order > 0.0 and level.third_order is None
    if options.registered or third_order_elsewhere:
        return False
    return proof.solution.certified or proof.solution.value < answer.energy
