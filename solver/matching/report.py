"""Report of a match: hypotheses and levels in the user's vertex numbers."""

from collections.abc import Sequence

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.labelling import UNMATCHED, Method, greatest_distortions
from solver.matching.hypothesis import Hypothesis, SolvedLevel
from solver.matching.level import Level
from solver.matching.result import Correspondence, LevelReport


def report_correspondences(
    hypotheses: Sequence[Hypothesis], finest: Level, source: IntArray, target: IntArray
) -> list[Correspondence]:
    """Report hypotheses at the finest level.

    Parameters
    ----------
    hypotheses
        Refined to the finest level.
    finest
        That level.
    source, target
        (N,) and (M,) the user's own numbers of the level's samples.
    """
    return [_correspondence(one, finest, source, target) for one in hypotheses]


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


def report_levels(hypothesis: Hypothesis, levels: Sequence[Level]) -> tuple[LevelReport, ...]:
    """Report every level of a hypothesis."""
    return tuple(
        _report_level(level, solved, levels[-1])
        for level, solved in zip(levels, hypothesis.levels, strict=True)
    )


def _report_level(level: Level, solved: SolvedLevel, finest: Level) -> LevelReport:
    """Report a level; the coarsest of several with its optimum, whichever hypothesis was chosen."""
    problem, solution = solved.problem, solved.solution
    coarse = level.index == 0 and level is not finest
    enumerated = coarse and solution.method is Method.BRANCH_AND_BOUND
    optimum_known = enumerated and solution.lower_bound > 0.0
    return LevelReport(
        points=problem.n_sources,
        target_points=problem.n_targets,
        candidates=problem.n_candidates,
        metric=level.metric.name,
        descriptor=level.descriptor.name,
        energy=solution.lower_bound if optimum_known else solution.energy,
        lower_bound=solution.lower_bound,
        iterations=solution.iterations,
        method=solution.method,
        seconds=solved.seconds,
        rank=solved.rank,
    )
