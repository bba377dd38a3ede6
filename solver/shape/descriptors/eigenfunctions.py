"""Values of Laplace-Beltrami eigenfunctions (Hu and Hua 2009; Dubrovina and Kimmel 2010).

An eigenfunction's sign is arbitrary; those of a repeated eigenvalue are any basis of their space;
and where eigenvalues are near one another, those of nearly isometric shapes trade places and mix.
What does not depend on any of this is the norm of a group of eigenfunctions whose eigenvalues are
apart from all others: the root of the sum of their squares. An eigenfunction that is a group of its
own can keep its sign if the distribution of its values tells which one it is.

Where to cut depends on both shapes (:func:`aligned_eigenfunctions`). For a shape by itself, sums of
squares from the first eigenfunction on are nearly as good: only the last ones of a sum can be those
of another shape's next (:func:`eigenfunction_magnitudes`).
"""

from collections.abc import Iterator, Sequence

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.errors import OptionError
from solver.shape.laplacian import Spectrum

DEFAULT_COUNT = 20
"""Eigenfunctions looked at. The share of gaps among further eigenvalues is small."""

_GAP = 0.15
"""Least gap between groups, relative to the eigenvalue below. Between poses of the same animal most
eigenvalues move by less."""

_EQUAL = 0.01
"""Relative difference of eigenvalues that may as well be equal."""

_CERTAINTY = 3.0
"""How many times farther the distribution of the wrong sign must be than that of the right one."""

_SKEWNESS = 0.1
"""How far that must be at least, of a function with root mean square 1."""

_QUANTILES = (np.arange(64) + 0.5) / 64


def eigenfunction_groups(spectra: Sequence[Spectrum], count: int = DEFAULT_COUNT) -> IntArray:
    """Cut the eigenfunctions that are not constant into groups, alike for all the shapes.

    A cut is made where, in every spectrum, an eigenvalue exceeds the one before by 15 % or more.
    Eigenfunctions after the last cut are left out: they may belong with the next ones.

    Parameters
    ----------
    spectra
        Of one shape or more.
    count
        Number of eigenfunctions to look at, at least 1.

    Returns
    -------
    (m + 1,) bounds: group j has the eigenfunctions ``bounds[j]`` to ``bounds[j + 1] - 1``, the
    first being number 1. One group of all, if they cannot be cut.

    Raises
    ------
    OptionError
        `count` is less than 1.
    ValueError
        A spectrum has no eigenfunction but the constant one.
    """
    _check(count, *spectra)
    least = min(spectrum.n_eigenpairs for spectrum in spectra)
    values = np.stack([spectrum.eigenvalues[1:least] for spectrum in spectra])
    apart = (values[:, 1:] >= (1.0 + _GAP) * values[:, :-1]).all(axis=0)
    cuts = np.flatnonzero(apart) + 2
    cuts = cuts[cuts <= count + 1]
    if not len(cuts):
        cuts = np.array([min(count + 1, least)])
    return np.concatenate([[1], cuts]).astype(np.int64)


def eigenfunction_magnitudes(
    spectrum: Spectrum, count: int = DEFAULT_COUNT, vertices: IntArray | None = None
) -> FloatArray:
    """Magnitudes of the first eigenfunctions, comparable between any two shapes.

    Component j at vertex x is √(A Σ_i φ_i(x)² / j m), over the first j of m eigenfunctions that
    are not constant, those of nearly equal eigenvalues (1 %) replaced by their root mean square:
    without the factor 1/√m, every component has root mean square 1 over the surface.

    Parameters
    ----------
    spectrum
        Of the shape.
    count
        Number m of eigenfunctions; where the spectrum ends before, the last sum is repeated.
    vertices
        (S,) where it is wanted; by default at all V vertices.

    Returns
    -------
    (S, count) float64, without unit. It does not change with scale.

    Raises
    ------
    OptionError
        `count` is less than 1.
    ValueError
        The spectrum has no eigenfunction but the constant one.
    """
    _check(count, spectrum)
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
    count: int = DEFAULT_COUNT,
    source_vertices: IntArray | None = None,
    target_vertices: IntArray | None = None,
) -> tuple[FloatArray, FloatArray]:
    """Eigenfunctions of two shapes, with signs and order made comparable.

    Both shapes have their groups in common, which leaves order and basis without effect. Groups
    are compared by the root mean square of their eigenfunctions; but an eigenfunction that is a
    group of its own keeps its values if the distributions of these (over the area) tell its sign:
    the wrong one has to be three times farther from the other shape's than the right one, and at
    least 0.1, in the L2 Wasserstein distance. Eigenfunctions that change sign under an intrinsic
    symmetry never do, and are compared by magnitude.

    Parameters
    ----------
    source, target
        Spectra of the shapes.
    count
        Number of eigenfunctions to look at.
    source_vertices, target_vertices
        (S,) and (T,) where they are wanted; by default at all vertices.

    Returns
    -------
    source : (S, m) float64, without unit.
    target : (T, m), in the same order and with the same signs. They do not change with scale.

    Raises
    ------
    OptionError
        `count` is less than 1.
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
            function = spectrum.eigenfunctions[:, number]
            function = function if vertices is None else function[vertices]
            values[:, group] = factor * np.sqrt(spectrum.area / m) * function
    return source_values, target_values


def _check(count: int, *spectra: Spectrum) -> None:
    if count < 1:
        raise OptionError("count", "at least 1 is needed")
    if min(spectrum.n_eigenpairs for spectrum in spectra) < 2:
        raise ValueError("at least 2 eigenpairs are needed")


def _mean_squares(spectrum: Spectrum, groups: IntArray, vertices: IntArray | None) -> FloatArray:
    """(S, m) means of φ_i(x)² over the eigenfunctions of each group."""
    functions = spectrum.eigenfunctions
    squares = (functions if vertices is None else functions[vertices])[:, : groups[-1]] ** 2
    means: FloatArray = np.add.reduceat(squares, groups[:-1], axis=1) / np.diff(groups)
    return means


def _signed(
    source: Spectrum, target: Spectrum, groups: IntArray
) -> Iterator[tuple[int, int, float]]:
    """Groups of one eigenfunction with a sign, their eigenfunctions, and the sign of the source."""
    for group in np.flatnonzero(np.diff(groups) == 1):
        number = int(groups[group])
        goal = _quantiles(target, number)
        same = _quantiles(source, number)
        opposite = -same[::-1]
        near, far = (float(np.sqrt(np.mean((x - goal) ** 2))) for x in (same, opposite))
        if max(near, far) >= max(_CERTAINTY * min(near, far), _SKEWNESS):
            yield int(group), number, 1.0 if near <= far else -1.0


def _quantiles(spectrum: Spectrum, number: int) -> FloatArray:
    """Quantiles, by area, of an eigenfunction's values on a surface of unit area."""
    function = spectrum.eigenfunctions[:, number]
    order = np.argsort(function, kind="stable")
    mass = spectrum.mass[order]
    level = (np.cumsum(mass) - 0.5 * mass) / spectrum.area
    quantiles: FloatArray = np.interp(_QUANTILES, level, function[order]) * np.sqrt(spectrum.area)
    return quantiles
