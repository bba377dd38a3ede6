"""What the API sends and takes, as typed values."""

from isomatch._models.arguments import StructureChoice, check_names, structure_choice
from isomatch._models.correspondences import (
    Alternative,
    Correspondence,
    Correspondences,
    Distortion,
    Level,
)
from isomatch._models.dense import DenseCorrespondence
from isomatch._models.models import Answer, JobRecord, JobState, JobWebhook, Page, Progress, Shape
from isomatch._models.parameters import (
    DissimilarityParameters,
    MatchParameters,
    PrototypeParameters,
)
from isomatch._models.refinement import RefinedPoint, Refinement
from isomatch._models.structures import Invariance, Structure, StructureParameter, Structures

__all__ = [
    "Alternative",
    "Answer",
    "Correspondence",
    "Correspondences",
    "DenseCorrespondence",
    "DissimilarityParameters",
    "Distortion",
    "Invariance",
    "JobRecord",
    "JobState",
    "JobWebhook",
    "Level",
    "MatchParameters",
    "Page",
    "Progress",
    "PrototypeParameters",
    "RefinedPoint",
    "Refinement",
    "Shape",
    "Structure",
    "StructureChoice",
    "StructureParameter",
    "Structures",
    "check_names",
    "structure_choice",
]
