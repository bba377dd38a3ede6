"""The Laplace-Beltrami operator (section 3.3) and its smallest eigenpairs."""

from solver.shape.laplacian.eigensolver import smallest_eigenpairs
from solver.shape.laplacian.sparse_factor import definite_factor
from solver.shape.laplacian.spectrum import (
    Spectrum,
    laplace_beltrami_spectrum,
    laplacian,
    spectrum_memory,
)

__all__ = [
    "Spectrum",
    "definite_factor",
    "laplace_beltrami_spectrum",
    "laplacian",
    "smallest_eigenpairs",
    "spectrum_memory",
]
