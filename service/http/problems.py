"""What the API refuses, and how it says so: one class for each kind of problem.

::

    ApiProblem
    ├── InvalidRequest              422  a field of the request has no meaning; `errors` says which
    ├── BadRequest                  400  the request cannot be understood at all
    ├── Unauthorized                401  no API key came with the request, or none of ours
    ├── NotFound                    404  there is nothing at this address
    │   ├── ShapeNotFound
    │   ├── PrototypeNotFound
    │   └── JobNotFound
    ├── MethodNotAllowed            405  not what can be done at this address
    ├── HeadStalled                 408  the head of the request does not come in
    ├── BodyStalled                 408  the body of the request does not come in
    ├── ResultNotReady              409  the job has not ended
    ├── JobWithoutResult            409  the job failed or was cancelled, or makes no result
    ├── UploadCancelled             409  the validation of the upload was cancelled
    ├── IdempotencyKeyReused        409  the key came with another request before
    ├── ResultExpired               410  the result is no longer kept
    ├── ShapeExpired                410  the shape was not used for long
    ├── PrototypeExpired            410  the prototype was not used for long
    ├── JobExpired                  410  the job ended long ago
    ├── GeometryNotKept             410  the shape was stored before its geometry was
    ├── ShapeDeleted                410  a shape was deleted meanwhile
    ├── PrototypeDeleted            410  a prototype was deleted meanwhile
    ├── UploadTooLarge              413  the upload is over the limit
    ├── UnsupportedFormat           415  not a mesh format that is read
    ├── EncodedBody                 415  the body is compressed
    ├── UnknownShape                422  a match names a shape that does not exist
    ├── UnknownPrototype            422  a match names a prototype that does not exist
    ├── UnusableMesh                422  the file is not a usable mesh
    ├── UnusablePrototype           422  the file is not the archive of a prototype
    ├── TooManyJobs                 429  the caller has as many jobs queued as it may have
    ├── InternalError               500  our fault
    ├── StoreAway                   503  Redis cannot be reached
    ├── NewerVersion                503  a newer version stored it, and this one cannot read it
    ├── PictureNotReady             503  the picture takes longer to draw than a call may take
    └── NotReady                    503  stopping, nowhere to store anything, or no worker
"""

from typing import ClassVar

from broker.contracts import FieldProblem, Problem


class ApiProblem(Exception):  # noqa: N818 - a problem is what HTTP calls it
    """Root of what the API refuses.

    Parameters
    ----------
    detail
        This occurrence in words, and what to do about it.
    errors
        What is wrong with which field.
    """

    status: ClassVar[int] = 500
    slug: ClassVar[str] = "internal-error"
    title: ClassVar[str] = "Internal error"
    headers: ClassVar[dict[str, str]] = {}
    """Headers of the answer, besides those every answer has."""

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
    """A field of the request has no meaning."""

    status, slug, title = 422, "invalid-request", "Invalid request"


class BadRequest(ApiProblem):
    """The request cannot be understood at all."""

    status, slug, title = 400, "bad-request", "Bad request"


class Unauthorized(ApiProblem):
    """No API key came with the request, or none that this service knows."""

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


class JobNotFound(NotFound):
    """There is no job with this id."""

    slug, title = "job-not-found", "No such job"


class MethodNotAllowed(ApiProblem):
    """Not what can be done at this address."""

    status, slug, title = 405, "method-not-allowed", "Method not allowed"


class HeadStalled(ApiProblem):
    """The head of the request does not come in."""

    status, slug, title = 408, "head-stalled", "Request timed out"


class BodyStalled(ApiProblem):
    """The body of the request does not come in."""

    status, slug, title = 408, "body-stalled", "Request timed out"


class ResultNotReady(ApiProblem):
    """The job has not ended."""

    status, slug, title = 409, "result-not-ready", "Result not ready"


class JobWithoutResult(ApiProblem):
    """The job failed or was cancelled, or is of a kind that makes no result."""

    status, slug, title = 409, "job-without-result", "Job without a result"


