"""Problems that the API answers with, one class for each type (RFC 9457).

::

    ApiProblem
    ├── InvalidRequest              422  a field of the request is not valid; `errors` says which
    ├── BadRequest                  400  the request cannot be parsed
    ├── Unauthorized                401  the request has no API key, or an unknown one
    ├── CrossSiteRequest            403  a web page of another site sent it, and no key is needed
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
    ├── UploadTooLarge              413  the body of the request is over the limit
    ├── UnsupportedFormat           415  the format of the file, or the type of the body, is not
    ├── EncodedBody                 415  the body is compressed
    ├── MisdirectedRequest          421  the host name is not accepted, and no key is needed
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
    ├── TooManyUploads              503  there is no space for the body of the upload
    ├── NotReady                    503  stopping, the store takes nothing, or no worker
    ├── QuotaUsedUp                 507  the tenant has as much as it may have
    └── StorageFull                 507  the disk, or the object storage, is full
"""

from typing import ClassVar, Final, Self

from broker.contracts import FieldProblem, Problem, ProblemType

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

    type: ClassVar[ProblemType] = ProblemType.INTERNAL_ERROR
    headers: ClassVar[dict[str, str]] = {}
    """Headers of the answer besides those of every answer."""

    def __init__(self, detail: str, errors: tuple[FieldProblem, ...] = ()) -> None:
        super().__init__(detail)
        self.detail = detail
        self.errors = errors

    def problem(self, instance: str | None = None) -> Problem:
        """Return the problem document."""
        return Problem.of(self.type, self.detail, self.errors, instance)


class InvalidRequest(ApiProblem):
    """A field of the request is not valid."""

    type = ProblemType.INVALID_REQUEST


class BadRequest(ApiProblem):
    """The request cannot be parsed."""

    type = ProblemType.BAD_REQUEST


class Unauthorized(ApiProblem):
    """The request has no API key, or one that this service does not know."""

    type = ProblemType.UNAUTHORIZED
    headers: ClassVar[dict[str, str]] = {"WWW-Authenticate": 'Bearer realm="isomatch"'}


class CrossSiteRequest(ApiProblem):
    """A web page of another site sent the request, and no key is needed."""

    type = ProblemType.CROSS_SITE_REQUEST


class NotFound(ApiProblem):
    """There is nothing at this address."""

    type = ProblemType.NOT_FOUND


class ShapeNotFound(NotFound):
    """There is no shape with this id."""

    type = ProblemType.SHAPE_NOT_FOUND


class PrototypeNotFound(NotFound):
    """There is no prototype with this id."""

    type = ProblemType.PROTOTYPE_NOT_FOUND


class AttributesNotFound(NotFound):
    """There is no attribute file with this id."""

    type = ProblemType.ATTRIBUTES_NOT_FOUND


class JobNotFound(NotFound):
    """There is no job with this id."""

    type = ProblemType.JOB_NOT_FOUND


class MethodNotAllowed(ApiProblem):
    """The method is not supported at this address."""

    type = ProblemType.METHOD_NOT_ALLOWED


class BodyStalled(ApiProblem):
    """The body of the request stalled."""

    type = ProblemType.BODY_STALLED


class ResultNotReady(ApiProblem):
    """The job has not ended."""

    type = ProblemType.RESULT_NOT_READY


class JobWithoutResult(ApiProblem):
    """The job failed or was cancelled, or is of a kind without a result."""

    type = ProblemType.JOB_WITHOUT_RESULT


class UploadCancelled(ApiProblem):
    """The validation of the upload was cancelled."""

    type = ProblemType.UPLOAD_CANCELLED


class IdempotencyKeyReused(ApiProblem):
    """The idempotency key was used for a different request."""

    type = ProblemType.IDEMPOTENCY_KEY_REUSED


class ResultExpired(ApiProblem):
    """The result is no longer kept."""

    type = ProblemType.RESULT_EXPIRED


class ShapeExpired(ApiProblem):
    """The shape was not used for long, and is no longer kept."""

    type = ProblemType.SHAPE_EXPIRED


class GeometryNotKept(ApiProblem):
    """The record was stored by a version that kept no geometry."""

    type = ProblemType.GEOMETRY_NOT_KEPT


class ContentLost(ApiProblem):
    """The bytes of a record are missing or damaged in the blob store."""

    type = ProblemType.CONTENT_LOST


class PrototypeExpired(ApiProblem):
    """The prototype was not used for long, and is no longer kept."""

    type = ProblemType.PROTOTYPE_EXPIRED


