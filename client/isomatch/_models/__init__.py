"""Values of the API: parameters of requests, and parts of answers."""

from isomatch._models.answer import Answer, Page
from isomatch._models.arguments import StructureChoice, check_names
from isomatch._models.attributes import (
    Attributes,
    AttributeSummary,
    SurfacePoint,
    TransferredLandmark,
)
from isomatch._models.confidence import Confidence
from isomatch._models.correspondences import (
    Alternative,
    Correspondence,
    Correspondences,
    DenseCorrespondence,
    Distortion,
    GromovHausdorff,
    InverseCorrespondence,
    Level,
    Overlap,
    SampleProof,
)
from isomatch._models.ids import (
    ID_DIGITS,
    begins_job_id,
    is_attributes_id,
    is_prototype_id,
    is_shape_id,
    may_be_id,
)
from isomatch._models.job import AnsweredState, JobRecord, JobState, JobWebhook, Progress
from isomatch._models.match_summary import MatchSummary
from isomatch._models.parameters import (
    DissimilarityParameters,
    MatchParameters,
    PrototypeParameters,
)
from isomatch._models.refinement import RefinedPoint, Refinement
from isomatch._models.shape import UPRIGHT, Shape, ViewAxes
from isomatch._models.structure_text import structure_choice
from isomatch._models.structures import Invariance, Structure, StructureParameter, Structures
from isomatch._models.vertex_map import VertexMap

__all__ = [
    "ID_DIGITS",
    "UPRIGHT",
    "Alternative",
    "Answer",
    "AnsweredState",
    "AttributeSummary",
    "Attributes",
    "Confidence",
    "Correspondence",
    "Correspondences",
    "DenseCorrespondence",
    "DissimilarityParameters",
    "Distortion",
    "GromovHausdorff",
    "Invariance",
    "InverseCorrespondence",
    "JobRecord",
    "JobState",
    "JobWebhook",
    "Level",
    "MatchParameters",
    "MatchSummary",
    "Overlap",
    "Page",
    "Progress",
    "PrototypeParameters",
    "RefinedPoint",
    "Refinement",
    "SampleProof",
    "Shape",
    "Structure",
    "StructureChoice",
    "StructureParameter",
    "Structures",
    "SurfacePoint",
    "TransferredLandmark",
    "VertexMap",
    "ViewAxes",
    "begins_job_id",
    "check_names",
    "is_attributes_id",
    "is_prototype_id",
    "is_shape_id",
    "may_be_id",
    "structure_choice",
]
