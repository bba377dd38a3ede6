"""Hypotheses of a match, carried from the coarsest level to the finest: section 4.1.

What is matched with a target, another shape or a prototype, only makes the levels.
"""

import time
from dataclasses import dataclass, field, replace

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.control import Control
from solver.labelling import (
    LINF,
    UNMATCHED,
    LabellingProblem,
    Method,
    Solution,
    greatest_distortions,
)
from solver.matching.hierarchy import refine, rematch
from solver.matching.level import Level
from solver.matching.options import MatchOptions
from solver.matching.result import Correspondence, LevelReport
from solver.optimisation import minimise
from solver.optimisation.exact import m_best_solutions
from solver.optimisation.primal import local_search, solve_lap

_COARSE_NODES = 50_000_000
_DUAL_WORK = 2e8
"""Squared candidates times iterations that a level's bound may take: some 0.7 s."""
_DUAL_ITERATIONS = 50, 1000


@dataclass(frozen=True, eq=False)
class Stage:
    """A hypothesis at one level, and its place among all there."""

    problem: LabellingProblem
    solution: Solution[IntArray]
    rank: int
    seconds: float


@dataclass(frozen=True, eq=False)
class Hypothesis:
    """A coarse solution, carried through the levels so far."""

    stages: tuple[Stage, ...]

    @property
    def partners(self) -> IntArray:
        """(N,) target sample of each source sample at the finest level so far."""
        return self.stages[-1].solution.answer

    @property
    def energy(self) -> float:
        """Energy at the finest level so far."""
        return self.stages[-1].solution.value


@dataclass
class HierarchicalRun:
    """One match under way: its hypotheses from level to level.

    Parameters
    ----------
    options
        Of the match, settled.
    control
        Progress, cancellation and the deadline.
    timings, warnings
        What is gathered for the answer.
    started
        When the match began.
    """

    options: MatchOptions
    control: Control
    timings: dict[str, float] = field(default_factory=dict)
    warnings: list[str] = field(default_factory=list)
    started: float = field(default_factory=time.perf_counter)

    def ranked(self, levels: list[Level]) -> list[Hypothesis]:
        """Enumerate coarse solutions, refine each, and put them in the order of their energy."""
        hypotheses = self.coarse(levels[0])
        for level in levels[1:]:
            hypotheses = self.finer(hypotheses, level)
        return hypotheses

    def carried(
        self, levels: list[Level], near: FloatArray, others: list[Hypothesis]
    ) -> Hypothesis:
        """Begin a further hypothesis where something else has put the coarse samples.

        Parameters
        ----------
        levels
            Of the match.
        near
            (N, M) how far each coarse target sample is from where each coarse source sample was
            put.
        others
            The hypotheses so far, among which the new one is ranked.
        """
        started = time.perf_counter()
        problem = levels[0].problem(levels[0].all_candidates())
        partners = solve_lap(problem, near[problem.candidates[:, 0], problem.candidates[:, 1]])
        known = others[0].stages[0].solution
        energy = problem.energy(partners)
        solution = Solution(partners, energy, known.lower_bound, known.iterations, known.method)
        seconds = time.perf_counter() - started
        found = Hypothesis((Stage(problem, solution, _rank(energy, others, 0), seconds),))
        for level in levels[1:]:
            (found,) = self.finer([found], level)
            last = replace(found.stages[-1], rank=_rank(found.energy, others, level.index))
            found = Hypothesis((*found.stages[:-1], last))
        return found

    def coarse(self, level: Level) -> list[Hypothesis]:
        """Enumerate the best solutions of the coarsest level."""
        self.control.report("coarse matching", 0.4)
        started = time.perf_counter()
        problem = level.problem(level.all_candidates())
        found = m_best_solutions(
            problem, self.options.alternatives, node_limit=_COARSE_NODES, control=self.control
        )
        seconds = time.perf_counter() - started
        self.timings["coarse matching"] = seconds
        if not found.proven:
            self.warnings.append("the coarse level's optimum could not be proven in time")
        if not len(found.partners):
            partners = local_search(problem, solve_lap(problem, problem.unary))
            solution = Solution(partners, problem.energy(partners), 0.0, 0, Method.LOCAL_SEARCH)
            return [Hypothesis((Stage(problem, solution, 1, seconds),))]
        bound = float(found.energies[0]) if found.proven else 0.0
        hypotheses = []
        for rank, (partners, energy) in enumerate(
            zip(found.partners, found.energies, strict=True), start=1
        ):
            solution = Solution(
                partners, float(energy), bound, found.nodes, Method.BRANCH_AND_BOUND
            )
            hypotheses.append(Hypothesis((Stage(problem, solution, rank, seconds),)))
        return hypotheses

    def finer(self, hypotheses: list[Hypothesis], level: Level) -> list[Hypothesis]:
        """Refine every hypothesis to the next level, and rank them there."""
        self.control.report("refinement", 0.45 + 0.05 * level.index)
        started = time.perf_counter()
        refined = []
        again = len(level.source.vertices) == len(hypotheses[0].partners)
        closer = rematch if again else refine
        for hypothesis in hypotheses:
            self.control.check()
            before = time.perf_counter()
            found = closer(hypothesis.partners, level, self.options.rho)
            refined.append((found, hypothesis, time.perf_counter() - before))
        refined.sort(key=lambda entry: entry[0].energy)
        self.spend("refinement", started)
        return [
            Hypothesis(
                (
                    *hypothesis.stages,
                    Stage(
                        found.problem,
                        Solution(found.partners, found.energy, 0.0, 0, Method.LOCAL_SEARCH),
                        rank,
                        seconds,
                    ),
                )
            )
            for rank, (found, hypothesis, seconds) in enumerate(refined, start=1)
        ]

    def bounded(self, winner: Hypothesis, levels: list[Level]) -> Hypothesis:
        """Bound the winner's problem at every level where no search has done so."""
        started = time.perf_counter()
        stages = []
        for level, stage in zip(levels, winner.stages, strict=True):
            if stage.solution.method is not Method.LOCAL_SEARCH:
                stages.append(stage)
                continue
            self.control.report(
                f"bounds for {stage.problem.n_sources} points",
                0.6 + 0.4 * level.index / len(levels),
            )
            before = time.perf_counter()
            solution = _solve(stage.problem, stage.solution, self.control)
            seconds = stage.seconds + time.perf_counter() - before
            stages.append(Stage(stage.problem, solution, stage.rank, seconds))
        self.spend("bounds", started)
        return Hypothesis(tuple(stages))

    def correspondence(
        self, hypothesis: Hypothesis, finest: Level, source: IntArray, target: IntArray
    ) -> Correspondence:
        """Put a hypothesis as the user sees it.

        Parameters
        ----------
        hypothesis
            Carried to the finest level.
        finest
            That level.
        source, target
            (N,) and (M,) the user's own numbers of the level's samples.
        """
        partners = hypothesis.partners
        matched = partners != UNMATCHED
        return Correspondence(
            source=source[matched],
            target=target[partners[matched]],
            costs=self._costs(hypothesis, finest)[matched],
            unmatched=source[~matched],
            energy=hypothesis.energy,
            distortion=finest.distortion(partners),
        )

    def _costs(self, hypothesis: Hypothesis, level: Level) -> FloatArray:
        partners = hypothesis.partners
        if self.options.objective == LINF:
            target = level.target.distances[np.ix_(partners, partners)]
            return greatest_distortions(level.source.distances, target)
        return hypothesis.stages[-1].problem.costs(partners)

    def spend(self, stage: str, started: float) -> None:
        """Add the time since then to a stage's."""
        self.timings[stage] = self.timings.get(stage, 0.0) + time.perf_counter() - started


