"""From sparse correspondences to a map of all points, and to the best of several hypotheses.

Extremities decide a coarse correspondence, and of them its several hypotheses are made; but they
say little of what lies between: a torso may be turned front to back at no cost. So each
hypothesis is extended to a functional map in several ways: by what it says of all its points, or
only of its first ones, with the wave kernel signature for the rest. Each is refined by spectral
upsampling. Those that preserve signatures and the lengths of short chords best are finalists; the
one that preserves signatures and small geodesic distances best is taken.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial import KDTree

from solver.arrays import FloatArray, IntArray
from solver.control import Control
from solver.descriptors import wave_kernel_signature
from solver.functional_map import (
    FunctionalMap,
    fit_functional_map,
    functional_map_of_points,
    spectral_upsampling,
)
from solver.metrics import EmbeddedMetric
from solver.nearest import nearest_points, nearly_nearest_points
from solver.sampling import farthest_point_sampling
from solver.shape import Shape
from solver.spectrum import Spectrum

EIGENPAIRS = 100
_SAMPLES = 500, 2000
"""Points of X and of Y by which maps are refined and compared."""

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

_NEIGHBOURS = 8
_FINALISTS = 3
_COMPARED = 64
"""Points between which finalists' geodesic distances are compared."""

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
    """

    functional_map: FunctionalMap
    source: Shape
    target: Shape
    hypothesis: int

    def images(self, vertices: IntArray) -> IntArray:
        """(S,) target vertices that (S,) source vertices go to.

        Where a search among all would take long, only those around are searched.
        """
        x = _unit_spectrum(self.source).eigenfunctions[vertices]
        y = _unit_spectrum(self.target).eigenfunctions[:, : self.functional_map.size]
        images = self.functional_map.images(x)
        if len(images) * len(y) <= _EXHAUSTIVE:
            return nearest_points(images, y)
        return nearly_nearest_points(images, y, 2 * int(np.sqrt(len(y))))


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
    if not hypotheses or min(len(x) for x, _ in hypotheses) < 3:
        raise ValueError("at least one hypothesis of three points is needed")
    comparison = _Comparison(_Side.of(source, _SAMPLES[0]), _Side.of(target, _SAMPLES[1]))
    found = _refined(comparison, hypotheses, control or Control())
    found.sort(key=lambda one: one.differences[0] * one.differences[1])
    finalists = [_completed(comparison, one.map) for one in found[:_FINALISTS]]
    if len(finalists) > 1:
        vertices = hypotheses[0][0][:_COMPARED]
        finalists.sort(key=lambda one: one.differences[0] * _stress(one.map, vertices))
    return finalists[0].map


@dataclass(frozen=True, eq=False)
class _Extension:
    """A hypothesis extended: its map, and how it changes signatures and short chords."""

    map: DenseMap
    differences: tuple[float, float]


def _refined(
    comparison: "_Comparison",
    hypotheses: Sequence[tuple[IntArray, IntArray]],
    control: Control,
) -> list[_Extension]:
    x, y = comparison.source, comparison.target
    k = min(x.spectrum.n_eigenpairs, y.spectrum.n_eigenpairs)
    found: list[_Extension] = []
    for index, points in enumerate(hypotheses):
        for start in _starts(x, y, points, k):
            control.check()
            if found and not control.seconds_left():
                return found
            sizes = [*range(start.size + _STEP, k, _STEP), k, k]
            functional = spectral_upsampling(start, x.embedded, y.embedded, sizes)
            partners = functional.nearest(x.embedded, y.embedded)
            dense = DenseMap(functional, x.shape, y.shape, index)
            found.append(_Extension(dense, comparison.differences(partners)))
    return found


def _completed(comparison: "_Comparison", chosen: DenseMap) -> _Extension:
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
    differences = comparison.differences(functional.nearest(x.embedded, y.embedded))
    return _Extension(replace(chosen, functional_map=functional), differences)


def _stress(dense: DenseMap, vertices: IntArray) -> float:
    """Root mean square change of geodesic distances, each weighed by its inverse square."""
    source, target = dense.source, dense.target
    images = dense.images(vertices)
    before = source.metric("geodesic").between(vertices) / _unit(source)
    after = target.metric("geodesic").between(images) / _unit(target)
    weights = np.maximum(before, _NEAR) ** -2.0
    return float(np.sqrt((weights * (before - after) ** 2).sum() / weights.sum()))


def _unit(shape: Shape) -> float:
    """√area in the unit of a shape's surface: 1 if it is normalised."""
    return float(np.sqrt(shape.mesh.area)) / shape.unit


