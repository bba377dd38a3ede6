"""The heat kernel of a surface, which metrics and signatures are checked against."""

import numpy as np

from solver.arrays import FloatArray
from solver.shape.laplacian import Spectrum


def heat_kernel(spectrum: Spectrum, time: float) -> FloatArray:
    """h_t(x, y) = Σ exp(-λ_i t) φ_i(x) φ_i(y), (V, V)."""
    functions = spectrum.eigenfunctions
    kernel: FloatArray = (functions * np.exp(-time * spectrum.eigenvalues)) @ functions.T
    return kernel
