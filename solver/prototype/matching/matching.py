"""Matching a target with a prototype: section 5."""

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from solver.arrays import IntArray
from solver.control import Control
from solver.errors import OptionError
from solver.labelling import L2, UNMATCHED
from solver.matching import (
    MAX_COARSE_POINTS,
    HierarchicalRun,
    Hypothesis,
    Level,
    Match,
    MatchOptions,
    SampledStructure,
    check_distances,
    distinct,
    level_reports,
    sizes_between,
)
from solver.prototype.matching.likelihood import PrototypeLevel, mean_distances
from solver.prototype.matching.orientation import oriented_images
from solver.prototype.prototype import Prototype
from solver.prototype.surfaces import SurfaceSpectra, computed
from solver.shape import WITHOUT_COLORS, Shape
from solver.shape.choices import MetricChoice

_OVERSAMPLING = 4
"""Target samples per point of the prototype, at every level."""

_SAME = 0.3
"""Distance, over √area, within which every point of a hypothesis is where a map has it."""


def match_prototype(
    prototype: Prototype,
    target: Shape,
    options: MatchOptions | None = None,
    control: Control | None = None,
    surface_spectrum: SurfaceSpectra = computed,
) -> Match:
    """Most likely correspondence between a prototype's points and samples of a shape: problem (6).

    The levels, the hypotheses carried through them and the certificates are those of
    :func:`solver.matching.match.match`.

    Parameters
    ----------
    prototype
        The prototype 𝒳.
    target
        The shape Y.
    options
        By default ``MatchOptions()``, with orientation if the prototype has surfaces. At the
        coarsest level are 10 points: that the arms of a body go with its legs, and are not the
        mirrored ones, a few more points on the trunk tell. Metric and descriptor are the
        prototype's.
    control
        Reports progress and cancels. Past its deadline, or the options' time limit, the best
        answer so far is returned with the bound known by then.
    surface_spectrum
        Takes spectra of the prototype's surfaces from where they are kept between matches, or
        computes them.

    Returns
    -------
    Match
        Its source points are numbers of the prototype's points, its energies are negative
        log-likelihoods over their least values, and its distortions are those of the mean
        distances and descriptors.

    Raises
    ------
    Cancelled
        Through `control`.
    OptionError
        An option does not suit the prototype or the shape.
    """
    options = options or MatchOptions(orientation=bool(prototype.surfaces))
    control = control or Control()
    check_options(prototype, target, options)
    if options.time_limit is not None:
        control = control.within(options.time_limit)
    if options.coarse_points == MatchOptions().coarse_points:
        options = replace(options, coarse_points=MAX_COARSE_POINTS)
    run = PrototypeRun(
        options,
        control,
        prototype=prototype,
        target=target,
        surface_spectrum=surface_spectrum,
    )
    levels = run.build_levels()
    hypotheses = run.oriented(run.ranked(levels), levels)
    return run.answer([run.bounded(hypotheses[0], levels), *hypotheses[1:]], levels)


