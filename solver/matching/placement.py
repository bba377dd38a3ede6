"""Placement of matched points at their images under the chosen map of all vertices."""

from dataclasses import replace

import numpy as np

from solver.arrays import BoolArray, FloatArray, IntArray
from solver.matching.hierarchy import (
    RefinedCorrespondence,
    best_candidates,
    candidates_per_point,
)
from solver.matching.level import Level, SampledStructure
from solver.matching.structures import descriptors_at
from solver.optimisation.primal import InfeasibleError, local_search, maximum_matching
from solver.shape import Shape, varadhan_distances
from solver.shape.choices import Geodesic, Varadhan

_REACH = 0.05
"""Geodesic distance over √area within which a point may lie from its image: twice the mean error of
the maps of generated shapes (`python -m bench.dense`)."""


def add_target_samples(source: Shape, target: Shape, level: Level, images: IntArray) -> Level:
    """Add the images of a level's source samples to its target samples.

    Parameters
    ----------
    source, target
        The shapes X and Y.
    level
        The level.
    images
        (N,) vertices of the target.

    Returns
    -------
    The level with its target samples followed by the images that are not among them.
    """
    known = level.target.vertices
    added = np.setdiff1d(images, known)
    vertices = np.concatenate([known, added])
    if isinstance(level.metric, Varadhan):
        assert level.metric.time is not None
        distances = varadhan_distances(target.spectrum(), vertices, level.metric.time)
    else:
        distances = target.metric(level.metric).between(vertices)
    distances[: len(known), : len(known)] = level.target.distances
    ours, theirs = level.source, SampledStructure(vertices, distances, None)
    if ours.descriptors is not None:
        both = ours.vertices, vertices
        f, g = descriptors_at((source, target), level.descriptor, both, "descriptor")
        ours, theirs = replace(ours, descriptors=f), replace(theirs, descriptors=g)
    third = level.third_order
    if third is not None:
        third = third.at(target, vertices)
    return replace(level, source=ours, target=theirs, third_order=third)


def match_near_images(
    target: Shape,
    level: Level,
    images: IntArray,
    unit: float,
    mapped: BoolArray | None = None,
) -> RefinedCorrespondence | None:
    """Match points near their images under a map.

    Parameters
    ----------
    target
        The shape Y.
    level
        Of :func:`add_target_samples`.
    images
        (N,) vertices of the target.
    unit
        √area of the whole surface, in the target's unit of length.
    mapped
        (N,) points that have a partner, by default all; the others stay unmatched.

    Returns
    -------
    RefinedCorrespondence
        The best correspondence that local search finds among target samples within reach of the
        images; ``None`` where these coincide, so that there are too few.
    """
    distances = _distances_from_images(target, level, images)
    allowed = level.allowed()
    near = allowed & (distances <= _REACH * unit)
    if mapped is not None:
        near &= mapped[:, None]
    near[: level.landmarks] = allowed[: level.landmarks]
    problem = level.problem(best_candidates(distances, near, candidates_per_point(len(images))))
    x, y = problem.candidates.T
    try:
        start = maximum_matching(problem, distances[x, y])
    except InfeasibleError:
        return None
    found = local_search(problem, start)
    return RefinedCorrespondence(problem, found, problem.energy(found))


def _distances_from_images(target: Shape, level: Level, images: IntArray) -> FloatArray:
    """(N, M) geodesic or Varadhan distances from images to samples, in any metric of the level."""
    vertices = level.target.vertices
    if not isinstance(level.metric, Geodesic | Varadhan):
        return target.metric(Geodesic()).distances(images)[:, vertices]
    order = np.argsort(vertices)
    rows = order[np.searchsorted(vertices, images, sorter=order)]
    distances: FloatArray = level.target.distances[rows]
    return distances
