"""Templates: one connectivity on many surfaces, and the statistics of shape that it allows.

:func:`register_template` puts the connectivity of a source on the surface of a target;
:func:`shape_statistics` has the mean shape and the principal components of many.
"""

from solver.templates.registered import RegisteredTemplate, register_template
from solver.templates.statistics import (
    Alignment,
    ShapeStatistics,
    generalised_procrustes,
    shape_statistics,
)
from solver.templates.surface_tree import SurfaceTree, surface_tree

__all__ = [
    "Alignment",
    "RegisteredTemplate",
    "ShapeStatistics",
    "SurfaceTree",
    "generalised_procrustes",
    "register_template",
    "shape_statistics",
    "surface_tree",
]
