"""Problems that the API answers with, one class for each type (RFC 9457).

::

    ApiProblem
    ├── InvalidRequest              422  a field of the request is not valid; `errors` says which
    ├── BadRequest                  400  the request cannot be parsed
    ├── Unauthorized                401  the request has no API key, or an unknown one
    ├── NotFound                    404  there is nothing at this address
    │   ├── ShapeNotFound
    │   ├── PrototypeNotFound
    │   ├── AttributesNotFound
    │   └── JobNotFound
    ├── MethodNotAllowed            405  the method is not supported at this address
    ├── BodyStalled                 408  the body of the request stalled
    ├── ResultNotReady              409  the job has not ended
    ├── JobWithoutResult            409  the job failed or was cancelled, or has none
    ├── UploadCancelled             409  the validation of the upload was cancelled
    ├── IdempotencyKeyReused        409  the key was used for a different request
    ├── ResultExpired               410  the result is no longer kept
    ├── ShapeExpired                410  the shape was not used for long
    ├── PrototypeExpired            410  the prototype was not used for long
    ├── AttributesExpired           410  the attribute file was not used for long
    ├── JobExpired                  410  the job ended long ago
    ├── GeometryNotKept             410  stored by a version that kept no geometry
    ├── ContentLost                 410  the stored bytes are missing or damaged
    ├── ShapeDeleted                410  a shape was deleted in the meantime
    ├── PrototypeDeleted            410  a prototype was deleted in the meantime
    ├── AttributesDeleted           410  an attribute file was deleted in the meantime
    ├── UploadTooLarge              413  the upload is over the limit
    ├── UnsupportedFormat           415  the format of the file is not supported
    ├── EncodedBody                 415  the body is compressed
    ├── UnknownShape                422  the request names a shape that does not exist
    ├── UnknownPrototype            422  the request names a prototype that does not exist
    ├── UnknownAttributes           422  the request names an attribute file that does not exist
    ├── UnusableMesh                422  the file is not a usable mesh
    ├── UnusablePrototype           422  the file is not a usable archive of a prototype
    ├── UnusableAttributes          422  the file is not a usable file of attributes
    ├── TooManyJobs                 429  the caller has as many jobs queued as it may have
    ├── InternalError               500  an error of the service
    ├── StoreAway                   503  Redis or the blob store cannot be reached
    ├── NewerVersion                503  stored by a newer version; this one cannot read it
    ├── PictureNotReady             503  the picture is still being drawn
    ├── NotReady                    503  stopping, the store takes nothing, or no worker
    ├── QuotaUsedUp                 507  the tenant has as much as it may have
    └── StorageFull                 507  the disk, or the object storage, is full
"""

from typing import ClassVar, Final, Self

from broker.contracts import FieldProblem, Problem

INVALID: Final = "The request is not valid; `errors` says where."


class ApiProblem(Exception):
    """Root of the problems that the API answers with.

    Parameters
    ----------
    detail
        What is wrong in this request, and what to do about it.
    errors
        Problems of single fields.
    """

    status: ClassVar[int] = 500
    slug: ClassVar[str] = "internal-error"
    title: ClassVar[str] = "Internal error"
    headers: ClassVar[dict[str, str]] = {}
    """Headers of the answer besides those of every answer."""

    def __init__(self, detail: str, errors: tuple[FieldProblem, ...] = ()) -> None:
        super().__init__(detail)
        self.detail = detail
        self.errors = errors

    def problem(self, instance: str | None = None) -> Problem:
        """Return the problem document."""
        return Problem.of(
            self.slug, self.title, self.status, self.detail, errors=self.errors, instance=instance
        )


class InvalidRequest(ApiProblem):
    """A field of the request is not valid."""

    status, slug, title = 422, "invalid-request", "Invalid request"


class BadRequest(ApiProblem):
    """The request cannot be parsed."""

    status, slug, title = 400, "bad-request", "Bad request"


class Unauthorized(ApiProblem):
    """The request has no API key, or one that this service does not know."""

    status, slug, title = 401, "unauthorized", "API key needed"
    headers: ClassVar[dict[str, str]] = {"WWW-Authenticate": 'Bearer realm="isomatch"'}


class NotFound(ApiProblem):
    """There is nothing at this address."""

    status, slug, title = 404, "not-found", "Not found"


class ShapeNotFound(NotFound):
    """There is no shape with this id."""

    slug, title = "shape-not-found", "No such shape"


class PrototypeNotFound(NotFound):
    """There is no prototype with this id."""

    slug, title = "prototype-not-found", "No such prototype"


class AttributesNotFound(NotFound):
    """There is no attribute file with this id."""

    slug, title = "attributes-not-found", "No such attributes"


class JobNotFound(NotFound):
    """There is no job with this id."""

    slug, title = "job-not-found", "No such job"


class MethodNotAllowed(ApiProblem):
    """The method is not supported at this address."""

    status, slug, title = 405, "method-not-allowed", "Method not allowed"


class BodyStalled(ApiProblem):
    """The body of the request stalled."""

    status, slug, title = 408, "body-stalled", "Request timed out"


class ResultNotReady(ApiProblem):
    """The job has not ended."""

    status, slug, title = 409, "result-not-ready", "Result not ready"


class JobWithoutResult(ApiProblem):
    """The job failed or was cancelled, or is of a kind without a result."""

    status, slug, title = 409, "job-without-result", "Job without a result"


