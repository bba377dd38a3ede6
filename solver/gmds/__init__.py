"""Generalized multidimensional scaling (GMDS): section 6.2, (7), and section 7.1.

``surface`` has points in barycentric coordinates and triangles laid flat, ``movement`` straight
lines over edges, ``interpolation`` distances between any two points, ``stress`` (7) and its
descent by one point, ``descent`` the minimisation, :func:`gmds`; ``embedding`` begins it where
section 6.2 does.
"""

from solver.gmds.descent import GmdsSolution, Status, Term, gmds
from solver.gmds.embedding import Embedding, embed
from solver.gmds.interpolation import InterpolatedMetric
from solver.gmds.surface import SurfacePoints

__all__ = [
    "Embedding",
    "GmdsSolution",
    "InterpolatedMetric",
    "Status",
    "SurfacePoints",
    "Term",
    "embed",
    "gmds",
]