class UploadCancelled(ApiProblem):
    """The validation of the upload was cancelled."""

    status, slug, title = 409, "upload-cancelled", "Upload cancelled"


class IdempotencyKeyReused(ApiProblem):
    """The idempotency key came with another request before."""

    status, slug, title = 409, "idempotency-key-reused", "Idempotency key reused"


class ResultExpired(ApiProblem):
    """The result is no longer kept."""

    status, slug, title = 410, "result-expired", "Result expired"


class ShapeExpired(ApiProblem):
    """The shape was not used for long, and is no longer kept."""

    status, slug, title = 410, "shape-expired", "Shape expired"


class GeometryNotKept(ApiProblem):
    """The shape was stored by a version that kept no geometry."""

    status, slug, title = 410, "geometry-not-kept", "Geometry not kept"


class PrototypeExpired(ApiProblem):
    """The prototype was not used for long, and is no longer kept."""

    status, slug, title = 410, "prototype-expired", "Prototype expired"


class JobExpired(ApiProblem):
    """The job ended long ago, and is no longer kept."""

    status, slug, title = 410, "job-expired", "Job expired"


class ShapeDeleted(ApiProblem):
    """A shape was deleted meanwhile."""

    status, slug, title = 410, "shape-deleted", "Shape deleted"


class PrototypeDeleted(ApiProblem):
    """A prototype was deleted meanwhile."""

    status, slug, title = 410, "prototype-deleted", "Prototype deleted"


class UploadTooLarge(ApiProblem):
    """The upload is over the limit."""

    status, slug, title = 413, "upload-too-large", "Upload too large"


class UnsupportedFormat(ApiProblem):
    """Not a mesh format that is read."""

    status, slug, title = 415, "unsupported-format", "Unsupported mesh format"


class EncodedBody(ApiProblem):
    """The body of the request is compressed, or encoded in another way."""

    status, slug, title = 415, "encoded-body", "Encoded body"


class UnknownShape(ApiProblem):
    """A match names a shape that does not exist."""

    status, slug, title = 422, "unknown-shape", "Unknown shape"


class UnknownPrototype(ApiProblem):
    """A match names a prototype that does not exist."""

    status, slug, title = 422, "unknown-prototype", "Unknown prototype"


class UnusableMesh(ApiProblem):
    """The file is not a usable mesh."""

    status, slug, title = 422, "unusable-mesh", "Not a usable mesh"


class UnusablePrototype(ApiProblem):
    """The file is not the archive of a prototype."""

    status, slug, title = 422, "unusable-prototype", "Not a usable prototype"


class TooManyJobs(ApiProblem):
    """The caller has as many jobs queued as it may have."""

    status, slug, title = 429, "too-many-jobs", "Too many jobs"
    headers: ClassVar[dict[str, str]] = {"Retry-After": "10"}


class InternalError(ApiProblem):
    """Our fault."""


class PictureNotReady(ApiProblem):
    """The picture takes longer to draw than a call may take."""

    status, slug, title = 503, "picture-not-ready", "Picture not ready"


class NewerVersion(ApiProblem):
    """A newer version stored this, and this one cannot read it."""

    status, slug, title = 503, "newer-version", "Stored by a newer version"
    headers: ClassVar[dict[str, str]] = {"Retry-After": "10"}


class StoreAway(ApiProblem):
    """Redis cannot be reached."""

    status, slug, title = 503, "store-away", "Store cannot be reached"


class NotReady(ApiProblem):
    """The service is stopping, its store takes nothing, or no worker is alive."""

    status, slug, title = 503, "not-ready", "Not ready"


class Reported(ApiProblem):
    """A problem that somebody else stated, such as the job that validated an upload."""

    def __init__(self, stated: Problem) -> None:
        super().__init__(stated.detail, stated.errors)
        self.stated = stated

    def problem(self, instance: str | None = None) -> Problem:
        """Return the problem document as it was stated."""
        return self.stated.model_copy(update={"instance": instance})
