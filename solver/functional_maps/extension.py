"""From sparse correspondences to a map of all points, and to the best of several hypotheses.

Extremities decide a coarse correspondence, and of them its several hypotheses are made; but they
say little of what lies between: a torso may be turned front to back at no cost. So each
hypothesis is extended to small functional maps, by what it says of its first points and by the wave
kernel signature for the rest. Each is refined by spectral upsampling, as far as it takes to tell
which is best. Of those that keep orientation, which tells left from right, the one is taken that
preserves signatures and the lengths of short chords best, and orientation most clearly; it is
refined to all eigenfunctions, fitted to more points.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.control import Control
from solver.functional_maps.dense_map import DenseMap, oriented_first
from solver.functional_maps.functional_map import (
    FunctionalMap,
    fit_functional_map,
    functional_map_of_points,
    spectral_upsampling,
)
from solver.functional_maps.map_quality import Comparison, Side
from solver.shape import Shape

_LANDMARKS = 8
"""Points of a hypothesis that are trusted alone."""

_HEAT_TIMES = 0.003, 0.01, 0.03
"""Times, on unit area, of the heat kernels that stand for a landmark."""

_COMMUTATIVITY = 1e-2
_MOST_OF_POINTS = 20
"""Eigenfunctions of a map that is fitted to points alone, at most."""

_LAST_STEP = 12
_TOLD = 54
"""Eigenfunctions that tell which map is best: what is wrong by then stays wrong."""

_MOST_POINTS = 10_000


@dataclass(frozen=True)
class Effort:
    """How carefully hypotheses are extended.

    Parameters
    ----------
    fits
        Numbers of eigenfunctions of the maps that are fitted to first points and signatures.
    step
        By how many eigenfunctions maps grow at a time.
    """

    fits: tuple[int, ...] = (20, 30)
    step: int = 6


QUICK = Effort(fits=(30,), step=12)
"""Enough where the answer is clear, in less than half the time."""

_CAREFUL = Effort()


def dense_map(
    source: Shape,
    target: Shape,
    hypotheses: Sequence[tuple[IntArray, IntArray]],
    control: Control | None = None,
) -> DenseMap:
    """Extend sparse correspondences to all points, and choose the best.

    Parameters
    ----------
    source, target
        The shapes X and Y.
    hypotheses
        (n,) vertices of X and (n,) vertices of Y, corresponding, farthest first.
    control
        May cancel. Past its deadline, no further starts are tried.

    Returns
    -------
    DenseMap
        The same for the same input, unless a deadline cuts it short.

    Raises
    ------
    Cancelled
        Through `control`.
    ValueError
        There is no hypothesis, or one of less than three points.
    """
    comparison = Comparison(source, target)
    found = extensions(comparison, hypotheses, control or Control())
    return completed(comparison, oriented_first(found)[0])


def extensions(
    comparison: Comparison,
    hypotheses: Sequence[tuple[IntArray, IntArray]],
    control: Control,
    first: int = 0,
    effort: Effort = _CAREFUL,
) -> list[DenseMap]:
    """Extend hypotheses to functional maps, each in several ways.

    Parameters
    ----------
    comparison
        Of the shapes.
    hypotheses, control
        As for :func:`dense_map`.
    first
        Number of the first hypothesis.
    effort
        How carefully.

    Returns
    -------
    One for each hypothesis and one for each of the effort's fits to it, of few eigenfunctions,
    unless a deadline cuts it short.

    Raises
    ------
    Cancelled
        Through `control`.
    ValueError
        There is no hypothesis, or one of less than three points.
    """
    if not hypotheses or min(len(x) for x, _ in hypotheses) < 3:
        raise ValueError("at least one hypothesis of three points is needed")
    x, y = comparison.source, comparison.target
    k = min(x.spectrum.n_eigenpairs, y.spectrum.n_eigenpairs)
    found: list[DenseMap] = []
    for index, points in enumerate(hypotheses, start=first):
        for start in _starts(x, y, points, k, effort.fits):
            control.check()
            if found and not control.seconds_left():
                return found
            found.append(extension(comparison, start, index, effort))
    return found


def extension(
    comparison: Comparison, start: FunctionalMap, hypothesis: int, effort: Effort = _CAREFUL
) -> DenseMap:
    """Refine a small functional map as far as it takes to compare it with others.

    Parameters
    ----------
    comparison
        Of the shapes.
    start
        The map.
    hypothesis
        What it came from.
    effort
        How carefully. Another step may lead elsewhere.
    """
    x, y = comparison.source, comparison.target
    most = min(_TOLD, x.spectrum.n_eigenpairs, y.spectrum.n_eigenpairs)
    sizes = [*range(start.size + effort.step, most, effort.step), most]
    functional = spectral_upsampling(start, x.embedded, y.embedded, sizes)
    return measured(comparison, functional, hypothesis)


def measured(comparison: Comparison, functional: FunctionalMap, hypothesis: int) -> DenseMap:
    """Look at what a functional map preserves.

    Parameters
    ----------
    comparison
        Of the shapes.
    functional
        The map.
    hypothesis
        What it came from.
    """
    x, y = comparison.source, comparison.target
    partners = functional.nearest(x.embedded, y.embedded)
    return DenseMap(
        functional,
        x.shape,
        y.shape,
        hypothesis,
        *comparison.differences(partners),
        comparison.orientation(partners),
    )


def completed(comparison: Comparison, chosen: DenseMap) -> DenseMap:
    """Refine a map to all eigenfunctions, fitted to more points.

    Parameters
    ----------
    comparison
        Of the shapes.
    chosen
        The map.
    """
    y = comparison.target.spectrum.eigenfunctions
    y = y[:: -(-len(y) // _MOST_POINTS)]
    return measured(
        comparison, _refined(chosen.functional_map, comparison.fitted, y), chosen.hypothesis
    )


def _refined(start: FunctionalMap, x: FloatArray, y: FloatArray) -> FunctionalMap:
    """Refine a map to all eigenfunctions, by their values at points of X and of Y."""
    k = min(x.shape[1], y.shape[1])
    sizes = [*range(start.size + _LAST_STEP, k, _LAST_STEP), k, k]
    return spectral_upsampling(start, x, y, sizes)


def _starts(
    x: Side, y: Side, points: tuple[IntArray, IntArray], k: int, fits: Sequence[int]
) -> Iterator[FunctionalMap]:
    """Small functional maps: of all points, and of the first ones with the signatures."""
    size = min(_MOST_OF_POINTS, k, max(len(points[0]) // 2, 2))
    yield functional_map_of_points(
        x.spectrum.eigenfunctions[points[0], :size], y.spectrum.eigenfunctions[points[1], :size]
    )
    first = points[0][:_LANDMARKS], points[1][:_LANDMARKS]
    for most in fits:
        size = min(most, k)
        parts = [_weighed(x.coefficients[:size], y.coefficients[:size])]
        for time in _HEAT_TIMES:
            heats = (
                x.heat_coefficients(first[0], time, size),
                y.heat_coefficients(first[1], time, size),
            )
            parts.append(_weighed(*heats))
        a, b = (np.hstack([part[side] for part in parts]) for side in range(2))
        values = x.spectrum.eigenvalues[:size], y.spectrum.eigenvalues[:size]
        yield fit_functional_map(a, b, values, _COMMUTATIVITY)


def _weighed(a: FloatArray, b: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Functions on both shapes, divided by their norm: each kind counts alike."""
    unit = 1.0 / np.sqrt((a**2).sum() + (b**2).sum())
    return unit * a, unit * b
