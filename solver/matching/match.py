"""The front door: match two shapes."""

import time
from dataclasses import dataclass, replace

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.control import Control
from solver.errors import OptionError
from solver.functional_maps import DenseCorrespondence, DenseMap, dense_correspondence, extended_map
from solver.gmds import GmdsRefinement, refine_by_gmds
from solver.labelling import LINF, UNMATCHED, Method, Solution
from solver.matching.hypotheses import HierarchicalRun, Hypothesis, Stage, distinct, level_reports
from solver.matching.landmarks import landmark_vertices
from solver.matching.level import Level, build_level, level_sizes
from solver.matching.options import GMDS, MatchOptions
from solver.matching.placement import at_images, with_images
from solver.matching.result import Match
from solver.matching.varadhan_level import deciding_level, is_decided, with_deciding_size
from solver.matching.verification import verified
from solver.optimisation.exact import m_best_solutions, minimax_correspondence, within_distortion
from solver.shape import Shape

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
    from level to level (4.1). At the finest one they are put in order by what points that are not
    matched say of them (:mod:`.verification`), or by their energy there, where metrics are
    not commute times and then geodesic distances. Then the winner's problem is bounded at every
    level, and improved where the bound's search finds better.

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
    run = _Run(options, control, source=source, target=target)
    levels = run.build_levels()
    if options.objective == LINF:
        return run.answer(run.minimax(levels[0]), levels)
    return run.answer(run.judged(run.ranked(levels), levels[-1]), levels)


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


