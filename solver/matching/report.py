"""Report of a match: hypotheses and levels in the user's vertex numbers."""

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.control import Control
from solver.labelling import UNMATCHED, Method, greatest_distortions
from solver.matching.hypothesis import Hypothesis, SolvedLevel, drop_duplicates
from solver.matching.level import Level
from solver.matching.options import CANDIDATES, SAMPLES
from solver.matching.result import Correspondence, LevelReport, Match, SampleProof

_NOTHING_MATCHED = "no point is matched: raise `occlusion_cost`, which is less than any pair costs"
_CUT_SHORT = (
    "the time limit was reached before all was done: answer and bound may be better with a longer"
    " `time_limit`"
)


def report_match(
    hypotheses: Sequence[Hypothesis],
    levels: Sequence[Level],
    vertex_ids: tuple[IntArray, IntArray],
    warnings: Iterable[str],
    control: Control,
    proof: SolvedLevel | None = None,
) -> Match:
    """Report the answer and its alternatives.

    Parameters
    ----------
    hypotheses
        The answer and the others; duplicates are left out.
    levels
        Of the answer.
    vertex_ids
        The user's own numbers of all source and of all target vertices.
    warnings
        For the user.
    control
        Holds the timings.
    proof
        The finest level solved over all target samples, if it is.
    """
    finest = levels[-1]
    source = vertex_ids[0][finest.source.vertices]
    target = vertex_ids[1][finest.target.vertices]
    answer, *others = drop_duplicates(hypotheses)
    best, *alternatives = (
        _correspondence(one, finest, source, target) for one in (answer, *others)
    )
    reports = tuple(
        _report_level(level, solved, [one.levels[index] for one in others], finest)
        for index, (level, solved) in enumerate(zip(levels, answer.levels, strict=True))
    )
    nothing = () if len(best.source) else (_NOTHING_MATCHED,)
    warned = (*warnings, *nothing)
    found = Match(best, tuple(alternatives), reports, warned, control.timings)
    if proof is None:
        return found
    optimum = _correspondence(Hypothesis((proof,)), finest, source, target)
    solution = proof.solution
    proven = SampleProof(
        target_points=proof.problem.n_targets,
        candidates=proof.problem.n_candidates,
        optimum=optimum,
        lower_bound=solution.lower_bound,
        regions=solution.iterations,
        seconds=proof.seconds,
    )
    return replace(found, proof=proven)


def cut_short(control: Control) -> tuple[str, ...]:
    """Warn of a deadline that has passed before the answer was done."""
    return (_CUT_SHORT,) if control.expired else ()


def _correspondence(
    hypothesis: Hypothesis, finest: Level, source: IntArray, target: IntArray
) -> Correspondence:
    partners = hypothesis.partners
    matched = partners != UNMATCHED
    return Correspondence(
        source=source[matched],
        target=target[partners[matched]],
        costs=_costs(hypothesis, finest)[matched],
        unmatched=source[~matched],
        energy=hypothesis.energy,
        distortion=finest.distortion(partners),
    )


def _costs(hypothesis: Hypothesis, finest: Level) -> FloatArray:
    """(N,) share of each source point in the energy, or its greatest distortion (section 2)."""
    partners, solved = hypothesis.partners, hypothesis.levels[-1]
    if solved.solution.method is Method.MINIMAX:
        target = finest.target.distances[np.ix_(partners, partners)]
        return greatest_distortions(finest.source.distances, target)
    return solved.problem.costs(partners)


def _report_level(
    level: Level, solved: SolvedLevel, others: Sequence[SolvedLevel], finest: Level
) -> LevelReport:
    """Report a level; the coarsest of several with its optimum, whichever hypothesis was chosen."""
    problem, solution = solved.problem, solved.solution
    coarse = level.index == 0 and level is not finest
    landmarks = level.landmarks
    allowed = (problem.n_sources - landmarks) * (problem.n_targets - landmarks) + landmarks
    return LevelReport(
        points=problem.n_sources,
        target_points=problem.n_targets,
        candidates=problem.n_candidates,
        metric=level.metric.name,
        descriptor=level.descriptor.name,
        energy=solved.least_energy if coarse else solution.value,
        lower_bound=solution.lower_bound,
        iterations=solution.iterations,
        method=solution.method,
        seconds=solved.seconds,
        rank=1 + sum(other.solution.value < solution.value for other in others),
        scope=SAMPLES if problem.n_candidates == allowed else CANDIDATES,
    )