class UploadCancelled(ApiProblem):
    """The validation of the upload was cancelled."""

    status, slug, title = 409, "upload-cancelled", "Upload cancelled"


class IdempotencyKeyReused(ApiProblem):
    """The idempotency key was used for a different request."""

    status, slug, title = 409, "idempotency-key-reused", "Idempotency key reused"


class ResultExpired(ApiProblem):
    """The result is no longer kept."""

    status, slug, title = 410, "result-expired", "Result expired"


class ShapeExpired(ApiProblem):
    """The shape was not used for long, and is no longer kept."""

    status, slug, title = 410, "shape-expired", "Shape expired"


class GeometryNotKept(ApiProblem):
    """The record was stored by a version that kept no geometry."""

    status, slug, title = 410, "geometry-not-kept", "Geometry not kept"


class ContentLost(ApiProblem):
    """The bytes of a record are missing or damaged in the blob store."""

    status, slug, title = 410, "content-lost", "Content lost"


class PrototypeExpired(ApiProblem):
    """The prototype was not used for long, and is no longer kept."""

    status, slug, title = 410, "prototype-expired", "Prototype expired"


class AttributesExpired(ApiProblem):
    """The attribute file was not used for long and is no longer kept."""

    status, slug, title = 410, "attributes-expired", "Attributes expired"


class JobExpired(ApiProblem):
    """The job ended long ago, and is no longer kept."""

    status, slug, title = 410, "job-expired", "Job expired"


class ShapeDeleted(ApiProblem):
    """A shape was deleted meanwhile."""

    status, slug, title = 410, "shape-deleted", "Shape deleted"


class PrototypeDeleted(ApiProblem):
    """A prototype was deleted meanwhile."""

    status, slug, title = 410, "prototype-deleted", "Prototype deleted"


class AttributesDeleted(ApiProblem):
    """An attribute file was deleted in the meantime."""

    status, slug, title = 410, "attributes-deleted", "Attributes deleted"


class UploadTooLarge(ApiProblem):
    """The upload is over the limit."""

    status, slug, title = 413, "upload-too-large", "Upload too large"

    @classmethod
    def over(cls, limit: int) -> Self:
        """Return the problem that a body is longer than a limit in bytes."""
        return cls(f"The limit is {limit / 1e6:.4g} MB.")


class UnsupportedFormat(ApiProblem):
    """The format of the file is not supported."""

    status, slug, title = 415, "unsupported-format", "Unsupported format"


class EncodedBody(ApiProblem):
    """The body of the request has a content encoding, such as gzip."""

    status, slug, title = 415, "encoded-body", "Encoded body"


class UnknownShape(ApiProblem):
    """The request names a shape that does not exist."""

    status, slug, title = 422, "unknown-shape", "Unknown shape"


class UnknownPrototype(ApiProblem):
    """The request names a prototype that does not exist."""

    status, slug, title = 422, "unknown-prototype", "Unknown prototype"


class UnknownAttributes(ApiProblem):
    """The request names an attribute file that does not exist."""

    status, slug, title = 422, "unknown-attributes", "Unknown attributes"


class UnusableMesh(ApiProblem):
    """The file is not a usable mesh."""

    status, slug, title = 422, "unusable-mesh", "Not a usable mesh"


class UnusablePrototype(ApiProblem):
    """The file is not the archive of a prototype."""

    status, slug, title = 422, "unusable-prototype", "Not a usable prototype"


class UnusableAttributes(ApiProblem):
    """The file is not a usable file of attributes."""

    status, slug, title = 422, "unusable-attributes", "Not usable attributes"


class TooManyJobs(ApiProblem):
    """The caller has as many jobs queued as it may have."""

    status, slug, title = 429, "too-many-jobs", "Too many jobs"
    headers: ClassVar[dict[str, str]] = {"Retry-After": "10"}


class InternalError(ApiProblem):
    """An error of the service."""


class PictureNotReady(ApiProblem):
    """The picture is still being drawn."""

    status, slug, title = 503, "picture-not-ready", "Picture not ready"


class NewerVersion(ApiProblem):
    """The record was stored by a newer version; this one cannot read it."""

    status, slug, title = 503, "newer-version", "Stored by a newer version"
    headers: ClassVar[dict[str, str]] = {"Retry-After": "10"}


class StoreAway(ApiProblem):
    """Redis or the blob store cannot be reached."""

    status, slug, title = 503, "store-away", "Store cannot be reached"


class NotReady(ApiProblem):
    """The service is stopping, its store takes nothing, or no worker is alive."""

    status, slug, title = 503, "not-ready", "Not ready"


class QuotaUsedUp(ApiProblem):
    """The tenant keeps as many shapes or bytes as it may keep."""

    status, slug, title = 507, "quota-exceeded", "Quota used up"


class StorageFull(ApiProblem):
    """There is no space left to store what was sent."""

    status, slug, title = 507, "storage-full", "Storage full"
    headers: ClassVar[dict[str, str]] = {"Retry-After": "60"}


class Reported(ApiProblem):
    """The problem that a job reported, such as the validation of an upload."""

    def __init__(self, reported: Problem) -> None:
        super().__init__(reported.detail, reported.errors)
        self.reported = reported

    def problem(self, instance: str | None = None) -> Problem:
        """Return the problem document as it was reported."""
        return self.reported.model_copy(update={"instance": instance})