class AttributesExpired(ApiProblem):
    """The attribute file was not used for long and is no longer kept."""

    type = ProblemType.ATTRIBUTES_EXPIRED


class JobExpired(ApiProblem):
    """The job ended long ago, and is no longer kept."""

    type = ProblemType.JOB_EXPIRED


class ShapeDeleted(ApiProblem):
    """A shape was deleted meanwhile."""

    type = ProblemType.SHAPE_DELETED


class PrototypeDeleted(ApiProblem):
    """A prototype was deleted meanwhile."""

    type = ProblemType.PROTOTYPE_DELETED


class AttributesDeleted(ApiProblem):
    """An attribute file was deleted in the meantime."""

    type = ProblemType.ATTRIBUTES_DELETED


class UploadTooLarge(ApiProblem):
    """The body of the request is over the limit."""

    type = ProblemType.UPLOAD_TOO_LARGE

    @classmethod
    def over(
        cls, limit: int, advice: str = "send a smaller file, such as a simplified mesh"
    ) -> Self:
        """Return the problem that a body is longer than a limit in bytes."""
        return cls(f"The limit is {limit / 1e6:.4g} MB; {advice}.")


class UnsupportedFormat(ApiProblem):
    """The format of the file, or the type of the body, is not supported."""

    type = ProblemType.UNSUPPORTED_FORMAT


class EncodedBody(ApiProblem):
    """The body of the request has a content encoding, such as gzip."""

    type = ProblemType.ENCODED_BODY


class MisdirectedRequest(ApiProblem):
    """The host name of the request is not accepted, and no key is needed."""

    type = ProblemType.MISDIRECTED_REQUEST


class UnknownShape(ApiProblem):
    """The request names a shape that does not exist."""

    type = ProblemType.UNKNOWN_SHAPE


class UnknownPrototype(ApiProblem):
    """The request names a prototype that does not exist."""

    type = ProblemType.UNKNOWN_PROTOTYPE


class UnknownAttributes(ApiProblem):
    """The request names an attribute file that does not exist."""

    type = ProblemType.UNKNOWN_ATTRIBUTES


class UnusableMesh(ApiProblem):
    """The file is not a usable mesh."""

    type = ProblemType.UNUSABLE_MESH


class UnusablePrototype(ApiProblem):
    """The file is not the archive of a prototype."""

    type = ProblemType.UNUSABLE_PROTOTYPE


class UnusableAttributes(ApiProblem):
    """The file is not a usable file of attributes."""

    type = ProblemType.UNUSABLE_ATTRIBUTES


class TooManyJobs(ApiProblem):
    """The caller has as many jobs queued, or uploads being validated, as it may have."""

    type = ProblemType.TOO_MANY_JOBS
    headers: ClassVar[dict[str, str]] = {"Retry-After": "10"}


class InternalError(ApiProblem):
    """An error of the service."""


class PictureNotReady(ApiProblem):
    """The picture is still being drawn."""

    type = ProblemType.PICTURE_NOT_READY


class NewerVersion(ApiProblem):
    """The record was stored by a newer version; this one cannot read it."""

    type = ProblemType.NEWER_VERSION
    headers: ClassVar[dict[str, str]] = {"Retry-After": "10"}


class StoreAway(ApiProblem):
    """Redis or the blob store cannot be reached."""

    type = ProblemType.STORE_AWAY


class TooManyUploads(ApiProblem):
    """Too many uploads are on their way."""

    type = ProblemType.TOO_MANY_UPLOADS
    headers: ClassVar[dict[str, str]] = {"Retry-After": "10"}


class NotReady(ApiProblem):
    """The service is stopping, its store takes nothing, or no worker is alive."""

    type = ProblemType.NOT_READY


class QuotaUsedUp(ApiProblem):
    """The tenant keeps as many shapes or bytes as it may keep."""

    type = ProblemType.QUOTA_EXCEEDED


class StorageFull(ApiProblem):
    """There is no space left to store what was sent."""

    type = ProblemType.STORAGE_FULL
    headers: ClassVar[dict[str, str]] = {"Retry-After": "60"}


class Reported(ApiProblem):
    """The problem that a job reported, such as the validation of an upload."""

    def __init__(self, reported: Problem) -> None:
        super().__init__(reported.detail, reported.errors)
        self.reported = reported

    def problem(self, instance: str | None = None) -> Problem:
        """Return the problem document as it was reported."""
        return self.reported.model_copy(update={"instance": instance})
