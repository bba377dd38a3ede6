"""Kinds and states of jobs."""

from enum import StrEnum
from typing import Any, Final

from pydantic import GetJsonSchemaHandler
from pydantic_core import CoreSchema


class JobKind(StrEnum):
    """Kind of a job."""

    MATCH = "match"
    BATCH = "batch"
    DISSIMILARITIES = "dissimilarities"
    TIME_SLICE = "turn"  # the value is in stored records
    SPECTRUM = "spectrum"
    VALIDATION = "validation"
    PROTOTYPE = "prototype"
    PROTOTYPE_VALIDATION = "prototype_validation"
    TRANSFER = "transfer"
    REGISTRATION = "registration"
    CONSISTENT_MAPS = "consistent_maps"
    ATTRIBUTES_VALIDATION = "attributes_validation"
    PICTURE = "picture"
    WEBHOOK = "webhook"

    @classmethod
    def __get_pydantic_json_schema__(
        cls, core_schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        """Return the schema of the kinds that callers see; the others serve the service itself."""
        reference = handler(core_schema)
        schema = handler.resolve_ref_schema(reference)
        schema["enum"] = [one.value for one in cls if one.has_result or one in _VALIDATIONS]
        return reference

    @property
    def has_result(self) -> bool:
        """Whether users submit jobs of this kind and get a result."""
        return self in (
            JobKind.MATCH,
            JobKind.BATCH,
            JobKind.DISSIMILARITIES,
            JobKind.PROTOTYPE,
            JobKind.TRANSFER,
            JobKind.REGISTRATION,
            JobKind.CONSISTENT_MAPS,
        )

    @property
    def has_arrays(self) -> bool:
        """Whether the result is also stored as NumPy arrays."""
        return self.has_result and self not in (JobKind.PROTOTYPE, JobKind.BATCH)

    @property
    def exports(self) -> tuple[str, ...]:
        """Formats of files, besides arrays and a picture, of results of this kind.

        Not every result has all: see `exports_of`.
        """
        if self is JobKind.MATCH:
            return ("csv", "ply", "obj", "glb")
        if self is JobKind.TRANSFER:
            return ("csv", "ply", "obj", "glb", "zip")
        if self is JobKind.REGISTRATION:
            return ("ply", "obj", "glb")
        return ("csv",) if self is JobKind.DISSIMILARITIES else ()

    @property
    def has_picture(self) -> bool:
        """Whether their result can be drawn."""
        return self in (JobKind.MATCH, JobKind.DISSIMILARITIES, JobKind.REGISTRATION)


_VALIDATIONS: Final = (
    JobKind.VALIDATION,
    JobKind.PROTOTYPE_VALIDATION,
    JobKind.ATTRIBUTES_VALIDATION,
)


class JobState(StrEnum):
    """State of a job: queued, running, and then one of three final states."""

    QUEUED = "queued"
    RUNNING = "running"
    SUCCEEDED = "succeeded"
    FAILED = "failed"
    CANCELLED = "cancelled"

    @property
    def ended(self) -> bool:
        """Whether a job in this state stays in it."""
        return self not in (JobState.QUEUED, JobState.RUNNING)
