"""The Varadhan level: coarse hypotheses compared by near-geodesic distances from the spectrum.

Commute times hardly differ between far points. Many of the best coarse solutions by commute times
are therefore twisted, with a left hand on a right foot. Geodesic distances distinguish these, but
need a front from every sample. Varadhan's formula (:func:`.varadhan_distances`) approximates them
from the eigenpairs that commute times are made of, at next to no cost.
"""

from dataclasses import replace

import numpy as np

from solver.arrays import IntArray
from solver.labelling import LINF
from solver.matching.level import Level, SampledStructure
from solver.matching.options import MatchOptions
from solver.matching.structures import NO_PAIRS, build_level
from solver.shape import Shape, varadhan_distances
from solver.shape.choices import CommuteTime, Geodesic, Varadhan

_OVERSAMPLING = 6
"""Target samples per source sample. Chosen on generated shapes: they cost no fronts, and the denser
they are, the nearer is one to the image of a source sample."""


def uses_varadhan_level(options: MatchOptions) -> bool:
    """Return whether a match has a Varadhan level.

    It does where the coarsest level has commute times and the next has geodesic distances.
    One metric given for all levels is used alone.

    Parameters
    ----------
    options
        Of the match.
    """
    if options.objective == LINF or options.beta == 0.0 or len(options.metrics) < 2:
        return False
    coarse, finer = options.metrics[:2]
    return isinstance(coarse, CommuteTime) and isinstance(finer, Geodesic)


def add_varadhan_size(sizes: list[tuple[int, int]], n_vertices: int) -> list[tuple[int, int]]:
    """Add the size of the Varadhan level after that of the coarsest level.

    Parameters
    ----------
    sizes
        Numbers (N, M) of source and target samples of the other levels, the coarsest first.
    n_vertices
        Vertices of the target Y.

    Returns
    -------
    Sizes of all levels, M not decreasing: the target samples of a level begin those of the next.
    """
    points = sizes[0][0]
    most = min(_OVERSAMPLING * points, n_vertices)
    return [sizes[0], (points, most), *((n, max(m, most)) for n, m in sizes[1:])]


def build_varadhan_level(
    source: Shape,
    target: Shape,
    index: int,
    size: tuple[int, int],
    options: MatchOptions,
    landmarks: IntArray = NO_PAIRS,
) -> Level:
    """Sample the target more densely than the coarsest level, and measure by Varadhan's formula.

    Parameters
    ----------
    source, target
        The shapes X and Y.
    index, size, options, landmarks
        As of :func:`.build_level`.

    Raises
    ------
    OptionError
        A shape has too few vertices.
    """
    metric = Varadhan().settled(float(np.sqrt(source.size * target.size)))
    level = build_level(source, target, index, size, options, landmarks)
    return replace(
        level,
        metric=metric,
        source=_measure(source, level.source, metric),
        target=_measure(target, level.target, metric),
    )


def _measure(shape: Shape, sampled: SampledStructure, metric: Varadhan) -> SampledStructure:
    """Replace the distances of samples by those of Varadhan's formula."""
    assert metric.time is not None
    distances = varadhan_distances(shape.spectrum(), sampled.vertices, metric.time)
    return replace(sampled, distances=distances)
