"""Sampling stage: levels of two shapes, from a few farthest points to many (4.1)."""

from dataclasses import replace

import numpy as np

from solver.control import Control
from solver.errors import OptionError
from solver.labelling import LINF
from solver.matching.landmarks import landmark_vertices
from solver.matching.level import Level
from solver.matching.options import COARSE_POINTS, MatchOptions
from solver.matching.structures import build_level
from solver.matching.third_order import ThirdOrderTerm
from solver.matching.varadhan_level import (
    add_varadhan_size,
    build_varadhan_level,
    uses_varadhan_level,
)
from solver.shape import Shape

_COARSE_OVERSAMPLING = 1.5
"""Target samples per source sample at the coarsest level, chosen on generated
shapes: one sample in three may be the image of no source sample."""

_MAX_SIZE = 1e12
"""Greatest √area of shapes that are not normalised, and inverse of the least, in their own unit:
fourth powers of it are computed in double precision."""


def too_few(count: int, options: MatchOptions) -> tuple[str, ...]:
    """Return a warning if shapes have fewer vertices than points are to be matched.

    Parameters
    ----------
    count
        Number of points that can be matched.
    options
        Of the match.
    """
    if count >= options.points:
        return ()
    return (f"only {count} points could be matched: a shape has no more vertices",)


def sample(
    source: Shape, target: Shape, options: MatchOptions, control: Control
) -> tuple[list[Level], tuple[str, ...]]:
    """Sample both shapes and compute their structures (3) at every level (4.1).

    Parameters
    ----------
    source, target
        The shapes X and Y.
    options
        Of the match, settled.
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
        An option does not suit these shapes.
    """
    with control.stage("spectra"):
        if options.needs_spectrum:
            for name, shape in ("source", source), ("target", target):
                control.report(f"spectrum of the {name}", 0.0)
                # All parts take theirs from the greatest: what is larger is computed anew.
                shape.spectrum(max(shape.eigenpairs, options.least_eigenpairs))
    with control.stage("structures"):
        landmarks = landmark_vertices(options.landmarks, source.mesh, target.mesh)
        sizes = level_sizes(source.n_vertices, target.n_vertices, options)
        warnings = too_few(sizes[-1][0], options)
        varadhan = uses_varadhan_level(options)
        if varadhan:
            sizes = add_varadhan_size(sizes, target.n_vertices)
        for shape, count, given in zip((source, target), sizes[-1], landmarks.T, strict=True):
            # The longest sampling begins with all shorter ones: compute it once.
            shape.sampling(options.metric_at(0), count, tuple(given.tolist()))
        levels = []
        for index, size in enumerate(sizes):
            control.report("structures", 0.25 + 0.75 * index / len(sizes))
            is_varadhan = varadhan and index == 1
            build = build_varadhan_level if is_varadhan else build_level
            structure = max(index - 1, 0) if varadhan else index
            level = build(source, target, structure, size, options, landmarks)
            if options.third_order > 0.0 and (index == 0 or is_varadhan):
                samples = level.source.vertices, level.target.vertices
                term = ThirdOrderTerm.between(source, target, samples, options.third_order)
                level = replace(level, third_order=term)
            levels.append(replace(level, index=index))
    return levels, warnings


def level_sizes(max_sources: int, max_targets: int, options: MatchOptions) -> list[tuple[int, int]]:
    """Numbers of source and target samples of each level, the coarsest first.

    Parameters
    ----------
    max_sources, max_targets
        Greatest numbers of samples: vertices of the shapes, or points of a prototype.
    options
        Of the match.

    Returns
    -------
    List of (N, M) with N <= M, N growing by at most the level factor up to the points asked for.
    M does not fall: the target samples of a level begin those of the next.
    """
    most = min(max_sources, max_targets)
    if options.objective == LINF:
        coarse = options.points
    else:
        coarse = max(options.coarse_points or COARSE_POINTS, len(options.landmarks))
    points = min(coarse, options.points, most)
    sizes = [(points, min(int(np.ceil(_COARSE_OVERSAMPLING * points)), max_targets))]
    while points < min(options.points, most):
        points = min(points * options.level_factor, options.points, most)
        targets = min(points * options.oversampling, max_targets)
        sizes.append((points, max(targets, sizes[-1][1])))
    return sizes


def common_size(source: Shape, target: Shape) -> float:
    """Geometric mean of both √area: one unit for both, so that differences of scale remain.

    Raises
    ------
    OptionError
        One shape is normalised and the other is not, or a shape is too large or too small.
    """
    if source.normalise != target.normalise:
        raise OptionError("normalise", "both shapes must be normalised, or none")
    if not all(1.0 / _MAX_SIZE < shape.size < _MAX_SIZE for shape in (source, target)):
        raise OptionError(
            "normalise",
            f"√area is not within {1.0 / _MAX_SIZE:g} and {_MAX_SIZE:g} of the shapes' own units; "
            "normalise them, or upload them in other units",
        )
    return float(np.sqrt(source.size * target.size))
