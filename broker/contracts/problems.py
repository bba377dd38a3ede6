"""Problem documents (RFC 9457), the form of all errors, and their types."""

from collections.abc import Iterable
from enum import Enum
from typing import Self

from pydantic import BaseModel, ConfigDict, Field

URN = "urn:isomatch:problem:"


class ProblemType(Enum):
    """Type of a problem, of the API and of jobs.

    Attributes
    ----------
    slug
        Last part of its URI.
    status
        HTTP status.
    title
        The type in words.
    """

    BAD_REQUEST = "bad-request", 400, "Bad request"
    UNAUTHORIZED = "unauthorized", 401, "API key needed"
    CROSS_SITE_REQUEST = "cross-site-request", 403, "Request of another site"
    NOT_FOUND = "not-found", 404, "Not found"
    SHAPE_NOT_FOUND = "shape-not-found", 404, "No such shape"
    PROTOTYPE_NOT_FOUND = "prototype-not-found", 404, "No such prototype"
    ATTRIBUTES_NOT_FOUND = "attributes-not-found", 404, "No such attributes"
    JOB_NOT_FOUND = "job-not-found", 404, "No such job"
    METHOD_NOT_ALLOWED = "method-not-allowed", 405, "Method not allowed"
    BODY_STALLED = "body-stalled", 408, "Request timed out"
    RESULT_NOT_READY = "result-not-ready", 409, "Result not ready"
    JOB_WITHOUT_RESULT = "job-without-result", 409, "Job without a result"
    UPLOAD_CANCELLED = "upload-cancelled", 409, "Upload cancelled"
    IDEMPOTENCY_KEY_REUSED = "idempotency-key-reused", 409, "Idempotency key reused"
    RESULT_EXPIRED = "result-expired", 410, "Result expired"
    SHAPE_EXPIRED = "shape-expired", 410, "Shape expired"
    GEOMETRY_NOT_KEPT = "geometry-not-kept", 410, "Geometry not kept"
    CONTENT_LOST = "content-lost", 410, "Content lost"
    PROTOTYPE_EXPIRED = "prototype-expired", 410, "Prototype expired"
    ATTRIBUTES_EXPIRED = "attributes-expired", 410, "Attributes expired"
    JOB_EXPIRED = "job-expired", 410, "Job expired"
    SHAPE_DELETED = "shape-deleted", 410, "Shape deleted"
    PROTOTYPE_DELETED = "prototype-deleted", 410, "Prototype deleted"
    ATTRIBUTES_DELETED = "attributes-deleted", 410, "Attributes deleted"
    UPLOAD_EXPIRED = "upload-expired", 410, "Upload expired"
    UPLOAD_TOO_LARGE = "upload-too-large", 413, "Request too large"
    UNSUPPORTED_FORMAT = "unsupported-format", 415, "Unsupported format"
    ENCODED_BODY = "encoded-body", 415, "Encoded body"
    MISDIRECTED_REQUEST = "misdirected-request", 421, "Name not accepted"
    INVALID_REQUEST = "invalid-request", 422, "Invalid request"
    UNKNOWN_SHAPE = "unknown-shape", 422, "Unknown shape"
    UNKNOWN_PROTOTYPE = "unknown-prototype", 422, "Unknown prototype"
    UNKNOWN_ATTRIBUTES = "unknown-attributes", 422, "Unknown attributes"
    UNUSABLE_MESH = "unusable-mesh", 422, "Not a usable mesh"
    UNUSABLE_PROTOTYPE = "unusable-prototype", 422, "Not a usable prototype"
    UNUSABLE_ATTRIBUTES = "unusable-attributes", 422, "Not usable attributes"
    MISPLACED_LANDMARKS = "misplaced-landmarks", 422, "Landmarks not on the surface"
    NO_SOLUTION = "no-solution", 422, "No answer"
    OUT_OF_MEMORY = "out-of-memory", 422, "Out of memory"
    TIMED_OUT = "timed-out", 422, "Took too long"
    INVALID_OPTION = "invalid-option", 422, "Impossible parameters"
    WEBHOOK_NOT_DELIVERED = "webhook-not-delivered", 424, "Webhook not delivered"
    TOO_MANY_JOBS = "too-many-jobs", 429, "Too many jobs"
    INTERNAL_ERROR = "internal-error", 500, "Internal error"
    WORKER_LOST = "worker-lost", 500, "The computation was killed"
    PICTURE_NOT_READY = "picture-not-ready", 503, "Picture not ready"
    NEWER_VERSION = "newer-version", 503, "Stored by a newer version"
    STORE_AWAY = "store-away", 503, "Store cannot be reached"
    TOO_MANY_UPLOADS = "too-many-uploads", 503, "Too many uploads"
    NOT_READY = "not-ready", 503, "Not ready"
    QUOTA_EXCEEDED = "quota-exceeded", 507, "Quota used up"
    STORAGE_FULL = "storage-full", 507, "Storage full"

    def __init__(self, slug: str, status: int, title: str) -> None:
        self.slug = slug
        self.status = status
        self.title = title


def _pointer(field: str) -> str | None:
    where, *parts = field.split(".")
    return json_pointer(parts) if where == "body" else None


def json_pointer(parts: Iterable[str]) -> str:
    """Return a JSON pointer from the names and places that it has, in order."""
    return "".join("/" + part.replace("~", "~0").replace("/", "~1") for part in parts)


class FieldProblem(BaseModel):
    """Problem with one field of a request."""

    model_config = ConfigDict(frozen=True)

    field: str = Field(
        description="Where the field is: `body`, `query`, `path` or `header`, then the names of"
        " fields and the places in lists that lead to it, from 0, separated by dots.",
        examples=["body.metric.1.time"],
    )
    message: str = Field(description="What is wrong with its value.")
    pointer: str | None = Field(
        default_factory=lambda known: _pointer(known["field"]),
        description="JSON pointer (RFC 6901) to the field in the body; null where it is not in the"
        " body.",
        examples=["/metric/1/time"],
    )


class Problem(BaseModel):
    """A problem document (RFC 9457)."""

    model_config = ConfigDict(frozen=True)

    type: str = Field(
        description=f"URI that names the kind of problem: `{URN}` and one of "
        + ", ".join(f"`{kind.slug}`" for kind in ProblemType)
        + ". Later versions may add others.",
        examples=[URN + "unknown-shape"],
    )
    title: str = Field(description="The kind of problem in words.")
    status: int = Field(description="HTTP status.")
    detail: str = Field(description="This occurrence of it in words, and what to do about it.")
    instance: str | None = Field(description="What it happened to.")
    errors: tuple[FieldProblem, ...] = Field(
        description="What is wrong with which field, where fields are to blame."
    )

    @classmethod
    def of(
        cls,
        kind: ProblemType,
        detail: str,
        errors: tuple[FieldProblem, ...] = (),
        instance: str | None = None,
    ) -> Self:
        """Return a problem of a type."""
        return cls(
            type=URN + kind.slug,
            title=kind.title,
            status=kind.status,
            detail=detail,
            errors=errors,
            instance=instance,
        )

    @property
    def slug(self) -> str:
        """Name of the kind of problem, the last part of its type."""
        return self.type.removeprefix(URN)
