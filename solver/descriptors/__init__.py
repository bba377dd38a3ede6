"""Local descriptors f_X of a shape's vertices, sections 3.5 to 3.8 and Table 1.

Descriptors are compared by the Euclidean norm. Each one is scaled so that the norm of a difference
is a root mean square over its components. On a surface of unit area all are without unit.
"""

from solver.descriptors.conformal_factor import conformal_factor
from solver.descriptors.eigenfunctions import (
    aligned_eigenfunctions,
    eigenfunction_groups,
    eigenfunction_magnitudes,
)
from solver.descriptors.gaussian_curvature import angle_defects, gaussian_curvature
from solver.descriptors.geodesic_histogram import geodesic_histogram
from solver.descriptors.heat_kernel import (
    heat_kernel_signature,
    scale_invariant_heat_kernel_signature,
)
from solver.descriptors.photometric import photometric
from solver.descriptors.wave_kernel import wave_kernel_signature

__all__ = [
    "aligned_eigenfunctions",
    "angle_defects",
    "conformal_factor",
    "eigenfunction_groups",
    "eigenfunction_magnitudes",
    "gaussian_curvature",
    "geodesic_histogram",
    "heat_kernel_signature",
    "photometric",
    "scale_invariant_heat_kernel_signature",
    "wave_kernel_signature",
]
