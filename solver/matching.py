"""The front door: match two shapes."""

import time
from dataclasses import dataclass, field, replace

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.branch_and_bound import m_best_solutions
from solver.control import Control
from solver.distortion import greatest_distortions
from solver.errors import OptionError
from solver.gromov_hausdorff import minimax_correspondence, within_distortion
from solver.hierarchy import refine
from solver.labelling import UNMATCHED, LabellingProblem
from solver.level import Level, build_level, level_sizes
from solver.match import Correspondence, LevelReport, Match
from solver.minimise import minimise
from solver.options import GMDS, LINF, MatchOptions
from solver.primal import assign, local_search
from solver.refinement import Refinement, refine_by_gmds
from solver.shape import Shape
from solver.solution import Method, Solution

_COARSE_NODES = 50_000_000
_DUAL_WORK = 2e8
"""Squared candidates times iterations that a level's bound may take: some 0.7 s."""
_DUAL_ITERATIONS = 50, 1000
_LEAST_REFINED = 3
_LARGEST = 1e12
"""√area of shapes that are not normalised, and its inverse; fourth powers of it are computed."""


def match(
    source: Shape,
    target: Shape,
    options: MatchOptions | None = None,
    control: Control | None = None,
) -> Match:
    """Minimum-distortion correspondence between samples of two shapes: problem (1), as (5).

    The coarsest level is enumerated exactly; its best solutions are hypotheses, each refined
    from level to level (4.1), ranked by their energy at the finest one. Then the winner's
    problem is bounded at every level, and improved where the bound's search finds better.

    Parameters
    ----------
    source, target
        The shapes X and Y.
    options
        By default ``MatchOptions()``.
    control
        Reports progress and cancels. Past its deadline, or the options' time limit, the best
        answer so far is returned with the bound known by then.

    Returns
    -------
    Match
        The same for the same shapes and options, unless a time limit cuts it short.

    Raises
    ------
    Cancelled
        Through `control`.
    OptionError
        An option does not suit these shapes.
    """
    options = options or MatchOptions()
    control = control or Control()
    if options.time_limit is not None:
        control = control.within(options.time_limit)
    options = options.settled(_common_size(source, target))
    run = _Run(source, target, options, control)
    levels = run.build_levels()
    if options.objective == LINF:
        hypotheses = run.minimax(levels[0])
        return run.answer(hypotheses[0], hypotheses[1:], levels)
    hypotheses = run.coarse(levels[0])
    for level in levels[1:]:
        hypotheses = run.finer(hypotheses, level)
    best = run.bounded(hypotheses[0], levels)
    return run.answer(best, hypotheses[1:], levels)


def _common_size(source: Shape, target: Shape) -> float:
    """√area that suits both shapes: the same for both, so that differences of scale remain."""
    if source.normalise != target.normalise:
        raise OptionError("normalise", "both shapes must be normalised, or none")
    if not all(1.0 / _LARGEST < shape.size < _LARGEST for shape in (source, target)):
        raise OptionError(
            "normalise",
            f"√area is not within {1.0 / _LARGEST:g} and {_LARGEST:g} of the shapes' own units; "
            "normalise them, or upload them in other units",
        )
    return float(np.sqrt(source.size * target.size))


@dataclass(frozen=True, eq=False)
class _Stage:
    """A hypothesis at one level, and its place among all there."""

    problem: LabellingProblem
    solution: Solution
    rank: int
    seconds: float


@dataclass(frozen=True, eq=False)
class _Hypothesis:
    """A coarse solution, carried through the levels so far."""

    stages: tuple[_Stage, ...]

    @property
    def partners(self) -> IntArray:
        return self.stages[-1].solution.partners

    @property
    def energy(self) -> float:
        return self.stages[-1].solution.energy


