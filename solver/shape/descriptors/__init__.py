"""Local descriptors f_X of a shape's vertices, sections 3.5 to 3.8 and Table 1.

Descriptors are compared by the Euclidean norm, and scaled so that the norm of a difference is the
root mean square over components. On a surface of unit area all are without unit.
"""

from solver.shape.descriptors.conformal_factor import conformal_factor
from solver.shape.descriptors.deviation import descriptor_deviation
from solver.shape.descriptors.eigenfunctions import (
    aligned_eigenfunctions,
    eigenfunction_groups,
    eigenfunction_magnitudes,
)
from solver.shape.descriptors.gaussian_curvature import (
    angle_defects,
    gaussian_curvature,
    inner_vertices,
    mixed_areas,
)
from solver.shape.descriptors.geodesic_disc import annulus_areas, disc_weights
from solver.shape.descriptors.geodesic_histogram import geodesic_histogram
from solver.shape.descriptors.heat_kernel import (
    heat_kernel_signature,
    scale_invariant_heat_kernel_signature,
)
from solver.shape.descriptors.photometric import photometric
from solver.shape.descriptors.wave_kernel import wave_kernel_signature

__all__ = [
    "aligned_eigenfunctions",
    "angle_defects",
    "annulus_areas",
    "conformal_factor",
    "descriptor_deviation",
    "disc_weights",
    "eigenfunction_groups",
    "eigenfunction_magnitudes",
    "gaussian_curvature",
    "geodesic_histogram",
    "heat_kernel_signature",
    "inner_vertices",
    "mixed_areas",
    "photometric",
    "scale_invariant_heat_kernel_signature",
    "wave_kernel_signature",
]
