"""Why a job failed, in the words of a problem document."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import ClassVar

from rq.timeouts import JobTimeoutException

from broker.contracts import FieldProblem, JobKind, JobRecord, Problem
from broker.store import NewerRecord
from solver.errors import MeshError, OptionError, PrototypeError, SolverError
from worker.pictures import NoAlternative


class Gone(Exception):  # noqa: N818 - said of what is needed
    """What a job needs was there when it was asked for, and is no longer."""

    slug: ClassVar[str]
    title: ClassVar[str]


class ShapeGone(Gone):
    """A shape was deleted, or expired, before the job that needs it could run.

    Parameters
    ----------
    shape
        Id of the shape.
    """

    slug, title = "shape-deleted", "Shape deleted"

    def __init__(self, shape: str) -> None:
        super().__init__(f"shape {shape} was deleted, or expired, before this job could run")


class UploadGone(Gone):
    """An upload waited for too long before the job that reads it could run."""

    slug, title = "upload-expired", "Upload expired"

    def __init__(self) -> None:
        super().__init__("The upload waited for too long to be read; send it again.")


class PrototypeGone(Gone):
    """A prototype was deleted, or expired, before the job that needs it could run.

    Parameters
    ----------
    prototype
        Id of the prototype.
    """

    slug, title = "prototype-deleted", "Prototype deleted"

    def __init__(self, prototype: str) -> None:
        gone = f"prototype {prototype} was deleted, or expired,"
        super().__init__(f"{gone} before this job could run")


class ResultGone(Gone):
    """The result to be drawn has expired or its shapes were deleted."""

    slug, title = "result-expired", "Result expired"


class UnusableShape(Exception):  # noqa: N818 - said of the shape
    """One of several shapes cannot be compared.

    Parameters
    ----------
    field
        Which of the shapes it is, as the request has it.
    reason
        What is wrong with it.
    """

    def __init__(self, field: str, reason: str) -> None:
        super().__init__(f"{field}: {reason}")
        self.field = FieldProblem(field=f"body.{field}", message=reason)


@contextmanager
def blaming(field: str) -> Iterator[None]:
    """Say which shape it is that cannot be compared.

    Parameters
    ----------
    field
        What the request calls the shape.

    Raises
    ------
    UnusableShape
        For any :class:`MeshError` inside.
    """
    try:
        yield
    except MeshError as error:
        raise UnusableShape(field, str(error)) from error


class TooLarge(Exception):  # noqa: N818 - said of the shape
    """A shape needs more memory than a job may take, which is known before it is begun.

    Parameters
    ----------
    vertices
        Of the shape.
    needed, left
        Bytes.
    """

    def __init__(self, vertices: int, needed: float, left: float) -> None:
        super().__init__(
            f"The spectrum of {vertices} vertices takes {needed / 2**30:.2g} GiB of memory, and a"
            f" job has {left / 2**30:.2g} GiB left; give `simplify`, for fewer vertices."
        )


class NotDelivered(Exception):  # noqa: N818 - said of the webhook
    """The receiver of a webhook did not take it."""


def newer_version() -> Problem:
    """Return the problem of a job that this version cannot read, or not all that it is about."""
    return Problem.of(
        "newer-version",
        "Asked for by a newer version",
        503,
        "A newer version of the service was asked for this than the worker is that took it up, with"
        " something that is unknown to the latter; ask again when all workers are upgraded.",
    )


def problem_of(error: Exception, record: JobRecord) -> Problem:
    """Return the problem of a job that raised an error.

    Parameters
    ----------
    error
        What the job raised. What is not expected gives no details away: they are in the logs.
    record
        The job.
    """
    match error:
        case OptionError():
            field = _asked(error.field, record)
            return Problem.of(
                "invalid-option",
                "Impossible parameters",
                422,
                f"{field}: {error.message}",
                errors=(FieldProblem(field=f"body.{field}", message=error.message),),
            )
        case MeshError() | UnusableShape():
            errors = (error.field,) if isinstance(error, UnusableShape) else ()
            return Problem.of("unusable-mesh", "Not a usable mesh", 422, str(error), errors)
        case PrototypeError():
            return Problem.of("unusable-prototype", "Not a usable prototype", 422, str(error))
        case SolverError():
            return Problem.of("no-solution", "No answer", 422, str(error))
        case TooLarge():
            return Problem.of("out-of-memory", "Out of memory", 422, str(error))
        case MemoryError():
            detail = "This needs more memory than a job may take; simplify the mesh."
            return Problem.of("out-of-memory", "Out of memory", 422, detail)
        case JobTimeoutException():
            detail = "This takes longer than a job may take; try fewer points or a time_limit."
            return Problem.of("timed-out", "Took too long", 422, detail)
        case NoAlternative():
            return Problem.of("invalid-request", "Invalid request", 422, str(error), (error.field,))
        case NewerRecord():
            return newer_version()
        case NotDelivered():
            return Problem.of("webhook-not-delivered", "Webhook not delivered", 424, str(error))
        case Gone():
            return Problem.of(error.slug, error.title, 410, str(error))
    return _unforeseen(record)


def _unforeseen(record: JobRecord) -> Problem:
    if record.kind is JobKind.VALIDATION:
        detail = "The file cannot be read as a mesh."
        return Problem.of("unusable-mesh", "Not a usable mesh", 422, detail)
    if record.kind is JobKind.PROTOTYPE_VALIDATION:
        detail = "The file cannot be read as the archive of a prototype."
        return Problem.of("unusable-prototype", "Not a usable prototype", 422, detail)
    detail = f"Something went wrong on our side; the logs of job {record.id} say what."
    return Problem.of("internal-error", "Internal error", 500, detail)


def _asked(field: str, record: JobRecord) -> str:
    """Address of an option in the request: a structure for all levels is no list there."""
    name, place, *rest = field.split(".", 2) if "." in field else (field, "")
    parameters = getattr(record.payload, "parameters", None)
    if place.isdigit() and not isinstance(getattr(parameters, name, ()), tuple):
        return ".".join([name, *rest])
    return field