def _unit_spectrum(shape: Shape) -> Spectrum:
    return shape.spectrum(EIGENPAIRS).scaled(1.0 / _unit(shape))


@dataclass(frozen=True, eq=False)
class _Side:
    """A shape of unit area: its eigenfunctions, and what is compared at points spread over it."""

    shape: Shape
    spectrum: Spectrum
    signatures: FloatArray
    embedded: FloatArray
    sampled_signatures: FloatArray
    positions: FloatArray

    @classmethod
    def of(cls, shape: Shape, count: int) -> "_Side":
        spectrum = _unit_spectrum(shape)
        # In space, which is quick, and as even on the surface of a body as along it.
        in_space = EmbeddedMetric(shape.surface.vertices)
        samples = farthest_point_sampling(in_space, min(count, shape.n_vertices)).indices
        signatures = wave_kernel_signature(spectrum)
        return cls(
            shape,
            spectrum,
            signatures,
            spectrum.eigenfunctions[samples],
            signatures[samples],
            shape.surface.vertices[samples] / _unit(shape),
        )

    def coefficients(self, size: int) -> FloatArray:
        """(size, m) of the signatures, in the first eigenfunctions."""
        functions = self.spectrum.eigenfunctions[:, :size]
        return functions.T @ (self.spectrum.mass[:, None] * self.signatures)

    def heat_coefficients(self, vertices: IntArray, time: float, size: int) -> FloatArray:
        """(size, n) of the heat kernels h_t(x, ·) of (2), from some vertices x."""
        decay = np.exp(-self.spectrum.eigenvalues[:size] * time)
        coefficients: FloatArray = (self.spectrum.eigenfunctions[vertices, :size] * decay).T
        return coefficients


class _Comparison:
    """What a map does to signatures and to short chords of two shapes."""

    def __init__(self, source: _Side, target: _Side) -> None:
        self.source, self.target = source, target
        count = min(_NEIGHBOURS + 1, len(source.positions))
        near = np.asarray(KDTree(source.positions).query(source.positions, k=count)[1])[:, 1:]
        self._ends = np.repeat(np.arange(len(near)), near.shape[1]), near.ravel()

    def differences(self, partners: IntArray) -> tuple[float, float]:
        """Mean change of the signature, and root mean square change of a chord's length."""
        x, y = self.source, self.target
        signature = x.sampled_signatures - y.sampled_signatures[partners]
        chord = self._lengths(x.positions) - self._lengths(y.positions[partners])
        return (
            float(np.linalg.norm(signature, axis=1).mean()),
            float(np.sqrt((chord**2).mean())),
        )

    def _lengths(self, positions: FloatArray) -> FloatArray:
        here, there = self._ends
        lengths: FloatArray = np.linalg.norm(positions[here] - positions[there], axis=1)
        return lengths


def _starts(
    x: _Side, y: _Side, points: tuple[IntArray, IntArray], k: int
) -> Iterator[FunctionalMap]:
    """Small functional maps: of all points, and of the first ones with the signatures."""
    size = min(_START, k, max(len(points[0]) // 2, 2))
    yield functional_map_of_points(
        x.spectrum.eigenfunctions[points[0], :size], y.spectrum.eigenfunctions[points[1], :size]
    )
    first = points[0][:_LANDMARKS], points[1][:_LANDMARKS]
    for weight, most in _FITS:
        size = min(most, k)
        parts = [_weighed(x.coefficients(size), y.coefficients(size), weight)]
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
