"""Registration: hypotheses aligned in spectrum, space and normals; the best one chosen and refined.

:func:`register` registers a source to a target, with a confidence.
"""

from solver.registration.candidates import NO_LANDMARKS, Points
from solver.registration.confidence import RIGHT_ERROR, Confidence
from solver.registration.dense_correspondence import DenseCorrespondence
from solver.registration.pairwise import first_registration, first_score, register, register_map
from solver.registration.registration import Registration
from solver.registration.search import STAGE
from solver.registration.surface import EIGENPAIRS, smooth_surface

__all__ = [
    "EIGENPAIRS",
    "NO_LANDMARKS",
    "RIGHT_ERROR",
    "STAGE",
    "Confidence",
    "DenseCorrespondence",
    "Points",
    "Registration",
    "first_registration",
    "first_score",
    "register",
    "register_map",
    "smooth_surface",
]
