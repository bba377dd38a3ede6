"""Sampling stage of a match with a prototype: its points, and samples of the target (section 5)."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from solver.arrays import IntArray
from solver.control import Control
from solver.matching import (
    MatchOptions,
    SampledStructure,
    check_colors,
    check_distances,
    level_sizes,
)
from solver.prototype.matching.level import PrototypeLevel, mean_distances
from solver.prototype.prototype import LearnedDescriptors, Prototype
from solver.shape import Shape
from solver.shape.choices import MetricChoice


def sample_target(
    prototype: Prototype, target: Shape, options: MatchOptions, control: Control
) -> tuple[list[PrototypeLevel], tuple[str, ...]]:
    """Sample a target and compute its structures at every level (4.1, section 5).

    Parameters
    ----------
    prototype
        The prototype 𝒳.
    target
        The shape Y.
    options
        Of the match.
    control
        Reports progress and cancels.

    Returns
    -------
    The levels, the coarsest first, and warnings.

    Raises
    ------
    Cancelled
        Through `control`.
    OptionError
        The target has no colours, or a structure cannot be computed on it.
    """
    with control.stage("spectra"):
        if _needs_spectrum(prototype, options):
            control.report("spectrum of the target", 0.0)
            target.spectrum()
    with control.stage("structures"):
        sizes = [
            (points, min(options.oversampling * points, target.n_vertices))
            for points, _ in level_sizes(prototype.points, target.n_vertices, options)
        ]
        levels = []
        for index, size in enumerate(sizes):
            control.report("structures", 0.25 + 0.75 * index / len(sizes))
            levels.append(_build_level(prototype, target, index, size, options))
    points = sizes[-1][0]
    if points < min(options.points, prototype.points):
        return levels, (f"only {points} points could be matched: the target has no more vertices",)
    return levels, ()


def _needs_spectrum(prototype: Prototype, options: MatchOptions) -> bool:
    """Return whether some structure that is used is made of Laplace-Beltrami eigenpairs."""
    metrics = *prototype.sampling, *prototype.metric_choices
    return any(one.spectral for one in metrics) or (
        options.first_order_weight > 0.0
        and any(one.spectral for one in prototype.descriptor_choices)
    )


def _build_level(
    prototype: Prototype, target: Shape, index: int, size: tuple[int, int], options: MatchOptions
) -> PrototypeLevel:
    """Build the level of the first N points of the prototype and M samples of the target."""
    learned = prototype.distances[min(index, len(prototype.distances) - 1)]
    place = min(index, len(prototype.descriptors) - 1)
    fields = prototype.descriptors[place]
    points = np.arange(size[0], dtype=np.int64)
    source = SampledStructure(points, mean_distances(learned.mixtures, size[0]), None)
    vertices = sample_in_turn(target, prototype.sampling, size[1])
    distances = target.metric(learned.metric).between(vertices)
    check_distances(learned.metric, distances, "metric")
    sampled = SampledStructure(vertices, distances, None)
    if fields is not None and options.first_order_weight > 0.0:
        source, sampled = _describe(fields, target, source, sampled)
    return PrototypeLevel(
        index,
        learned.metric,
        prototype.descriptor_choices[place],
        source,
        sampled,
        options.beta,
        options.first_order_weight,
        np.inf if options.occlusion_cost is None else options.occlusion_cost,
        learned,
        fields,
    )


def _describe(
    learned: LearnedDescriptors, target: Shape, source: SampledStructure, sampled: SampledStructure
) -> tuple[SampledStructure, SampledStructure]:
    """Add mean descriptors to the prototype's points, and coordinates to the target's samples."""
    check_colors(target, "target", learned.descriptor, "descriptor")
    found = target.descriptor(learned.descriptor, sampled.vertices)
    means = learned.mixtures.averages[: len(source.vertices)]
    return (
        replace(source, descriptors=means),
        replace(sampled, descriptors=learned.coordinates(found)),
    )


def sample_in_turn(target: Shape, metrics: Sequence[MetricChoice], count: int) -> IntArray:
    """Merge farthest point samplings in several metrics, one sample of each in turn.

    Parameters
    ----------
    target
        The shape.
    metrics
        Of the samplings.
    count
        Number of samples; those of a smaller number begin those of a greater.

    Returns
    -------
    (count,) int64 vertices, distinct.
    """
    each = min(-(-count // len(metrics)) + 1, count)
    while True:
        samplings = [target.sampling(metric, each).indices for metric in metrics]
        merged = np.stack(samplings, axis=1).ravel()
        _, first = np.unique(merged, return_index=True)
        missing = count - len(first)
        if missing <= 0:
            found: IntArray = merged[np.sort(first)][:count]
            return found
        # Some vertices are in several samplings, which begin with the ends of the shape.
        each = min(each + -(-missing // len(metrics)) + 1, count)
