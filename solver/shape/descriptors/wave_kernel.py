"""Wave kernel signature.

Aubry, Schlickewei and Cremers, "The wave kernel signature: a quantum mechanical approach to shape
analysis", ICCV workshops 2011.
"""

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.shape.laplacian import Spectrum

_ENERGIES = 32
"""Number of energies."""

_RANGE = 0.5, 0.75
"""Range of i in the energies log(4πi/A): from 0.5, about the first eigenvalue of elongated
bodies, to 0.75 k, where k eigenpairs still fill the filters."""

_ZERO = 1e-9
"""Greatest eigenvalue, on a surface of unit area, that counts as zero."""


def wave_kernel_signature(spectrum: Spectrum, sigma: float, vertices: IntArray) -> FloatArray:
    """Wave kernel signature: probabilities of finding quantum particles of given energies.

    Component j at vertex x is A C_j Σ_i φ_i(x)² exp(-(e_j - log λ_i)² / 2σ²) / √m, over the
    nonzero eigenvalues, with A the area and 1/C_j the sum of the exponentials. Times √m, every
    component has mean 1 over the surface. The m = `_ENERGIES` energies e_j are evenly spaced over
    the logarithms of the first three quarters of the eigenvalues of any surface of this area, by
    Weyl's law λ_i ≈ 4πi/A. (Aubry et al. space them over the shape's own eigenvalues; all of these
    energies shift when a change of topology shifts the first eigenvalue.)

    Parameters
    ----------
    spectrum
        Spectrum of the shape with at least 2 eigenpairs.
    sigma
        σ > 0, width of the filters, in logarithms of eigenvalues.
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
    positive = spectrum.eigenvalues * spectrum.area > _ZERO
    if not positive.any():
        raise ValueError("at least 2 eigenpairs are needed")
    logs = np.log(spectrum.eigenvalues[positive])
    last = max(_RANGE[1] * len(logs), _RANGE[0])
    counts = np.geomspace(_RANGE[0], last, _ENERGIES)
    energies = np.log(4.0 * np.pi / spectrum.area * counts)
    exponents = -0.5 * ((energies - logs[:, None]) / sigma) ** 2
    # Relative to the greatest, so that filters between eigenvalues do not underflow to 0/0.
    filters = np.exp(exponents - exponents.max(axis=0))
    filters /= filters.sum(axis=0)
    squares = spectrum.eigenfunctions[vertices][:, positive] ** 2
    signature: FloatArray = squares @ filters * (spectrum.area / np.sqrt(_ENERGIES))
    return signature
