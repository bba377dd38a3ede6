"""Generalized multidimensional scaling (GMDS): section 6.2, (7), and section 7.1.

``surface`` has points in barycentric coordinates and triangles laid flat, ``movement`` straight
lines over edges, ``interpolation`` distances between any two points, ``stress`` (7) and its
descent by one point, ``descent`` the minimisation, :func:`gmds`; ``embedding`` begins it where
section 6.2 does.
"""

from solver.gmds.descent import GmdsSolution, Status, Term, gmds
from solver.gmds.embedding import Embedding, embed
from solver.gmds.interpolation import InterpolatedMetric
from solver.gmds.movement import walk
from solver.gmds.refinement import Refinement, refine_by_gmds
from solver.gmds.stress import Fields, costs_of_vertices, descent_model, share, stress
from solver.gmds.surface import SurfacePoints, charts_of

__all__ = [
    "Embedding",
    "Fields",
    "GmdsSolution",
    "InterpolatedMetric",
    "Refinement",
    "Status",
    "SurfacePoints",
    "Term",
    "charts_of",
    "costs_of_vertices",
    "descent_model",
    "embed",
    "gmds",
    "refine_by_gmds",
    "share",
    "stress",
    "walk",
]
