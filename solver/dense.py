"""From sparse correspondences to a map of all points, and to the best of several hypotheses.

Extremities decide a coarse correspondence, and of them its several hypotheses are made; but they
say little of what lies between: a torso may be turned front to back at no cost. So each
hypothesis is extended to a functional map in several ways: by what it says of all its points, or
only of its first ones, with the wave kernel signature for the rest. Each is refined by spectral
upsampling. Of those that keep orientation, which tells left from right, the ones that preserve
signatures and the lengths of short chords best are finalists; the one that preserves signatures
and small geodesic distances best is taken.
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

_FITS = ((1.0, 20), (1.0, 30), (3.0, 30), (3.0, 40))
"""Weights of the signatures against the landmarks, and numbers of eigenfunctions fitted."""

_COMMUTATIVITY = 1e-2
_START, _STEP = 20, 12
_RESTART, _SMALL_STEP = 30, 5
_MOST_POINTS = 10_000
_EXHAUSTIVE = 1_000_000_000
"""Pairs of vertices that are compared when a map is made one of vertices: some ten seconds."""

_FINALISTS = 3
_COMPARED = 64
"""Points between which finalists' geodesic distances are compared."""

_ORIENTED = 0.2
"""Orientation of maps of which it can be said at all: of right ones it is 0.5 to 0.9."""

_MUCH = 2.0
"""Maps that preserve so much less than another are not taken, however they turn the surface."""

_NEARLY = 0.7
"""Share of the clearest orientation that a map must have: a mixture of one map and its mirror image
can preserve as much."""

_NEAR = 0.05
"""Distances below count alike, in units of √area."""


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
        x = unit_spectrum(self.source).eigenfunctions[vertices]
        y = unit_spectrum(self.target).eigenfunctions[:, : self.functional_map.size]
        images = self.functional_map.images(x)
        if len(images) * len(y) <= _EXHAUSTIVE:
            return nearest_points(images, y)
        return nearly_nearest_points(images, y, 2 * int(np.sqrt(len(y))))

    @property
    def change(self) -> float:
        """How little of the shape is preserved."""
        return self.signature_change * self.chord_change

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
    return best_map(comparison, oriented_first(found), hypotheses[0][0])


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
    Five for each hypothesis, unless a deadline cuts it short.

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
            sizes = [*range(start.size + _STEP, k, _STEP), k, k]
            functional = spectral_upsampling(start, x.embedded, y.embedded, sizes)
            found.append(measured(comparison, functional, index))
    return found


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
    Those that keep orientation as clearly as any map keeps or reverses it, by `change`, without
    those that preserve far less than some other; if there are none, all, by `change` alone.
    """
    ranked = sorted(found, key=lambda one: one.change)
    sound = [one for one in ranked if one.change <= _MUCH * ranked[0].change]
    least = max(_ORIENTED, _NEARLY * max(abs(one.orientation) for one in sound))
    return [one for one in sound if turn * one.orientation >= least] or ranked


def best_map(comparison: Comparison, ranked: Sequence[DenseMap], vertices: IntArray) -> DenseMap:
    """Refine the first of some maps further, and choose.

    Parameters
    ----------
    comparison
        Of the shapes.
    ranked
        Maps, at least one, the most promising ones first.
    vertices
        (n,) of X, farthest first: among the first of them geodesic distances are compared.
    """
    finalists = [_completed(comparison, one) for one in ranked[:_FINALISTS]]
    if len(finalists) == 1:
        return finalists[0]
    compared = vertices[:_COMPARED]
    shape = comparison.source.shape
    before = shape.metric("geodesic").between(compared) / shape.size
    return min(finalists, key=lambda one: one.signature_change * _stress(one, compared, before))


def _completed(comparison: Comparison, chosen: DenseMap) -> DenseMap:
    """Refine a map again, in small steps and with more points of the target."""
    x, y = comparison.source, comparison.target
    everywhere = y.spectrum.eigenfunctions
    if len(everywhere) > _MOST_POINTS:
        everywhere = everywhere[:: -(-len(everywhere) // _MOST_POINTS)]
    matrix = chosen.functional_map.matrix
    k, size = len(matrix), min(_RESTART, len(matrix))
    start = FunctionalMap(matrix[:size, :size])
    sizes = [*range(size + _SMALL_STEP, k, _SMALL_STEP), k]
    functional = spectral_upsampling(start, x.embedded, everywhere, sizes)
    return measured(comparison, functional, chosen.hypothesis)


def _stress(dense: DenseMap, vertices: IntArray, before: FloatArray) -> float:
    """Root mean square change of geodesic distances, each weighed by its inverse square.

    They are (n, n) `before` among the (n,) vertices, over √area.
    """
    target = dense.target
    images = dense.images(vertices)
    after = target.metric("geodesic").between(images) / target.size
    weights = np.maximum(before, _NEAR) ** -2.0
    return float(np.sqrt((weights * (before - after) ** 2).sum() / weights.sum()))


def _starts(x: Side, y: Side, points: tuple[IntArray, IntArray], k: int) -> Iterator[FunctionalMap]:
    """Small functional maps: of all points, and of the first ones with the signatures."""
    size = min(_START, k, max(len(points[0]) // 2, 2))
    yield functional_map_of_points(
        x.spectrum.eigenfunctions[points[0], :size], y.spectrum.eigenfunctions[points[1], :size]
    )
    first = points[0][:_LANDMARKS], points[1][:_LANDMARKS]
    for weight, most in _FITS:
        size = min(most, k)
        parts = [_weighed(x.coefficients[:size], y.coefficients[:size], weight)]
        for time in _HEAT_TIMES:
            heats = (
                x.heat_coefficients(first[0], time, size),
                y.heat_coefficients(first[1], time, size),
            )
            parts.append(_weighed(*heats, 1.0))
        a, b = (np.hstack([part[side] for part in parts]) for side in range(2))
        values = x.spectrum.eigenvalues[:size], y.spectrum.eigenvalues[:size]
        yield fit_functional_map(a, b, values, _COMMUTATIVITY)


def _weighed(a: FloatArray, b: FloatArray, weight: float) -> tuple[FloatArray, FloatArray]:
    """Functions on both shapes, divided by their norm: each kind counts by its weight alone."""
    unit = weight / np.sqrt((a**2).sum() + (b**2).sum())
    return unit * a, unit * b
