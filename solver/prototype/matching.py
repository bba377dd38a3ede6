"""Matching a target with a prototype: section 5."""

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from solver.arrays import IntArray
from solver.control import Control
from solver.errors import OptionError
from solver.hypotheses import HierarchicalRun, Hypothesis, distinct, level_reports
from solver.level import Level, SampledStructure, check_distances, sizes_between
from solver.match import Match
from solver.options import L2, MAX_COARSE_POINTS, MatchOptions
from solver.prototype.likelihood import PrototypeLevel, mean_distances
from solver.prototype.prototype import Prototype
from solver.shape import WITHOUT_COLORS, Shape
from solver.structures import MetricChoice

_OVERSAMPLING = 4
"""Target samples per point of the prototype, at every level."""


def match_prototype(
    prototype: Prototype,
    target: Shape,
    options: MatchOptions | None = None,
    control: Control | None = None,
) -> Match:
    """Most likely correspondence between a prototype's points and samples of a shape: problem (6).

    The levels, the hypotheses carried through them and the certificates are those of
    :func:`solver.matching.match`.

    Parameters
    ----------
    prototype
        The prototype 𝒳.
    target
        The shape Y.
    options
        By default ``MatchOptions()``, with 10 points at the coarsest level: that the arms of a
        body go with its legs, and are not the mirrored ones, a few more points on the trunk tell.
        Metric and descriptor are the prototype's.
    control
        Reports progress and cancels. Past its deadline, or the options' time limit, the best
        answer so far is returned with the bound known by then.

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
    options = options or MatchOptions()
    control = control or Control()
    check_options(prototype, target, options)
    if options.time_limit is not None:
        control = control.within(options.time_limit)
    if options.coarse_points == MatchOptions().coarse_points:
        options = replace(options, coarse_points=MAX_COARSE_POINTS)
    run = PrototypeRun(options, control, prototype=prototype, target=target)
    levels = run.build_levels()
    return run.answer(run.best_first(levels), levels)


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
    several = [target.sampling(metric, count).indices for metric in metrics]
    by_turns = np.stack(several, axis=1).ravel()
    _, first = np.unique(by_turns, return_index=True)
    found: IntArray = by_turns[np.sort(first)][:count]
    return found


def check_options(prototype: Prototype, target: Shape, options: MatchOptions) -> None:
    """Refuse what has no meaning for a prototype.

    Raises
    ------
    OptionError
    """
    if options.refine is not None:
        raise OptionError("refine", "a prototype has no surface; leave it out")
    if options.orientation:
        raise OptionError("orientation", "a prototype has no surface; leave it out")
    if options.dense:
        raise OptionError("dense", "a prototype has no surface; leave it out")
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


@dataclass(kw_only=True)
class PrototypeRun(HierarchicalRun):
    """A match of a prototype under way."""

    prototype: Prototype
    target: Shape

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

    def answer(self, hypotheses: list[Hypothesis], levels: list[Level]) -> Match:
        """Put the answer together, in the prototype's and the user's numbers."""
        finest, found = levels[-1], distinct(hypotheses)
        ids: tuple[IntArray, IntArray] = (
            finest.source.vertices,
            self.target.mesh.vertex_ids[finest.target.vertices],
        )
        best, *alternatives = (self.correspondence(one, finest, *ids) for one in found)
        warnings = (
            *(f"prototype: {warning}" for warning in self.prototype.warnings),
            *(f"target: {warning}" for warning in self.target.mesh.warnings),
            *self.warnings,
        )
        self.timings["total"] = time.perf_counter() - self.started
        return Match(
            best, tuple(alternatives), level_reports(found[0], levels), warnings, self.timings
        )
