"""Wave kernel signatures (Aubry, Schlickewei and Cremers, ICCV workshops 2011)."""

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.shape.laplacian import Spectrum

_ENERGIES = 32
_SIGMA = 0.2
_RANGE = 0.5, 0.75
"""Default energies, log(4πi/A), begin at i = 0.5, about the first eigenvalue of elongated bodies,
and end at i = 0.75 k, where k eigenpairs still fill the filters."""

_ZERO = 1e-9
"""Eigenvalues below, on a surface of unit area, are zero."""


def wave_kernel_signature(
    spectrum: Spectrum,
    energies: FloatArray | None = None,
    sigma: float = _SIGMA,
    vertices: IntArray | None = None,
) -> FloatArray:
    """Wave kernel signature: where quantum particles of a given energy are likely to be found.

    Component j at vertex x is A C_j Σ_i φ_i(x)² exp(-(e_j - log λ_i)² / 2σ²) / √m, over the
    eigenvalues that are not 0, A being the area and 1/C_j the sum of the exponentials: without
    the factor 1/√m, every component has mean 1 over the surface.

    Parameters
    ----------
    spectrum
        Of the shape, at least 2 eigenpairs.
    energies
        (m,) e_j, logarithms of eigenvalues. By default 32, evenly spaced over the logarithms of
        the first three quarters of the eigenvalues of any surface of this area, by Weyl's law
        λ_i ≈ 4πi/A. (Aubry et al. space them over the shape's own; all of them shift when a change
        of topology shifts the first.)
    sigma
        σ > 0, width of the filters.
    vertices
        (S,) where it is wanted; by default at all V vertices.

    Returns
    -------
    (S, m) float64, without unit. With the default energies, which are relative to the area, it
    does not change with scale.

    Raises
    ------
    ValueError
        σ is not positive, or the spectrum has but the constant eigenfunction.
    """
    positive = spectrum.eigenvalues * spectrum.area > _ZERO
    if not positive.any():
        raise ValueError("at least 2 eigenpairs are needed")
    logs = np.log(spectrum.eigenvalues[positive])
    if energies is None:
        last = max(_RANGE[1] * len(logs), _RANGE[0])
        counts = np.geomspace(_RANGE[0], last, _ENERGIES)
        energies = np.log(4.0 * np.pi / spectrum.area * counts)
    if not 0.0 < sigma < np.inf:
        raise ValueError("sigma must be positive and finite")
    exponents = -0.5 * ((energies - logs[:, None]) / sigma) ** 2
    # Relative to the greatest, so that a filter between eigenvalues is not 0/0.
    filters = np.exp(exponents - exponents.max(axis=0))
    filters /= filters.sum(axis=0)
    functions = spectrum.eigenfunctions[:, positive]
    squares = (functions if vertices is None else functions[vertices]) ** 2
    signature: FloatArray = squares @ filters * (spectrum.area / np.sqrt(len(energies)))
    return signature
