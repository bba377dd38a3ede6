"""The Laplace-Beltrami operator (section 3.1) and its smallest eigenpairs."""

from solver.shape.laplacian.eigensolver import smallest_eigenpairs
from solver.shape.laplacian.sparse_factor import DefiniteFactor
from solver.shape.laplacian.spectrum import (
    Spectrum,
    laplace_beltrami_spectrum,
    laplacian,
    spectrum_memory,
)

__all__ = [
    "DefiniteFactor",
    "Spectrum",
    "laplace_beltrami_spectrum",
    "laplacian",
    "smallest_eigenpairs",
    "spectrum_memory",
]
