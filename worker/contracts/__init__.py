"""What travels between the API and the workers, and out of the API: versioned, typed, plain.

Nothing here imports numerics: the API process reads these models and computes nothing.
"""

from worker.contracts.catalogue import Structures, catalogue
from worker.contracts.descriptors import DescriptorName
from worker.contracts.dissimilarities import (
    MOST_SHAPES,
    NEIGHBOURS,
    DissimilarityParameters,
    DissimilarityResult,
)
from worker.contracts.jobs import (
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
from worker.contracts.metrics import MetricName
from worker.contracts.orders import Once, Order
from worker.contracts.parameters import MatchParameters
from worker.contracts.problems import FieldProblem, Problem
from worker.contracts.prototypes import (
    MOST_EXAMPLES,
    ExampleReport,
    PrototypeParameters,
    PrototypeRecord,
    PrototypeResult,
    PrototypeStructures,
    is_prototype,
    prototype_id,
)
from worker.contracts.results import (
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
from worker.contracts.shapes import MESH_FORMATS, ShapeRecord, file_type_of, shape_id
from worker.contracts.spectra import SPECTRUM_VERSION, SpectrumKey, spectrum_key
from worker.contracts.subjects import Subject, subject_of
from worker.contracts.webhooks import Delivery, DeliveryState, Webhook, WebhookEvent

__all__ = [
    "MESH_FORMATS",
    "MOST_EXAMPLES",
    "MOST_SHAPES",
    "NEIGHBOURS",
    "SPECTRUM_VERSION",
    "Alternative",
    "Correspondence",
    "Delivery",
    "DeliveryPayload",
    "DeliveryState",
    "DenseCorrespondence",
    "DescriptorName",
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
    "MetricName",
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
