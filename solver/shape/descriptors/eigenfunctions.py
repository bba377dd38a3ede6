"""Laplace-Beltrami eigenfunctions as a descriptor, section 3.5 and Table 1.

Hu and Hua, "Salient spectral geometric features for shape matching and retrieval", Visual Computer
25, 2009; Dubrovina and Kimmel, "Matching shapes by eigendecomposition of the Laplace-Beltrami
operator", 3DPVT 2010.

An eigenfunction's sign is arbitrary; those of a repeated eigenvalue are an arbitrary basis of their
eigenspace; and where eigenvalues are close, eigenfunctions of nearly isometric shapes switch and
mix. The norm of a group of eigenfunctions, the root of the sum of their squares, depends on none of
this if their eigenvalues are apart from all others. A single eigenfunction in a group keeps its
sign if the distribution of its values determines it.

The groups depend on both shapes (:func:`aligned_eigenfunctions`). A shape by itself is described by
sums of squares from the first eigenfunction on: only the last terms of a sum can be mixed with
those after it (:func:`eigenfunction_magnitudes`).
"""

from collections.abc import Iterator, Sequence

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.shape.laplacian import Spectrum

_GAP = 0.15
"""Least relative gap of eigenvalues between groups: between poses of the same animal most
eigenvalues change by less."""

_EQUAL = 0.01
"""Relative difference of eigenvalues that are treated as equal."""

_DISTANCE_RATIO = 3.0
"""Least ratio of the distances of the distributions with the wrong and the right sign."""

_LEAST_DISTANCE = 0.1
"""Least distance of the distribution with the wrong sign, of a function with root mean square 1."""

_QUANTILES = (np.arange(64) + 0.5) / 64
"""Levels at which distributions are compared."""


def eigenfunction_groups(spectra: Sequence[Spectrum], count: int) -> IntArray:
    """Partition the nonconstant eigenfunctions into groups that several shapes have in common.

    Groups are separated where an eigenvalue exceeds the one before by `_GAP` in every spectrum.
    Eigenfunctions after the last gap are left out: they may belong to the next group.

    Parameters
    ----------
    spectra
        Spectra of at least one shape.
    count
        Number of eigenfunctions considered, at least 1.

    Returns
    -------
    (m + 1,) int64 bounds: group j has the eigenfunctions ``bounds[j]`` to ``bounds[j + 1] - 1``,
    the first being number 1. One group of all if there is no gap.

    Raises
    ------
    ValueError
        A spectrum has only the constant eigenfunction.
    """
    _check(*spectra)
    least = min(spectrum.n_eigenpairs for spectrum in spectra)
    values = np.stack([spectrum.eigenvalues[1:least] for spectrum in spectra])
    is_gap = (values[:, 1:] >= (1.0 + _GAP) * values[:, :-1]).all(axis=0)
    ends = np.flatnonzero(is_gap) + 2
    ends = ends[ends <= count + 1]
    if not len(ends):
        ends = np.array([min(count + 1, least)])
    return np.concatenate([[1], ends]).astype(np.int64)


def eigenfunction_magnitudes(spectrum: Spectrum, count: int, vertices: IntArray) -> FloatArray:
    """Magnitudes of the first eigenfunctions, comparable between any two shapes.

    Component j at vertex x is √(A Σ_i φ_i(x)² / j m), over the first j of m nonconstant
    eigenfunctions, those of nearly equal eigenvalues (`_EQUAL`) replaced by their root mean square.
    Times √m, every component has root mean square 1 over the surface.

    Parameters
    ----------
    spectrum
        Spectrum of the shape.
    count
        Number m of eigenfunctions, at least 1; if the spectrum has fewer, the last sum is repeated.
    vertices
        (S,) int64 vertices.

    Returns
    -------
    (S, m) float64, without unit, invariant to scale.

    Raises
    ------
    ValueError
        The spectrum has only the constant eigenfunction.
    """
    _check(spectrum)
    values = spectrum.eigenvalues[1:]
    ends = np.flatnonzero(values[1:] > (1.0 + _EQUAL) * values[:-1]) + 2
    groups = np.concatenate([[1], ends, [spectrum.n_eigenpairs]])
    squares = np.repeat(_mean_squares(spectrum, groups, vertices), np.diff(groups), axis=1)
    known = min(count, squares.shape[1])
    means = np.cumsum(squares[:, :known], axis=1) / np.arange(1, known + 1)
    means = np.pad(means, ((0, 0), (0, count - known)), mode="edge")
    magnitudes: FloatArray = np.sqrt(means * (spectrum.area / count))
    return magnitudes


