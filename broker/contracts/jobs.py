"""Jobs: payloads (parameters) and records."""

from collections.abc import Mapping
from datetime import datetime
from types import MappingProxyType
from typing import Annotated, Final, Literal, TypeAlias

from pydantic import BaseModel, ConfigDict, Field

from broker.contracts.job_kinds import JobKind, JobState
from broker.contracts.parameters import (
    DissimilarityParameters,
    MatchParameters,
    PrototypeParameters,
)
from broker.contracts.problems import Problem, ProblemType
from broker.contracts.prototypes import ARCHIVE_TYPE, is_prototype
from broker.contracts.spectra import SpectrumKey
from broker.contracts.transfers import (
    AttributeElement,
    Direction,
    GivenLandmark,
    SurfacePoint,
    TransferKind,
)
from broker.contracts.webhooks import Delivery, Webhook

View: TypeAlias = Literal["front", "back", "left", "right", "top", "bottom"]
"""Side from which shapes are drawn."""


UNUSABLE: Final[Mapping[JobKind, ProblemType]] = MappingProxyType(
    {
        JobKind.VALIDATION: ProblemType.UNUSABLE_MESH,
        JobKind.PROTOTYPE_VALIDATION: ProblemType.UNUSABLE_PROTOTYPE,
        JobKind.ATTRIBUTES_VALIDATION: ProblemType.UNUSABLE_ATTRIBUTES,
    }
)
"""Type of the problem of an upload that cannot be used."""


class Progress(BaseModel):
    """Progress of a job."""

    model_config = ConfigDict(frozen=True)

    stage: str = Field(
        description="What is being done, in words to be shown: they depend on the kind of the job"
        ' and may change between versions, but for "queued", "spectra" (computed beforehand, for a'
        ' queued job) and "done".'
    )
    fraction: float = Field(ge=0, le=1, description="Share of the whole job that is done.")


class _Payload(BaseModel):
    model_config = ConfigDict(frozen=True)

    version: Literal[1] = 1


class ValidationPayload(_Payload):
    """Read an upload, and make a shape of it if it is a usable mesh."""

    kind: Literal[JobKind.VALIDATION] = JobKind.VALIDATION
    shape: str
    name: str
    file_type: str

    @property
    def upload(self) -> str:
        """Id of the upload, which is that of the shape."""
        return self.shape


class PrototypeValidationPayload(_Payload):
    """Read an uploaded archive, and make a prototype of it if it is one."""

    kind: Literal[JobKind.PROTOTYPE_VALIDATION] = JobKind.PROTOTYPE_VALIDATION
    prototype: str
    name: str

    @property
    def upload(self) -> str:
        """Id of the upload, which is that of the prototype."""
        return self.prototype

    @property
    def file_type(self) -> str:
        """Format of the file."""
        return ARCHIVE_TYPE


class AttributesValidationPayload(_Payload):
    """Read an uploaded attribute file, and keep it if it is one."""

    kind: Literal[JobKind.ATTRIBUTES_VALIDATION] = JobKind.ATTRIBUTES_VALIDATION
    attributes: str
    name: str
    file_type: str

    @property
    def upload(self) -> str:
        """Id of the upload, which is that of the attribute file."""
        return self.attributes


UploadPayload: TypeAlias = (
    ValidationPayload | PrototypeValidationPayload | AttributesValidationPayload
)
"""Payload of a job that validates an upload."""


class SpectrumPayload(_Payload):
    """Compute the spectrum of a shape before it is needed."""

    kind: Literal[JobKind.SPECTRUM] = JobKind.SPECTRUM
    shape: str
    eigenpairs: int
    largest_component: bool
    simplify: int | None = None
    file_type: str = ""

    @property
    def key(self) -> SpectrumKey:
        """Name of the spectrum in the cache."""
        return SpectrumKey(
            self.shape, self.eigenpairs, self.largest_component, self.simplify, self.file_type
        )


class MatchPayload(_Payload):
    """Match two shapes, or a prototype and a shape."""

    kind: Literal[JobKind.MATCH] = JobKind.MATCH
    source: str
    target: str
    source_name: str | None = None
    target_name: str | None = None
    parameters: MatchParameters

    @property
    def needs_spectrum(self) -> bool:
        """Whether the spectra of the shapes are used."""
        # Prototypes are usually sampled in a spectral metric.
        return self.parameters.needs_spectrum or is_prototype(self.source)


class BatchPayload(_Payload):
    """Match one source with many targets; each match is a job of its own."""

    kind: Literal[JobKind.BATCH] = JobKind.BATCH
    source: str
    source_name: str | None = None
    targets: tuple[str, ...]
    target_names: tuple[str | None, ...]
    parameters: MatchParameters

    def match(self, place: int) -> MatchPayload:
        """Return the match with the target at a place."""
        return MatchPayload(
            source=self.source,
            target=self.targets[place],
            source_name=self.source_name,
            target_name=self.target_names[place],
            parameters=self.parameters,
        )


class DissimilaritiesPayload(_Payload):
    """Compare all shapes of a collection; done in time slices, by all workers."""

    kind: Literal[JobKind.DISSIMILARITIES] = JobKind.DISSIMILARITIES
    shapes: tuple[str, ...]
    names: tuple[str | None, ...] | None = None
    labels: tuple[str, ...] | None
    parameters: DissimilarityParameters


class PrototypePayload(_Payload):
    """Learn a prototype from shapes."""

    kind: Literal[JobKind.PROTOTYPE] = JobKind.PROTOTYPE
    shapes: tuple[str, ...]
    reference: int = Field(description="Place of the shape that the points are chosen on.")
    correspondences: tuple[tuple[int, ...], ...] | None
    name: str
    parameters: PrototypeParameters

    @property
    def needs_spectrum(self) -> bool:
        """Whether the spectra of the shapes are used."""
        return self.parameters.needs_spectrum


