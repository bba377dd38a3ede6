"""Registration: hypotheses aligned in spectrum, space and normals; the best one chosen and refined.

:func:`register` registers a source to a target, with a confidence.
"""

from solver.registration.candidates import Points
from solver.registration.confidence import SURE, Confidence
from solver.registration.dense_correspondence import DenseCorrespondence
from solver.registration.registration import Registration, first_registration, register
from solver.registration.search import STAGE
from solver.registration.surface import EIGENPAIRS

__all__ = [
    "EIGENPAIRS",
    "STAGE",
    "SURE",
    "Confidence",
    "DenseCorrespondence",
    "Points",
    "Registration",
    "first_registration",
    "register",
]
