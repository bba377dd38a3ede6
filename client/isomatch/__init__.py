"""Client of the isomatch service: minimum-distortion correspondence of non-rigid shapes.

>>> import isomatch
>>> with isomatch.Client() as client:
...     match = client.match(client.upload("a.off"), client.upload("b.obj")).result()
>>> match.pairs, match.distortion.second_order, match.certified
"""

from importlib.metadata import version as _version

from isomatch._async_client import AsyncClient
from isomatch._async_job import AsyncJob
from isomatch._client import Client
from isomatch._correspondences import Alternative, Correspondence, Distortion, Level
from isomatch._dense import DenseCorrespondence
from isomatch._dissimilarities import Dissimilarities, PartialDissimilarities
from isomatch._errors import (
    BadRequest,
    Conflict,
    ConnectionFailed,
    Gone,
    InvalidRequest,
    InvalidSignature,
    IsomatchError,
    JobCancelled,
    JobFailed,
    MissingExtra,
    NotFound,
    ProblemError,
    ServiceError,
    ServiceUnavailable,
    TooLarge,
    TooManyRequests,
    Unauthorized,
    UnexpectedResponse,
    UnknownPrototype,
    UnknownShape,
    Unprocessable,
    UnprocessablePrototype,
    UnprocessableShape,
    UnsupportedFormat,
    WaitTimeout,
)
from isomatch._geometry import Geometry
from isomatch._job import Job
from isomatch._match import Match
from isomatch._meshes import MeshLike
from isomatch._models import JobRecord, JobWebhook, Progress, Shape
from isomatch._parameters import DissimilarityParameters, MatchParameters, PrototypeParameters
from isomatch._problem import FieldProblem, Problem
from isomatch._prototype_points import PrototypePoints
from isomatch._prototypes import Example, LearnedPrototype, Prototype
from isomatch._refinement import RefinedPoint, Refinement
from isomatch._structures import Invariance, Structure, StructureParameter, Structures
from isomatch._webhooks import EndedJob, Webhook, WebhookEvent, verify_webhook

__version__ = _version("isomatch")

__all__ = [
    "Alternative",
    "AsyncClient",
    "AsyncJob",
    "BadRequest",
    "Client",
    "Conflict",
    "ConnectionFailed",
    "Correspondence",
    "DenseCorrespondence",
    "Dissimilarities",
    "DissimilarityParameters",
    "Distortion",
    "EndedJob",
    "Example",
    "FieldProblem",
    "Geometry",
    "Gone",
    "InvalidRequest",
    "InvalidSignature",
    "Invariance",
    "IsomatchError",
    "Job",
    "JobCancelled",
    "JobFailed",
    "JobRecord",
    "JobWebhook",
    "LearnedPrototype",
    "Level",
    "Match",
    "MatchParameters",
    "MeshLike",
    "MissingExtra",
    "NotFound",
    "PartialDissimilarities",
    "Problem",
    "ProblemError",
    "Progress",
    "Prototype",
    "PrototypeParameters",
    "PrototypePoints",
    "RefinedPoint",
    "Refinement",
    "ServiceError",
    "ServiceUnavailable",
    "Shape",
    "Structure",
    "StructureParameter",
    "Structures",
    "TooLarge",
    "TooManyRequests",
    "Unauthorized",
    "UnexpectedResponse",
    "UnknownPrototype",
    "UnknownShape",
    "Unprocessable",
    "UnprocessablePrototype",
    "UnprocessableShape",
    "UnsupportedFormat",
    "WaitTimeout",
    "Webhook",
    "WebhookEvent",
    "verify_webhook",
]
