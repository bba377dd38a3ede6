"""The level that decides between coarse hypotheses, before any geodesic distance is computed.

Commute times level off: between far points they hardly differ, so that of the best coarse solutions
by commute times many are twisted, the left hand with the right foot. Geodesic distances tell these
from the right ones, at the price of a search from every sample. Varadhan's formula gives nearly the
same from the spectrum that commute times are made of, at next to none.
"""

from dataclasses import replace

import numpy as np

from solver.arrays import IntArray
from solver.labelling import LINF
from solver.matching.level import NO_LANDMARKS, Level, SampledStructure, build_level
from solver.matching.options import MatchOptions
from solver.shape import Shape, varadhan_distances
from solver.shape.choices import CommuteTime, Geodesic, Varadhan

_OVERSAMPLING = 6
"""Target samples per source sample: they cost little, and the more there are, the nearer is one."""


def is_decided(options: MatchOptions) -> bool:
    """Whether the coarse points are matched a second time: between commute times and geodesics.

    Who names one metric for all levels gets that one alone. Where they are, hypotheses are verified
    by the rest of the surface as well.

    Parameters
    ----------
    options
        Of the match.
    """
    if options.objective == LINF or options.beta == 0.0 or len(options.metrics) < 2:
        return False
    coarse, finer = options.metrics[:2]
    return isinstance(coarse, CommuteTime) and isinstance(finer, Geodesic)


def with_deciding_size(sizes: list[tuple[int, int]], target: Shape) -> list[tuple[int, int]]:
    """Numbers of samples of all levels, with the deciding one after the coarsest.

    Parameters
    ----------
    sizes
        Numbers (N, M) of source and target samples of the others, the coarsest first.
    target
        The shape Y.

    Returns
    -------
    The target samples of a level begin those of the next.
    """
    points = sizes[0][0]
    most = min(_OVERSAMPLING * points, target.n_vertices)
    return [sizes[0], (points, most), *((n, max(m, most)) for n, m in sizes[1:])]


def deciding_level(
    source: Shape,
    target: Shape,
    index: int,
    size: tuple[int, int],
    options: MatchOptions,
    landmarks: IntArray = NO_LANDMARKS,
) -> Level:
    """Sample the target more closely than the coarsest level does, and measure by heat.

    Parameters
    ----------
    source, target
        The shapes X and Y.
    index, size, options, landmarks
        As for :func:`solver.matching.level.build_level`.

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
        source=_measured(source, level.source, metric),
        target=_measured(target, level.target, metric),
    )


def _measured(shape: Shape, sampled: SampledStructure, metric: Varadhan) -> SampledStructure:
    """Return the same samples with distances in another metric."""
    assert metric.time is not None
    distances = varadhan_distances(shape.spectrum(), sampled.vertices, metric.time)
    return replace(sampled, distances=distances)