def _rank(energy: float, others: list[Hypothesis], level: int) -> int:
    """Place of an energy among those of hypotheses at a level, from 1."""
    return 1 + sum(other.stages[level].solution.value < energy for other in others)


def distinct(hypotheses: list[Hypothesis]) -> list[Hypothesis]:
    """Leave out hypotheses that have become equal to an earlier one."""
    seen: set[bytes] = set()
    kept = []
    for hypothesis in hypotheses:
        if hypothesis.partners.tobytes() not in seen:
            seen.add(hypothesis.partners.tobytes())
            kept.append(hypothesis)
    return kept


def level_reports(hypothesis: Hypothesis, levels: list[Level]) -> tuple[LevelReport, ...]:
    """Report every level of a hypothesis."""
    return tuple(
        _report(level, stage, levels[-1])
        for level, stage in zip(levels, hypothesis.stages, strict=True)
    )


def _solve(
    problem: LabellingProblem, known: Solution[IntArray], control: Control
) -> Solution[IntArray]:
    """Prove `known` optimal or improve it, as far as the work a level may take allows."""
    iterations = int(np.clip(_DUAL_WORK / max(problem.n_candidates, 1) ** 2, *_DUAL_ITERATIONS))
    return minimise(problem, known.answer, iterations=iterations, control=control)


def _report(level: Level, stage: Stage, finest: Level) -> LevelReport:
    """Report a level; of several, the coarsest one's energy is its optimum's, whatever won."""
    problem, solution = stage.problem, stage.solution
    coarse = level.index == 0 and level is not finest
    enumerated = coarse and solution.method is Method.BRANCH_AND_BOUND
    proven_coarse = enumerated and solution.lower_bound > 0.0
    return LevelReport(
        points=problem.n_sources,
        target_points=problem.n_targets,
        candidates=problem.n_candidates,
        metric=level.metric.name,
        descriptor=level.descriptor.name,
        energy=solution.lower_bound if proven_coarse else solution.value,
        lower_bound=solution.lower_bound,
        iterations=solution.iterations,
        method=solution.method,
        seconds=stage.seconds,
        rank=stage.rank,
    )
