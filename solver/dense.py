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
from solver.comparison import Comparison, Side, unit_spectrum
from solver.control import Control
from solver.functional_map import (
    FunctionalMap,
    fit_functional_map,
    functional_map_of_points,
    spectral_upsampling,
)
from solver.nearest import nearest_points, nearly_nearest_points
from solver.shape import Shape

_LANDMARKS = 8
"""Points of a hypothesis that are trusted alone."""

_HEAT_TIMES = 0.003, 0.01, 0.03
"""Times, on unit area, of the heat kernels that stand for a landmark."""

_FITS = 20, 30
"""Numbers of eigenfunctions fitted."""

_COMMUTATIVITY = 1e-2
_MOST_OF_POINTS = 20
"""Eigenfunctions of a map that is fitted to points alone, at most."""

_STEP, _LAST_STEP = 6, 12
_TOLD = 54
"""Eigenfunctions that tell which map is best: what is wrong by then stays wrong."""

_SAME = 0.9
"""Maps that agree in as much of what they do to eigenfunctions end alike."""

_BLUR = 1e-3
"""Time, on unit area, after which heat kernels are compared: the highest eigenfunctions, of which a
map is least certain, count less."""

_MOST_POINTS = 10_000
_EXHAUSTIVE = 1_000_000_000
"""Pairs of vertices that are compared when a map is made one of vertices: some ten seconds."""

_ORIENTED = 0.2
"""Orientation of maps of which it can be said at all: of right ones it is 0.5 to 0.9."""

_UNORIENTED = 0.05
"""Of maps that have less, orientation says nothing."""

_MUCH = 2.0
"""Maps that preserve so much less than another are not taken, however they turn the surface."""

_NEARLY = 0.7
"""Share of the clearest orientation that a map must have: a mixture of one map and its mirror image
can preserve as much."""


@dataclass(frozen=True, eq=False)
class DenseMap:
    """A map from all points of X to points of Y.

    Parameters
    ----------
    functional_map
        In the first eigenfunctions of both.
    source, target
        The shapes.
    hypothesis
        Index of the sparse correspondence that it came from.
    signature_change, chord_change
        How it changes signatures on average, and lengths of short chords (root mean square).
    orientation
        From -1 to 1, near 1 if it keeps orientation; see :meth:`Comparison.orientation`.
    """

    functional_map: FunctionalMap
    source: Shape
    target: Shape
    hypothesis: int
    signature_change: float
    chord_change: float
    orientation: float

    def images(self, vertices: IntArray) -> IntArray:
        """(S,) target vertices that (S,) source vertices go to.

        Where a search among all would take long, only those around are searched.
        """
        spectrum, size = unit_spectrum(self.target), self.functional_map.size
        decay = np.exp(-_BLUR * spectrum.eigenvalues[:size])
        y = spectrum.eigenfunctions[:, :size] * decay
        x = unit_spectrum(self.source).eigenfunctions[vertices]
        images = self.functional_map.images(x) * decay
        if len(images) * len(y) <= _EXHAUSTIVE:
            return nearest_points(images, y)
        return nearly_nearest_points(images, y, 2 * int(np.sqrt(len(y))))

    @property
    def change(self) -> float:
        """How little of the shape is preserved."""
        return self.signature_change * self.chord_change

    @property
    def doubt(self) -> float:
        """How little is preserved, and how little clear it is whether orientation is.

        Parts of a map that are mirrored where others are not preserve nearly as much as the whole,
        but orientation only in part.
        """
        return self.change / max(abs(self.orientation), _UNORIENTED)

    @property
    def keeps(self) -> bool:
        """Whether it clearly keeps orientation."""
        return self.orientation > _ORIENTED

    @property
    def reverses(self) -> bool:
        """Whether it clearly reverses orientation."""
        return self.orientation < -_ORIENTED


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

    Returns
    -------
    Three for each hypothesis, of few eigenfunctions, unless a deadline cuts it short.

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
        for start in _starts(x, y, points, k):
            control.check()
            if found and not control.seconds_left():
                return found
            found.append(extension(comparison, start, index))
    return found


def extension(
    comparison: Comparison, start: FunctionalMap, hypothesis: int, step: int = _STEP
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
    step
        By how many eigenfunctions it grows at a time. Another number may lead elsewhere.
    """
    x, y = comparison.source, comparison.target
    most = min(_TOLD, x.spectrum.n_eigenpairs, y.spectrum.n_eigenpairs)
    sizes = [*range(start.size + step, most, step), most]
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


def oriented_first(found: Sequence[DenseMap], turn: int = 1) -> list[DenseMap]:
    """Put maps in order by what they preserve, and those that keep orientation alone, if they can.

    Parameters
    ----------
    found
        Maps between the same shapes.
    turn
        -1 for those that reverse orientation instead.

    Returns
    -------
    Those that keep orientation as clearly as any map keeps or reverses it, by `doubt`, without
    those that preserve far less than some other; if there are none, all, by `doubt` alone.
    """
    ranked = sorted(found, key=lambda one: one.doubt)
    most = _MUCH * min(one.change for one in found)
    sound = [one for one in ranked if one.change <= most]
    least = max(_ORIENTED, _NEARLY * max(abs(one.orientation) for one in sound))
    return [one for one in sound if turn * one.orientation >= least] or ranked


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


def first_of_each(ranked: Sequence[DenseMap], most: int) -> list[DenseMap]:
    """Leave out maps that agree with one before.

    Parameters
    ----------
    ranked
        Maps between the same shapes.
    most
        How many are wanted.
    """
    chosen: list[DenseMap] = []
    for one in ranked:
        matrix = one.functional_map.matrix
        if all(
            (matrix * other.functional_map.matrix).sum() < _SAME * len(matrix) for other in chosen
        ):
            chosen.append(one)
        if len(chosen) == most:
            break
    return chosen


def _refined(start: FunctionalMap, x: FloatArray, y: FloatArray) -> FunctionalMap:
    """Refine a map to all eigenfunctions, by their values at points of X and of Y."""
    k = min(x.shape[1], y.shape[1])
    sizes = [*range(start.size + _LAST_STEP, k, _LAST_STEP), k, k]
    return spectral_upsampling(start, x, y, sizes)


def _starts(x: Side, y: Side, points: tuple[IntArray, IntArray], k: int) -> Iterator[FunctionalMap]:
    """Small functional maps: of all points, and of the first ones with the signatures."""
    size = min(_MOST_OF_POINTS, k, max(len(points[0]) // 2, 2))
    yield functional_map_of_points(
        x.spectrum.eigenfunctions[points[0], :size], y.spectrum.eigenfunctions[points[1], :size]
    )
    first = points[0][:_LANDMARKS], points[1][:_LANDMARKS]
    for most in _FITS:
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
