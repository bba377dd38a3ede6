"""Extension of sparse correspondences to maps of all points, by functional maps.

A coarse correspondence and its alternatives are decided at extremities and say little of what lies
between: a torso may be turned front to back at no cost. So each hypothesis is extended to small
functional maps, fitted to its first points and to wave kernel signatures. Each is refined by
ZoomOut until the maps can be ranked (:mod:`.dense_map`); the best is refined to all eigenfunctions.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.control import Control
from solver.functional_maps.dense_map import DenseMap
from solver.functional_maps.functional_map import (
    FunctionalMap,
    fit_functional_map,
    fit_orthonormal_map,
)
from solver.functional_maps.map_quality import ComparedShape, Comparison
from solver.functional_maps.zoomout import zoomout

# The constants are chosen on generated people and animals; `bench.dense` measures them.

_FIRST_POINTS = 8
"""Points of a hypothesis that heat kernels are fitted at: the first ones are the surest."""

_HEAT_TIMES = 0.003, 0.01, 0.03
"""Diffusion times, on unit area, of the heat kernels at these points."""

_COMMUTATIVITY = 1e-2
"""w of :func:`.fit_functional_map`."""

_MAX_POINT_MAP_SIZE = 20
"""Greatest number of eigenfunctions of a map that is fitted to points alone."""

_RANKING_SIZE = 54
"""Eigenfunctions of maps that are ranked: maps that are wrong then stay wrong."""

_FINAL_STEP = 12
"""Eigenfunctions added at a time when the chosen map is refined to all."""

_MAX_TARGET_POINTS = 10_000
"""Points of Y, nearly, that the chosen map is refined by."""


@dataclass(frozen=True)
class Effort:
    """Number of starts and steps of an extension.

    Parameters
    ----------
    fits
        Numbers of eigenfunctions of the maps that are fitted to first points and signatures.
    step
        Eigenfunctions added at a time by ZoomOut.
    """

    fits: tuple[int, ...] = (20, 30)
    step: int = 6


QUICK = Effort(fits=(30,), step=12)
"""Sufficient where the answer is clear, in less than half the time."""

_CAREFUL = Effort()


def extend_hypotheses(
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
    hypotheses
        (n,) vertices of X and (n,) vertices of Y that correspond, farthest first.
    control
        May cancel; past its deadline, no further starts are tried.
    first
        Number of the first hypothesis.
    effort
        Starts and steps.

    Returns
    -------
    Maps in few eigenfunctions: one for each hypothesis and one for each of the effort's fits to it,
    unless a deadline cuts it short; at least one.

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
    starts = (
        (index, start)
        for index, points in enumerate(hypotheses, start=first)
        for start in _starts(x, y, points, k, effort.fits)
    )
    return [
        extend_map(comparison, start, index, effort)
        for index, start in control.in_time(starts, least=1)
    ]


def extend_map(
    comparison: Comparison, start: FunctionalMap, hypothesis: int, effort: Effort = _CAREFUL
) -> DenseMap:
    """Refine a small functional map until it can be ranked among others.

    Parameters
    ----------
    comparison
        Of the shapes.
    start
        The map.
    hypothesis
        Index of the hypothesis that it was fitted to.
    effort
        Steps; another step may lead to another map.
    """
    x, y = comparison.source, comparison.target
    most = min(_RANKING_SIZE, x.spectrum.n_eigenpairs, y.spectrum.n_eigenpairs)
    sizes = [*range(start.size + effort.step, most, effort.step), most]
    functional = zoomout(start, x.embedded, y.embedded, sizes)
    return measure_map(comparison, functional, hypothesis)


def measure_map(comparison: Comparison, functional: FunctionalMap, hypothesis: int) -> DenseMap:
    """Measure the quality of a functional map.

    Parameters
    ----------
    comparison
        Of the shapes.
    functional
        The map.
    hypothesis
        Index of the hypothesis that it was fitted to.
    """
    x, y = comparison.source, comparison.target
    partners = functional.nearest(x.embedded, y.embedded)
    return DenseMap(
        functional,
        x.shape,
        y.shape,
        hypothesis,
        *comparison.differences(partners),
        comparison.orientation_score(partners),
    )


def complete_map(comparison: Comparison, chosen: DenseMap) -> DenseMap:
    """Refine a map to all eigenfunctions, fitted to more points.

    Parameters
    ----------
    comparison
        Of the shapes.
    chosen
        The map.
    """
    y = comparison.target.spectrum.eigenfunctions
    y = y[:: -(-len(y) // _MAX_TARGET_POINTS)]
    x, start = comparison.fitted, chosen.functional_map
    k = min(x.shape[1], y.shape[1])
    sizes = [*range(start.size + _FINAL_STEP, k, _FINAL_STEP), k, k]
    return measure_map(comparison, zoomout(start, x, y, sizes), chosen.hypothesis)


def _starts(
    x: ComparedShape,
    y: ComparedShape,
    points: tuple[IntArray, IntArray],
    k: int,
    fits: Sequence[int],
) -> Iterator[FunctionalMap]:
    """Fit small functional maps to all points, and to the first ones with the signatures."""
    size = min(_MAX_POINT_MAP_SIZE, k, max(len(points[0]) // 2, 2))
    yield fit_orthonormal_map(
        x.spectrum.eigenfunctions[points[0], :size], y.spectrum.eigenfunctions[points[1], :size]
    )
    first = points[0][:_FIRST_POINTS], points[1][:_FIRST_POINTS]
    for most in fits:
        size = min(most, k)
        parts = [_normalise(x.coefficients[:size], y.coefficients[:size])]
        for time in _HEAT_TIMES:
            heats = (
                x.heat_coefficients(first[0], time, size),
                y.heat_coefficients(first[1], time, size),
            )
            parts.append(_normalise(*heats))
        a, b = (np.hstack([part[side] for part in parts]) for side in range(2))
        values = x.spectrum.eigenvalues[:size], y.spectrum.eigenvalues[:size]
        yield fit_functional_map(a, b, values, _COMMUTATIVITY)


def _normalise(a: FloatArray, b: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Divide functions on both shapes by their common norm, so that each kind counts alike."""
    unit = 1.0 / np.sqrt((a**2).sum() + (b**2).sum())
    return unit * a, unit * b