def aligned_eigenfunctions(
    source: Spectrum,
    target: Spectrum,
    count: int,
    source_vertices: IntArray,
    target_vertices: IntArray,
) -> tuple[FloatArray, FloatArray]:
    """Eigenfunctions of two shapes, with signs and order made comparable.

    The shapes share their groups, so that order and basis have no effect. A group is described by
    the root mean square of its eigenfunctions. A single eigenfunction in a group keeps its values
    if their distributions over the area determine the sign: with the wrong sign, its L2 Wasserstein
    distance to the other shape's must be `_DISTANCE_RATIO` times that with the right one, and at
    least `_LEAST_DISTANCE`. Eigenfunctions that are odd under an intrinsic symmetry never satisfy
    this, and are compared by magnitude.

    Parameters
    ----------
    source, target
        Spectra of the shapes.
    count
        Number of eigenfunctions considered, at least 1.
    source_vertices, target_vertices
        (S,) and (T,) int64 vertices.

    Returns
    -------
    source : (S, m) float64, without unit, invariant to scale.
    target : (T, m) float64, in the same order and with the same signs.

    Raises
    ------
    ValueError
        A spectrum has only the constant eigenfunction.
    """
    groups = eigenfunction_groups([source, target], count)
    m = len(groups) - 1
    source_values, target_values = (
        np.sqrt(_mean_squares(spectrum, groups, vertices) * (spectrum.area / m))
        for spectrum, vertices in ((source, source_vertices), (target, target_vertices))
    )
    for group, number, sign in _signed(source, target, groups):
        for values, spectrum, vertices, factor in (
            (source_values, source, source_vertices, sign),
            (target_values, target, target_vertices, 1.0),
        ):
            function = spectrum.eigenfunctions[vertices, number]
            values[:, group] = factor * np.sqrt(spectrum.area / m) * function
    return source_values, target_values


def _check(*spectra: Spectrum) -> None:
    if min(spectrum.n_eigenpairs for spectrum in spectra) < 2:
        raise ValueError("at least 2 eigenpairs are needed")


def _mean_squares(spectrum: Spectrum, groups: IntArray, vertices: IntArray) -> FloatArray:
    """(S, m) means of φ_i(x)² over the eigenfunctions of each group."""
    squares = spectrum.eigenfunctions[vertices, : groups[-1]] ** 2
    means: FloatArray = np.add.reduceat(squares, groups[:-1], axis=1) / np.diff(groups)
    return means


def _signed(
    source: Spectrum, target: Spectrum, groups: IntArray
) -> Iterator[tuple[int, int, float]]:
    """Yield groups of one eigenfunction with determined sign: group, number, sign of the source."""
    for group in np.flatnonzero(np.diff(groups) == 1):
        number = int(groups[group])
        goal = _quantiles(target, number)
        kept = _quantiles(source, number)
        flipped = -kept[::-1]
        plus, minus = (float(np.sqrt(np.mean((x - goal) ** 2))) for x in (kept, flipped))
        if max(plus, minus) >= max(_DISTANCE_RATIO * min(plus, minus), _LEAST_DISTANCE):
            yield int(group), number, 1.0 if plus <= minus else -1.0


def _quantiles(spectrum: Spectrum, number: int) -> FloatArray:
    """(64,) quantiles by area of an eigenfunction's values on a surface of unit area."""
    function = spectrum.eigenfunctions[:, number]
    order = np.argsort(function, kind="stable")
    mass = spectrum.mass[order]
    level = (np.cumsum(mass) - 0.5 * mass) / spectrum.area
    quantiles: FloatArray = np.interp(_QUANTILES, level, function[order]) * np.sqrt(spectrum.area)
    return quantiles
