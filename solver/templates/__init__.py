"""Templates: one connectivity on many surfaces, and statistics of shapes with this connectivity.

:func:`register_template` transfers the connectivity of a source to the surface of a target, and
:func:`surface_distance` measures how far both are apart;
:func:`shape_statistics` computes the mean shape and the principal components of many shapes.
"""

from solver.templates.distance import SurfaceDistance, surface_distance
from solver.templates.registered import RegisteredTemplate, register_template
from solver.templates.statistics import (
    ShapeStatistics,
    generalised_procrustes,
    shape_statistics,
)

__all__ = [
    "RegisteredTemplate",
    "ShapeStatistics",
    "SurfaceDistance",
    "generalised_procrustes",
    "register_template",
    "shape_statistics",
    "surface_distance",
]
