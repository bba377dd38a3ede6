"""What travels between the API and the workers, and out of the API: versioned, typed, plain.

Nothing here imports numerics: the API process reads these models and computes nothing.
"""

from broker.contracts.catalogue import catalogue
from broker.contracts.dissimilarities import (
    MOST_SHAPES,
    NEIGHBOURS,
    PAIRS,
    RESULT,
    STAGES,
    STRUCTURES,
    DissimilarityResult,
)
from broker.contracts.jobs import (
    DeliveryPayload,
    DissimilaritiesPayload,
    JobKind,
    JobRecord,
    JobState,
    MatchPayload,
    Payload,
    PicturePayload,
    Progress,
    PrototypePayload,
    PrototypeValidationPayload,
    SpectrumPayload,
    TurnPayload,
    UploadPayload,
    ValidationPayload,
)
from broker.contracts.orders import Once, Order
from broker.contracts.parameters import (
    DissimilarityParameters,
    MatchParameters,
    PrototypeParameters,
    PrototypeStructures,
)
from broker.contracts.problems import URN, FieldProblem, Problem
from broker.contracts.prototypes import (
    ARCHIVE_TYPE,
    MOST_EXAMPLES,
    ExampleReport,
    PrototypeRecord,
    PrototypeResult,
    is_prototype,
    prototype_id,
)
from broker.contracts.results import (
    Alternative,
    Correspondence,
    DenseCorrespondence,
    Distortion,
    Level,
    MatchResult,
    RefinedPoint,
    Refinement,
    no_alternative,
)
from broker.contracts.shapes import MESH_FORMATS, ShapeRecord, file_type_of, shape_id
from broker.contracts.solver_options import GREATEST
from broker.contracts.spectra import SPECTRUM_VERSION, SpectrumKey, spectrum_key
from broker.contracts.structure_choices import DESCRIPTORS, METRICS
from broker.contracts.structures import Choice, Structure, Structures
from broker.contracts.subjects import Subject, subject_of
from broker.contracts.webhooks import Delivery, DeliveryState, Webhook, WebhookEvent

__all__ = [
    "ARCHIVE_TYPE",
    "DESCRIPTORS",
    "GREATEST",
    "MESH_FORMATS",
    "METRICS",
    "MOST_EXAMPLES",
    "MOST_SHAPES",
    "NEIGHBOURS",
    "PAIRS",
    "RESULT",
    "SPECTRUM_VERSION",
    "STAGES",
    "STRUCTURES",
    "URN",
    "Alternative",
    "Choice",
    "Correspondence",
    "Delivery",
    "DeliveryPayload",
    "DeliveryState",
    "DenseCorrespondence",
    "DissimilaritiesPayload",
    "DissimilarityParameters",
    "DissimilarityResult",
    "Distortion",
    "ExampleReport",
    "FieldProblem",
    "JobKind",
    "JobRecord",
    "JobState",
    "Level",
    "MatchParameters",
    "MatchPayload",
    "MatchResult",
    "Once",
    "Order",
    "Payload",
    "PicturePayload",
    "Problem",
    "Progress",
    "PrototypeParameters",
    "PrototypePayload",
    "PrototypeRecord",
    "PrototypeResult",
    "PrototypeStructures",
    "PrototypeValidationPayload",
    "RefinedPoint",
    "Refinement",
    "ShapeRecord",
    "SpectrumKey",
    "SpectrumPayload",
    "Structure",
    "Structures",
    "Subject",
    "TurnPayload",
    "UploadPayload",
    "ValidationPayload",
    "Webhook",
    "WebhookEvent",
    "catalogue",
    "file_type_of",
    "is_prototype",
    "no_alternative",
    "prototype_id",
    "shape_id",
    "spectrum_key",
    "subject_of",
]