@dataclass
class _Run:
    """One match under way."""

    source: Shape
    target: Shape
    options: MatchOptions
    control: Control
    timings: dict[str, float] = field(default_factory=dict)
    warnings: list[str] = field(default_factory=list)
    started: float = field(default_factory=time.perf_counter)

    def build_levels(self) -> list[Level]:
        """Sample the shapes and compute their structures at every level."""
        started = time.perf_counter()
        if self.options.needs_spectrum:
            for name, shape in ("source", self.source), ("target", self.target):
                self.control.report(f"spectrum of the {name}", 0.0)
                shape.spectrum()
        self.timings["spectra"] = time.perf_counter() - started
        started = time.perf_counter()
        sizes = level_sizes(self.source, self.target, self.options)
        if sizes[-1][0] < self.options.points:
            self.warnings.append(
                f"only {sizes[-1][0]} points could be matched: a shape has no more vertices"
            )
        levels = []
        for index, size in enumerate(sizes):
            self.control.report("structures", 0.1 + 0.3 * index / len(sizes))
            levels.append(build_level(self.source, self.target, index, size, self.options))
        self.timings["structures"] = time.perf_counter() - started
        return levels

    def coarse(self, level: Level) -> list[_Hypothesis]:
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
            partners = local_search(problem, assign(problem, problem.unary))
            solution = Solution(partners, problem.energy(partners), 0.0, 0, Method.LOCAL_SEARCH)
            return [_Hypothesis((_Stage(problem, solution, 1, seconds),))]
        bound = float(found.energies[0]) if found.proven else 0.0
        hypotheses = []
        for rank, (partners, energy) in enumerate(
            zip(found.partners, found.energies, strict=True), start=1
        ):
            solution = Solution(
                partners, float(energy), bound, found.nodes, Method.BRANCH_AND_BOUND
            )
            hypotheses.append(_Hypothesis((_Stage(problem, solution, rank, seconds),)))
        return hypotheses

    def minimax(self, level: Level) -> list[_Hypothesis]:
        """Find the correspondences of least greatest distortion; of these, the best by (5)."""
        self.control.report("coarse matching", 0.4)
        started = time.perf_counter()
        source, target = level.source.distances, level.target.distances
        least = minimax_correspondence(source, target, control=self.control)
        if not least.proven:
            self.warnings.append("the least greatest distortion could not be proven in time")
        problem = level.problem(level.all_candidates())
        found = m_best_solutions(
            within_distortion(problem, source, target, least.distortion),
            self.options.alternatives,
            known=least.pairs[:, 1],
            control=self.control,
        )
        self.timings["coarse matching"] = seconds = time.perf_counter() - started
        hypotheses = []
        for rank, partners in enumerate(found.partners, start=1):
            energy = level.distortion(partners).linf
            if energy <= least.distortion:
                solution = Solution(
                    partners, energy, least.lower_bound, least.nodes, Method.MINIMAX
                )
                hypotheses.append(_Hypothesis((_Stage(problem, solution, rank, seconds),)))
        return hypotheses

    def finer(self, hypotheses: list[_Hypothesis], level: Level) -> list[_Hypothesis]:
        """Refine every hypothesis to the next level, and rank them there."""
        self.control.report("refinement", 0.45 + 0.05 * level.index)
        started = time.perf_counter()
        refined = []
        for hypothesis in hypotheses:
            self.control.check()
            before = time.perf_counter()
            found = refine(hypothesis.partners, level, self.options.rho)
            refined.append((found, hypothesis, time.perf_counter() - before))
        refined.sort(key=lambda entry: entry[0].energy)
        self._spend("refinement", started)
        return [
            _Hypothesis(
                (
                    *hypothesis.stages,
                    _Stage(
                        found.problem,
                        Solution(found.partners, found.energy, 0.0, 0, Method.LOCAL_SEARCH),
                        rank,
                        seconds,
                    ),
                )
            )
            for rank, (found, hypothesis, seconds) in enumerate(refined, start=1)
        ]

    def bounded(self, winner: _Hypothesis, levels: list[Level]) -> _Hypothesis:
        """Bound the winner's problem at every level above the coarsest."""
        started = time.perf_counter()
        stages = [winner.stages[0]]
        for level, stage in zip(levels[1:], winner.stages[1:], strict=True):
            self.control.report(
                f"bounds for {stage.problem.n_sources} points",
                0.6 + 0.4 * level.index / len(levels),
            )
            before = time.perf_counter()
            solution = _solve(stage.problem, stage.solution, self.control)
            seconds = stage.seconds + time.perf_counter() - before
            stages.append(_Stage(stage.problem, solution, stage.rank, seconds))
        self._spend("bounds", started)
        return _Hypothesis(tuple(stages))

    def answer(self, best: _Hypothesis, others: list[_Hypothesis], levels: list[Level]) -> Match:
        """Put the answer together, in the user's vertex numbers."""
        finest = levels[-1]
        seen = {best.partners.tobytes()}
        distinct = []
        for hypothesis in others:
            if hypothesis.partners.tobytes() not in seen:
                seen.add(hypothesis.partners.tobytes())
                distinct.append(hypothesis)
        alternatives = [self._correspondence(hypothesis, finest) for hypothesis in distinct]
        warnings = [
            f"{name}: {warning}"
            for name, shape in (("source", self.source), ("target", self.target))
            for warning in shape.mesh.warnings
        ]
        answer = self._correspondence(best, finest)
        reports = tuple(
            _report(level, stage) for level, stage in zip(levels, best.stages, strict=True)
        )
        refinement = self._refined([best, *distinct], finest)
        self.timings["total"] = time.perf_counter() - self.started
        return Match(
            answer,
            tuple(alternatives),
            reports,
            (*warnings, *self.warnings),
            self.timings,
            refinement,
        )

    def _refined(self, hypotheses: list[_Hypothesis], finest: Level) -> Refinement | None:
        """Refine the answer between vertices, if that was asked for and can be done."""
        if self.options.refine != GMDS:
            return None
        points, places = [], []
        for place, hypothesis in enumerate(hypotheses):
            matched = hypothesis.partners != UNMATCHED
            if np.count_nonzero(matched) >= _LEAST_REFINED:
                partners = hypothesis.partners[matched]
                points.append((finest.source.vertices[matched], finest.target.vertices[partners]))
                places.append(place)
        if 0 not in places:
            self.warnings.append("too few points were matched for a refinement")
            return None
        self.control.report("refinement between vertices", 0.9)
        started = time.perf_counter()
        found = refine_by_gmds(self.source, self.target, points, self.control)
        self._spend("refinement between vertices", started)
        return replace(found, hypothesis=places[found.hypothesis])

    def _correspondence(self, hypothesis: _Hypothesis, finest: Level) -> Correspondence:
        partners = hypothesis.partners
        matched = partners != UNMATCHED
        source = self.source.mesh.vertex_ids[finest.source.vertices]
        target = self.target.mesh.vertex_ids[finest.target.vertices]
        return Correspondence(
            source=source[matched],
            target=target[partners[matched]],
            costs=self._costs(hypothesis, finest)[matched],
            unmatched=source[~matched],
            energy=hypothesis.energy,
            distortion=finest.distortion(partners),
        )

    def _costs(self, hypothesis: _Hypothesis, level: Level) -> FloatArray:
        partners = hypothesis.partners
        if self.options.objective == LINF:
            target = level.target.distances[np.ix_(partners, partners)]
            return greatest_distortions(level.source.distances, target)
        return hypothesis.stages[-1].problem.costs(partners)

    def _spend(self, stage: str, started: float) -> None:
        self.timings[stage] = self.timings.get(stage, 0.0) + time.perf_counter() - started


def _solve(problem: LabellingProblem, known: Solution, control: Control) -> Solution:
    """Prove `known` optimal or improve it, as far as the work a level may take allows."""
    iterations = int(np.clip(_DUAL_WORK / max(problem.n_candidates, 1) ** 2, *_DUAL_ITERATIONS))
    return minimise(problem, known.partners, iterations=iterations, control=control)


def _report(level: Level, stage: _Stage) -> LevelReport:
    """Report a level; the coarsest one's energy is its optimum's, whichever solution won."""
    problem, solution = stage.problem, stage.solution
    enumerated = level.index == 0 and solution.method is Method.BRANCH_AND_BOUND
    proven_coarse = enumerated and solution.lower_bound > 0.0
    return LevelReport(
        points=problem.n_sources,
        target_points=problem.n_targets,
        candidates=problem.n_candidates,
        metric=level.metric.name,
        descriptor=level.descriptor.name,
        energy=solution.lower_bound if proven_coarse else solution.energy,
        lower_bound=solution.lower_bound,
        iterations=solution.iterations,
        method=solution.method,
        seconds=stage.seconds,
        rank=stage.rank,
    )
