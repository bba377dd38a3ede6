"""Points where the map that decided has them, once it has told left from right."""

from dataclasses import replace

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.matching.hierarchy import Refinement, candidates_per_point, closest
from solver.matching.level import Level, SampledStructure, described
from solver.optimisation.primal import InfeasibleError, local_search, solve_lap
from solver.shape import Shape, varadhan_distances
from solver.shape.choices import Geodesic, Varadhan

_REACH = 0.05
"""Geodesic distance over √area from an image within which a point may go: twice what a map errs."""


def with_images(source: Shape, target: Shape, level: Level, images: IntArray) -> Level:
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
    The same level, whose target samples are followed by those images that are not among them.
    """
    known = level.target.vertices
    vertices = np.concatenate([known, np.setdiff1d(images, known)])
    if isinstance(level.metric, Varadhan):
        assert level.metric.time is not None
        distances = varadhan_distances(target.spectrum(), vertices, level.metric.time)
    else:
        distances = target.metric(level.metric).between(vertices)
    ours, theirs = level.source, SampledStructure(vertices, distances, None)
    if ours.descriptors is not None:
        places = ours.vertices, vertices
        f, g = described((source, target), level.descriptor, places, "descriptor")
        ours, theirs = replace(ours, descriptors=f), replace(theirs, descriptors=g)
    return replace(level, source=ours, target=theirs)


def at_images(target: Shape, level: Level, images: IntArray) -> Refinement | None:
    """Match points near where a map has them.

    Parameters
    ----------
    target
        The shape Y.
    level
        Of :func:`with_images`.
    images
        (N,) vertices of the target.

    Returns
    -------
    Refinement
        The best correspondence that local search finds among an image and what is within reach of
        it; ``None`` where images coincide and there are too few places.
    """
    apart = _lengths(target, level, images)
    allowed = level.allowed()
    near = allowed & (apart <= _REACH * target.size)
    near[: level.landmarks] = allowed[: level.landmarks]
    problem = level.problem(closest(apart, near, candidates_per_point(len(images))))
    x, y = problem.candidates.T
    try:
        start = solve_lap(problem, apart[x, y])
    except InfeasibleError:
        return None
    found = local_search(problem, start)
    return Refinement(problem, found, problem.energy(found))


def _lengths(target: Shape, level: Level, images: IntArray) -> FloatArray:
    """(N, M) geodesic distances from images to samples, whatever the metric of the level."""
    vertices = level.target.vertices
    if not isinstance(level.metric, Geodesic | Varadhan):
        return target.metric(Geodesic()).distances(images)[:, vertices]
    places = np.argsort(vertices)
    own = places[np.searchsorted(vertices, images, sorter=places)]
    apart: FloatArray = level.target.distances[own]
    return apart
