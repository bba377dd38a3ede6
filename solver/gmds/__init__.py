"""Generalised multidimensional scaling (GMDS): section 6.2, equation (7), and section 7.1.

:func:`gmds` minimises the stress (7) over points of a surface, from given initial points;
:func:`embed` is the method of section 6.2, which finds the initial points itself;
:func:`refine_by_gmds` refines a correspondence to positions between vertices (7.1).
"""

from solver.gmds.descent import Term, gmds
from solver.gmds.embedding import embed
from solver.gmds.interpolation import InterpolatedMetric
from solver.gmds.movement import walk
from solver.gmds.refinement import GmdsRefinement, refine_by_gmds
from solver.gmds.stress import Fields, descent_model, share, stress
from solver.gmds.surface import SurfacePoints, charts_of

__all__ = [
    "Fields",
    "GmdsRefinement",
    "InterpolatedMetric",
    "SurfacePoints",
    "Term",
    "charts_of",
    "descent_model",
    "embed",
    "gmds",
    "refine_by_gmds",
    "share",
    "stress",
    "walk",
]
