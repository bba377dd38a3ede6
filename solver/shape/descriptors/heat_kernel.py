"""Heat kernel signatures, sections 3.6 and 3.7."""

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.shape.laplacian import Spectrum

_OCTAVES = (-8, 2)
"""log₂(t/A) of the first and the last time scale of the scale-invariant signature: from where the
hundredth term of the heat kernel is below a percent, by Weyl's law, to where it is constant."""

_STEPS_PER_OCTAVE = 8
"""Time scales per octave of the scale-invariant signature, half of those of Bronstein and Kokkinos
(2010)."""


def heat_kernel_signature(spectrum: Spectrum, times: FloatArray, vertices: IntArray) -> FloatArray:
    """Heat kernel signature, section 3.6, relative to its mean over the shape.

    Sun, Ovsjanikov and Guibas, "A concise and provably informative multi-scale signature based on
    heat diffusion", SGP 2009. Component j at vertex x is h_{t_j}(x, x) A / Z(t_j) / √m, with h of
    equation (2), A the area and Z(t) = Σ_i exp(-λ_i t) the heat trace, the integral of
    h_t(x, x). Times √m, every component has mean 1 over the surface.

    Parameters
    ----------
    spectrum
        Spectrum of the shape.
    times
        (m,) time scales t_j > 0 in the spectrum's unit of area.
    vertices
        (S,) int64 vertices.

    Returns
    -------
    (S, m) float64, without unit. It is invariant to scale only if the times scale with the area.
    """
    trace = np.exp(-np.outer(spectrum.eigenvalues, times)).sum(axis=0)
    signature: FloatArray = _heat_kernel_diagonal(spectrum, times, vertices) * (
        spectrum.area / trace / np.sqrt(len(times))
    )
    return signature


def scale_invariant_heat_kernel_signature(
    spectrum: Spectrum, frequencies: int, vertices: IntArray
) -> FloatArray:
    """Scale-invariant heat kernel signature, section 3.7.

    Bronstein and Kokkinos, "Scale-invariant heat kernel signatures for non-rigid shape
    recognition", CVPR 2010. log h_t(x, x) is sampled at t = A 2^τ, A the area, and differentiated
    with respect to τ; the magnitudes of the lowest frequencies of its Fourier transform over τ are
    kept. They are divided by the decay of log Z(t) over the same times, Z the heat trace, and by
    the root of their number.

    Scaling the shape by s turns h_t into h_{t/s²} / s². The derivative removes the factor. The
    shift of τ is removed by times in units of the shape's own area, which makes the signature
    exactly invariant; the magnitudes alone would leave what is shifted beyond the ends of the
    range. They remove the shift that remains if parts of a shape are missing, so that its area is
    not that of its counterpart.

    Parameters
    ----------
    spectrum
        Spectrum of the shape.
    frequencies
        Number of lowest frequencies, the zeroth included.
    vertices
        (S,) int64 vertices.

    Returns
    -------
    (S, frequencies) float64, without unit.
    """
    first, last = _OCTAVES
    count = (last - first) * _STEPS_PER_OCTAVE + 1
    times = spectrum.area * np.exp2(np.linspace(first, last, count))
    slope = np.diff(np.log(_heat_kernel_diagonal(spectrum, times, vertices)), axis=1)
    magnitudes = np.abs(np.fft.rfft(slope, axis=1)[:, :frequencies])
    trace = np.exp(-np.outer(spectrum.eigenvalues, times[[0, -1]])).sum(axis=0)
    decay = np.log(trace[0] / trace[1])
    signature: FloatArray = magnitudes / (decay * np.sqrt(frequencies))
    return signature


def _heat_kernel_diagonal(spectrum: Spectrum, times: FloatArray, vertices: IntArray) -> FloatArray:
    """h_t(x, x) of equation (2): (S, m) at (S,) vertices for (m,) times."""
    decay = np.exp(-np.outer(spectrum.eigenvalues, times))
    diagonal: FloatArray = spectrum.eigenfunctions[vertices] ** 2 @ decay
    return diagonal