class RegistrationPayload(_Payload):
    """Register a template to specimens."""

    kind: Literal[JobKind.REGISTRATION] = JobKind.REGISTRATION
    template: str
    template_name: str | None = None
    shapes: tuple[str, ...] = Field(description="Ids of the specimens.")
    names: tuple[str | None, ...] | None = Field(
        default=None,
        description="Names of the specimens; null for those that they are stored under.",
    )
    scale: bool
    parameters: MatchParameters = Field(description="Parameters of the matches.")

    @property
    def needs_spectrum(self) -> bool:
        """Whether the spectra of the shapes are used."""
        return self.parameters.needs_spectrum


class ConsistentMapsPayload(_Payload):
    """Map all shapes of a collection to one another, consistently."""

    kind: Literal[JobKind.CONSISTENT_MAPS] = JobKind.CONSISTENT_MAPS
    shapes: tuple[str, ...]
    names: tuple[str | None, ...] | None = None
    parameters: MatchParameters = Field(description="Parameters of the pairwise matches.")

    @property
    def needs_spectrum(self) -> bool:
        """Whether the spectra of the shapes are used."""
        return self.parameters.needs_spectrum


class TransferPayload(_Payload):
    """Carry attributes or landmarks along a match."""

    kind: Literal[JobKind.TRANSFER] = JobKind.TRANSFER
    match: str = Field(description="Id of the job that matched the shapes.")
    source: str = Field(description="Id of the shape that values are carried from.")
    target: str = Field(description="Id of the shape that values are carried to.")
    attributes: str | None = Field(
        description="Id of the attribute file; null for the source's own file."
    )
    what: TransferKind
    direction: Direction
    on: AttributeElement | None = None
    names: tuple[str, ...] = ()
    influences: int | None = None
    points: tuple[SurfacePoint, ...] | None = Field(
        default=(),
        description="Landmarks on the surface; null if they are given in space, so that versions"
        " that do not know these leave the record to others.",
    )
    landmarks: tuple[GivenLandmark, ...] = ()


class TimeSlicePayload(_Payload):
    """Work for a while on a job that is done in time slices."""

    kind: Literal[JobKind.TIME_SLICE] = JobKind.TIME_SLICE
    job: str = Field(description="Id of the job that is worked on.")


class PicturePayload(_Payload):
    """Draw the result of a job, or write it to a file of another format."""

    kind: Literal[JobKind.PICTURE] = JobKind.PICTURE
    job: str = Field(description="Id of the job whose result is drawn.")
    alternative: int | None = Field(
        default=None, description="Which of its alternatives is drawn, 0 for none of them."
    )
    view: View = Field(default="front", description="From where its shapes are seen.")
    format: Literal["png", "csv", "ply", "obj", "glb", "zip", "npz"] = Field(
        default="png",
        description="Format of the file; npz for what a transfer carried, on its source.",
    )
    specimen: int | None = Field(
        default=None,
        description="Which specimen's registered template is written, 0 for that of a match; null"
        " for the result itself.",
    )
    pair: tuple[int, int] | None = Field(
        default=None,
        description="Places of the shapes whose map of all vertices is written; null for the result"
        " itself.",
    )

    @property
    def variant(self) -> str:
        """Name of the file among those of the job; empty for the picture by default."""
        default = PicturePayload(job=self.job)
        given = (
            # Neither is an alternative: both draw the result itself.
            None if not self.alternative else str(self.alternative),
            None if self.view == default.view else self.view,
            None if self.format == default.format else self.format,
            None if self.specimen is None else f"registered-{self.specimen}",
            None if self.pair is None else "map-{}-{}".format(*self.pair),
        )
        return ":".join(part for part in given if part is not None)


class DeliveryPayload(_Payload):
    """Notify the receiver of a job's webhook that the job has ended."""

    kind: Literal[JobKind.WEBHOOK] = JobKind.WEBHOOK
    job: str = Field(description="Id of the job that has ended.")
    attempt: int = Field(ge=1, description="Which try this is.")


Payload: TypeAlias = Annotated[
    ValidationPayload
    | PrototypeValidationPayload
    | SpectrumPayload
    | MatchPayload
    | BatchPayload
    | DissimilaritiesPayload
    | PrototypePayload
    | AttributesValidationPayload
    | TransferPayload
    | RegistrationPayload
    | ConsistentMapsPayload
    | TimeSlicePayload
    | PicturePayload
    | DeliveryPayload,
    Field(discriminator="kind"),
]


class JobRecord(BaseModel):
    """A job, as the store keeps it."""

    model_config = ConfigDict(frozen=True)

    id: str
    payload: Payload
    created: datetime
    request_id: str | None = None
    caller: str | None = None
    webhook: Webhook | None = None
    batch: str | None = Field(default=None, description="Id of the batch that it is a match of.")
    traceparent: str | None = Field(
        default=None, description="Span of the request (W3C Trace Context)."
    )
    state: JobState = JobState.QUEUED
    progress: Progress = Progress(stage="queued", fraction=0.0)
    started: datetime | None = None
    ended: datetime | None = None
    error: Problem | None = None
    delivery: Delivery | None = None

    @property
    def kind(self) -> JobKind:
        """Kind of the job."""
        return self.payload.kind

    @property
    def is_listed(self) -> bool:
        """Whether a user asked for it itself, not for what it is a part of."""
        return self.kind.has_result and self.batch is None

    @property
    def is_upload(self) -> bool:
        """Whether it validates an upload."""
        return self.kind in UNUSABLE
