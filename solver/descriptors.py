"""Local descriptors f_X of a shape's vertices, sections 3.6 and 3.7.

Descriptors are compared by the Euclidean norm. Each one is scaled so that it is without unit and
that the norm of a difference is a root mean square over its components.
"""

from typing import Literal, TypeAlias, get_args

import numpy as np

from solver.arrays import FloatArray
from solver.spectrum import Spectrum

DescriptorName: TypeAlias = Literal["hks", "si_hks"]
DESCRIPTORS: tuple[DescriptorName, ...] = get_args(DescriptorName)
"""Names of the descriptors."""

_TIMES = 32
_OCTAVE_STEPS = 8
_FREQUENCIES = 6


def heat_kernel_signature(spectrum: Spectrum, times: FloatArray | None = None) -> FloatArray:
    """Heat kernel signature, section 3.6, relative to its mean over the shape.

    Component j at vertex x is h_{t_j}(x, x) A / Z(t_j) / √m, with h of equation (2), A the area
    and Z(t) = Σ_i exp(-λ_i t) the heat trace, which is the integral of h_t(x, x): without the
    factor 1/√m, every component has mean 1 over the surface.

    Parameters
    ----------
    spectrum
        Of the shape.
    times
        (m,) time scales t_j > 0 in the spectrum's unit of area. By default 32, logarithmically
        spaced from 4 ln 10 / λ_k to 4 ln 10 / λ_1 (Sun, Ovsjanikov and Guibas, SGP 2009).

    Returns
    -------
    (V, m) float64, without unit.

    Raises
    ------
    ValueError
        A time is not positive.
    """
    if times is None:
        times = default_times(spectrum)
    signature = _heat_kernel_diagonal(spectrum, times)
    trace = np.exp(-np.outer(spectrum.eigenvalues, times)).sum(axis=0)
    relative: FloatArray = signature * (spectrum.area / trace / np.sqrt(len(times)))
    return relative


def default_times(spectrum: Spectrum, count: int = _TIMES) -> FloatArray:
    """Time scales between the fastest and the slowest decay that the spectrum knows.

    Parameters
    ----------
    spectrum
        Of two eigenpairs at least.
    count
        How many.

    Returns
    -------
    (count,) ascending, from 4 ln 10 / λ_k, where the k-th term of (2) has decayed to 10⁻⁴, to
    4 ln 10 / λ_1, where all but the constant have.
    """
    decayed = 4.0 * np.log(10.0)
    return np.geomspace(
        decayed / spectrum.eigenvalues[-1], decayed / spectrum.eigenvalues[1], count
    )


def scale_invariant_heat_kernel_signature(
    spectrum: Spectrum, frequencies: int = _FREQUENCIES
) -> FloatArray:
    """Scale-invariant heat kernel signature, section 3.7 (Bronstein and Kokkinos, CVPR 2010).

    log h_t(x, x) is sampled at t = A 2^τ, A the area, differentiated with respect to τ, and of
    the discrete Fourier transform of the result over τ the magnitudes of the lowest frequencies
    are kept. They are divided by the decay of log Z(t) over the same times, Z the heat trace, and
    by the root of their number.

    Scaling the shape by s turns h_t into h_{t/s²}/s²: the factor goes with the derivative, the
    shift of τ with the magnitude. Two things make that exact instead of approximate: times are in
    units of the shape's own area, and their range is wide enough for the derivative to vanish at
    both ends, where the truncated sum (2) is constant; so shifts leave the magnitudes alone even
    when the area is not that of the corresponding part.

    Parameters
    ----------
    spectrum
        Of the shape.
    frequencies
        How many of the lowest frequencies, the zeroth included.

    Returns
    -------
    (V, frequencies) float64, without unit.
    """
    times = spectrum.area * np.exp2(np.arange(-_RANGE[0], _RANGE[1] + 1e-9, 1.0 / _OCTAVE_STEPS))
    slope = np.diff(np.log(_heat_kernel_diagonal(spectrum, times)), axis=1)
    magnitudes = np.abs(np.fft.rfft(slope, axis=1)[:, :frequencies])
    trace = np.exp(-np.outer(spectrum.eigenvalues, times[[0, -1]])).sum(axis=0)
    decay = np.log(trace[0] / trace[1])
    scaled: FloatArray = magnitudes / (decay * np.sqrt(frequencies))
    return scaled


_RANGE = (16, 4)
"""Octaves of t below and above the area. With 100 eigenpairs λ A goes from about 5 to 1200."""


def _heat_kernel_diagonal(spectrum: Spectrum, times: FloatArray) -> FloatArray:
    """h_t(x, x) of (2): (V, m) for (m,) times."""
    times = np.asarray(times, dtype=np.float64)
    if not (times > 0.0).all():
        raise ValueError("times must be positive")
    diagonal: FloatArray = spectrum.eigenfunctions**2 @ np.exp(
        -np.outer(spectrum.eigenvalues, times)
    )
    return diagonal