@dataclass(kw_only=True)
class _Run(HierarchicalRun):
    """A match of two shapes under way."""

    source: Shape
    target: Shape

    def build_levels(self) -> list[Level]:
        """Sample the shapes and compute their structures at every level."""
        started = time.perf_counter()
        if self.options.needs_spectrum:
            for name, shape in ("source", self.source), ("target", self.target):
                self.control.report(f"spectrum of the {name}", 0.0)
                shape.spectrum()
        self.timings["spectra"] = time.perf_counter() - started
        started = time.perf_counter()
        meshes = self.source.mesh, self.target.mesh
        landmarks = landmark_vertices(self.options.landmarks, *meshes)
        sizes = level_sizes(self.source, self.target, self.options)
        if sizes[-1][0] < self.options.points:
            self.warnings.append(
                f"only {sizes[-1][0]} points could be matched: a shape has no more vertices"
            )
        if again := is_decided(self.options):
            sizes = with_deciding_size(sizes, self.target)
        for shape, count, given in zip(
            (self.source, self.target), sizes[-1], landmarks.T, strict=True
        ):
            # The longest sampling begins with all others.
            shape.sampling(self.options.metric_at(0), count, tuple(given.tolist()))
        levels = []
        for index, size in enumerate(sizes):
            self.control.report("structures", 0.1 + 0.3 * index / len(sizes))
            if again and index == 1:
                build, structure = deciding_level, 0
            else:
                build, structure = build_level, index - int(again and index > 1)
            level = build(self.source, self.target, structure, size, self.options, landmarks)
            levels.append(replace(level, index=index))
        self.timings["structures"] = time.perf_counter() - started
        return levels

    def judged(self, hypotheses: list[Hypothesis], finest: Level) -> list[Hypothesis]:
        """Put in order by what the rest of the surface says, where heat decided before."""
        if not is_decided(self.options):
            return hypotheses
        started = time.perf_counter()
        found = verified(hypotheses, finest, self.source, self.target)
        self.spend("refinement", started)
        return found

    def minimax(self, level: Level) -> list[Hypothesis]:
        """Find the correspondences of least greatest distortion; of these, the best by (5)."""
        self.control.report("coarse matching", 0.4)
        started = time.perf_counter()
        source, target = level.source.distances, level.target.distances
        least = minimax_correspondence(source, target, control=self.control)
        if not least.certified:
            self.warnings.append("the least greatest distortion could not be proven in time")
        problem = level.problem(level.all_candidates())
        found = m_best_solutions(
            within_distortion(problem, source, target, least.value),
            self.options.alternatives,
            known=least.answer[:, 1],
            control=self.control,
        )
        self.timings["coarse matching"] = seconds = time.perf_counter() - started
        hypotheses = []
        for rank, partners in enumerate(found.partners, start=1):
            energy = level.distortion(partners).linf
            if energy <= least.value:
                solution = Solution(
                    partners, energy, least.lower_bound, least.iterations, Method.MINIMAX
                )
                hypotheses.append(Hypothesis((Stage(problem, solution, rank, seconds),)))
        return hypotheses

    def answer(self, hypotheses: list[Hypothesis], levels: list[Level]) -> Match:
        """Choose, prove, and put the answer together in the user's vertex numbers."""
        extended, found = self._oriented(distinct(hypotheses), levels)
        if extended is not None and self.options.objective != LINF:
            found[0], levels = self._placed(found, extended, levels)
        finest = levels[-1]
        if self.options.objective != LINF:
            found = distinct([self.bounded(found[0], levels), *found[1:]])
        ids = (
            self.source.mesh.vertex_ids[finest.source.vertices],
            self.target.mesh.vertex_ids[finest.target.vertices],
        )
        best, *alternatives = (self.correspondence(one, finest, *ids) for one in found)
        warnings = [
            f"{name}: {warning}"
            for name, shape in (("source", self.source), ("target", self.target))
            for warning in shape.mesh.warnings
        ]
        dense, refinement = self._extended(extended, found[0], finest)
        self.timings["total"] = time.perf_counter() - self.started
        return Match(
            best,
            tuple(alternatives),
            level_reports(found[0], levels),
            (*warnings, *self.warnings),
            self.timings,
            refinement,
            dense,
        )

    def _oriented(
        self, hypotheses: list[Hypothesis], levels: list[Level]
    ) -> tuple[DenseMap | None, list[Hypothesis]]:
        """Put that hypothesis first whose extension to all vertices is best, if that is wanted."""
        if not self.options.extended:
            return None, hypotheses
        self.control.report("dense map", 0.5)
        started = time.perf_counter()
        finest = levels[-1]
        points = [_matched(hypothesis, finest) for hypothesis in hypotheses]
        # Of least greatest distortion are only those given.
        further = not self.options.landmarks and self.options.objective != LINF
        found = extended_map(self.source, self.target, points, self.control, further)
        if found is None:
            self.warnings.append("too few points were matched for a map of all vertices")
            return None, hypotheses
        if self.options.objective != LINF:
            place = found.hypothesis
            if place == len(hypotheses):
                near = self._distances_to_images(found, levels[0])
                hypotheses = [*hypotheses, self.carried(levels, near, hypotheses)]
            hypotheses = [hypotheses[place], *hypotheses[:place], *hypotheses[place + 1 :]]
            found = replace(found, hypothesis=0)
        self.spend("dense map", started)
        return found, hypotheses

    def _placed(
        self, hypotheses: list[Hypothesis], found: DenseMap, levels: list[Level]
    ) -> tuple[Hypothesis, list[Level]]:
        """Match the first hypothesis' points where its map has them, between the samples."""
        self.control.report("points of the map", 0.55)
        started = time.perf_counter()
        first, finest = hypotheses[0], levels[-1]
        images = found.images(finest.source.vertices)
        wider = with_images(self.source, self.target, finest, images)
        placed = at_images(self.target, wider, images)
        self.spend("refinement", started)
        if placed is None:
            return first, levels
        rank = 1 + sum(other.energy < placed.energy for other in hypotheses[1:])
        solution = Solution(placed.partners, placed.energy, 0.0, 0, Method.LOCAL_SEARCH)
        seconds = first.stages[-1].seconds + time.perf_counter() - started
        stage = Stage(placed.problem, solution, rank, seconds)
        return Hypothesis((*first.stages[:-1], stage)), [*levels[:-1], wider]

    def _distances_to_images(self, found: DenseMap, coarse: Level) -> FloatArray:
        """(N, M) from the images of coarse source samples to the coarse target samples."""
        places = self.target.surface.vertices
        images = places[found.images(coarse.source.vertices)]
        samples = places[coarse.target.vertices]
        apart: FloatArray = np.linalg.norm(images[:, None] - samples[None], axis=2)
        return apart

    def _extended(
        self, extended: DenseMap | None, best: Hypothesis, finest: Level
    ) -> tuple[DenseCorrespondence | None, GmdsRefinement | None]:
        """Map all vertices, and refine the answer between vertices, as far as asked for."""
        if extended is None:
            return None, None
        started = time.perf_counter()
        dense = dense_correspondence(extended) if self.options.dense else None
        self.spend("dense map", started)
        if self.options.refine != GMDS:
            return dense, None
        self.control.report("refinement between vertices", 0.9)
        started = time.perf_counter()
        found = refine_by_gmds(extended, _matched(best, finest)[0], self.control)
        self.spend("refinement between vertices", started)
        return dense, found


def _matched(hypothesis: Hypothesis, level: Level) -> tuple[IntArray, IntArray]:
    """Vertices of X and of Y that correspond."""
    matched = hypothesis.partners != UNMATCHED
    return level.source.vertices[matched], level.target.vertices[hypothesis.partners[matched]]