def samples_by_turns(target: Shape, metrics: Sequence[MetricChoice], count: int) -> IntArray:
    """Vertices of several farthest point samplings, by turns.

    Parameters
    ----------
    target
        The shape.
    metrics
        Of the samplings.
    count
        How many vertices; those of a smaller number begin those of a greater.

    Returns
    -------
    (count,) int64, distinct.
    """
    each = min(-(-count // len(metrics)) + 1, count)
    while True:
        several = [target.sampling(metric, each).indices for metric in metrics]
        by_turns = np.stack(several, axis=1).ravel()
        _, first = np.unique(by_turns, return_index=True)
        missing = count - len(first)
        if missing <= 0:
            found: IntArray = by_turns[np.sort(first)][:count]
            return found
        # Some vertices are in several samplings, which begin with the ends of the shape.
        each = min(each + -(-missing // len(metrics)) + 1, count)


def check_options(prototype: Prototype, target: Shape, options: MatchOptions) -> None:
    """Refuse what has no meaning for a prototype.

    Raises
    ------
    OptionError
    """
    if options.refine is not None:
        raise OptionError("refine", "of a prototype points are matched alone; leave it out")
    if options.dense:
        raise OptionError("dense", "of a prototype points are matched alone; leave it out")
    if options.orientation and not prototype.surfaces:
        raise OptionError("orientation", WITHOUT_SURFACES)
    if options.landmarks:
        raise OptionError("landmarks", "a prototype has no vertices; leave them out")
    if options.objective != L2:
        raise OptionError("objective", f"a prototype is matched by likelihood; it must be {L2}")
    usual = MatchOptions()
    own_metrics = tuple(one.metric for one in prototype.distances)
    if options.metrics not in (usual.metrics, own_metrics):
        raise OptionError("metric", "a prototype has its own; leave it out")
    own_descriptors = tuple(one.descriptor for one in prototype.descriptors if one is not None)
    if options.descriptors not in (usual.descriptors, own_descriptors):
        raise OptionError("descriptor", "a prototype has its own; leave it out")
    for field in ("normalise", "eigenpairs", "geodesic_method"):
        if getattr(target, field) != getattr(prototype, field):
            raise OptionError(
                field, f"it must be as the prototype was learned: {getattr(prototype, field)}"
            )


WITHOUT_SURFACES = "the prototype keeps no surfaces; leave it out, or learn the prototype again"


@dataclass(kw_only=True)
class PrototypeRun(HierarchicalRun):
    """A match of a prototype under way."""

    prototype: Prototype
    target: Shape
    surface_spectrum: SurfaceSpectra = computed

    def build_levels(self) -> list[Level]:
        """Sample the target and compute its structures at every level."""
        started = time.perf_counter()
        if self._needs_spectrum():
            self.control.report("spectrum of the target", 0.0)
            self.target.spectrum()
        self.timings["spectra"] = time.perf_counter() - started
        started = time.perf_counter()
        sizes = [
            (points, min(_OVERSAMPLING * points, self.target.n_vertices))
            for points, _ in sizes_between(
                self.prototype.points, self.target.n_vertices, self.options
            )
        ]
        if sizes[-1][0] < min(self.options.points, self.prototype.points):
            self.warnings.append(
                f"only {sizes[-1][0]} points could be matched: the target has no more vertices"
            )
        levels: list[Level] = []
        for index, size in enumerate(sizes):
            self.control.report("structures", 0.1 + 0.3 * index / len(sizes))
            levels.append(self._level(index, size))
        self.timings["structures"] = time.perf_counter() - started
        return levels

    def _needs_spectrum(self) -> bool:
        prototype = self.prototype
        metrics = [*prototype.sampling, *(one.metric for one in prototype.distances)]
        described = [one for one in prototype.descriptors if one is not None]
        weighed = self.options.first_order_weight > 0.0
        return any(one.spectral for one in metrics) or (
            weighed and any(one.descriptor.spectral for one in described)
        )

    def _level(self, index: int, size: tuple[int, int]) -> Level:
        options, prototype = self.options, self.prototype
        distances = prototype.distances[min(index, len(prototype.distances) - 1)]
        learned = prototype.descriptors[min(index, len(prototype.descriptors) - 1)]
        vertices = samples_by_turns(self.target, prototype.sampling, size[1])
        between = self.target.metric(distances.metric).between(vertices)
        check_distances(distances.metric, between, "metric")
        described = None
        if learned is not None and options.first_order_weight > 0.0:
            if learned.descriptor.colored and self.target.mesh.colors is None:
                raise OptionError("descriptor", WITHOUT_COLORS.replace("shape", "target", 1))
            found = self.target.descriptor(learned.descriptor, vertices)
            described = learned.coordinates(found)
        points = np.arange(size[0], dtype=np.int64)
        means = None
        if learned is not None and described is not None:
            means = learned.mixtures.averages[: size[0]]
        source = SampledStructure(points, mean_distances(distances.mixtures, size[0]), means)
        return PrototypeLevel(
            index,
            distances.metric,
            options.descriptor_at(0) if learned is None else learned.descriptor,
            source,
            SampledStructure(vertices, between, described),
            options.beta,
            options.first_order_weight,
            np.inf if options.occlusion_cost is None else options.occlusion_cost,
            distances,
            learned,
        )

    def oriented(self, hypotheses: list[Hypothesis], levels: list[Level]) -> list[Hypothesis]:
        """Put first what agrees with a map that keeps orientation, if that is wanted.

        That is the most likely hypothesis all of whose points are near where the map has them; if
        there is none, a further one, begun there.
        """
        if not self.options.orientation:
            return hypotheses
        self.control.report("maps from examples", 0.5)
        started = time.perf_counter()
        finest = levels[-1]
        given = []
        for one in distinct(hypotheses):
            matched = np.flatnonzero(one.partners != UNMATCHED)
            given.append((matched, finest.target.vertices[one.partners[matched]]))
        found = oriented_images(
            self.prototype.surfaces,
            self.target,
            given,
            self.control,
            spectrum=self.surface_spectrum,
        )
        self.spend("maps from examples", started)
        if found is None:
            self.warnings.append(
                "left and right could not be told apart: the target is like none of the examples"
            )
            return hypotheses
        images = found.vertices
        for place, one in enumerate(hypotheses):
            if self._agrees(one, images, finest):
                return [one, *hypotheses[:place], *hypotheses[place + 1 :]]
        coarse = levels[0]
        places = images[: len(coarse.source.vertices)]
        near = self.target.metric("geodesic").distances(places)[:, coarse.target.vertices]
        return [self.carried(levels, near, hypotheses), *hypotheses]

    def _agrees(self, hypothesis: Hypothesis, images: IntArray, level: Level) -> bool:
        """Whether all points of a hypothesis are near where a map has them."""
        matched = np.flatnonzero(hypothesis.partners != UNMATCHED)
        # From the samples, as these distances are known.
        partners = level.target.vertices[hypothesis.partners[matched]]
        between = self.target.metric("geodesic").distances(partners)
        apart = between[np.arange(len(matched)), images[matched]]
        return bool((apart <= _SAME * self.target.size).all())

    def answer(self, hypotheses: list[Hypothesis], levels: list[Level]) -> Match:
        """Put the answer together, in the prototype's and the user's numbers."""
        finest, found = levels[-1], distinct(hypotheses)
        ids: tuple[IntArray, IntArray] = (
            finest.source.vertices,
            self.target.mesh.vertex_ids[finest.target.vertices],
        )
        best, *alternatives = (self.correspondence(one, finest, *ids) for one in found)
        misfit = self._misfit(found[0])
        warnings = (
            *(f"prototype: {warning}" for warning in self.prototype.warnings),
            *(f"target: {warning}" for warning in self.target.mesh.warnings),
            *self.warnings,
        )
        self.timings["total"] = time.perf_counter() - self.started
        reports = level_reports(found[0], levels)
        return Match(best, tuple(alternatives), reports, warnings, self.timings, misfit=misfit)

    def _misfit(self, answer: Hypothesis) -> float | None:
        """How much the target misfits the class; a warning if it does more than any example."""
        coarsest, prototype = answer.stages[0], self.prototype
        points, usual = coarsest.problem.n_sources, MatchOptions()
        alike = (
            points == min(prototype.points, MAX_COARSE_POINTS)
            and self.options.beta == usual.beta
            and self.options.first_order_weight == usual.first_order_weight
            and self.options.occlusion_cost is None
        )
        if not (alike and len(prototype.left_out_energies)):
            return None
        misfit = coarsest.solution.value / points / prototype.usual_energy
        if misfit > prototype.greatest_misfit:
            self.warnings.append(
                f"the target is unlike the examples of the class: it misfits them {misfit:.2g}"
                " times as much as a usual one, so look at the answer"
            )
        return misfit
