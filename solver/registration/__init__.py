"""Registration: hypotheses aligned in spectrum, space and normals; the best one chosen and refined.

:func:`register` registers a source to a target, and says how sure it is.
"""

from solver.registration.candidates import Points
from solver.registration.confidence import Confidence
from solver.registration.dense_correspondence import DenseCorrespondence
from solver.registration.descent import descend, nearest_in_fan, nearest_in_triangle, project
from solver.registration.registration import Registration, register
from solver.registration.rotations import nearest_rotations
from solver.registration.search import STAGE
from solver.registration.surface import EIGENPAIRS

__all__ = [
    "EIGENPAIRS",
    "STAGE",
    "Confidence",
    "DenseCorrespondence",
    "Points",
    "Registration",
    "descend",
    "nearest_in_fan",
    "nearest_in_triangle",
    "nearest_rotations",
    "project",
    "register",
]
