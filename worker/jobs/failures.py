"""Failures of jobs, and the problem document of each.

::

    Gone                a shape, upload, prototype, attribute file or result expired or was deleted
    └── ShapeLost       the blob store has lost the content of a shape
    UnusableShape       one of several shapes cannot be used
    TooLarge            a shape needs more memory than a job may take
    TimeUp              the job's time was up before it had any part of its result
    NotDelivered        a webhook's receiver did not accept it

    JobTimedOut         the job took longer than it may; no Exception
"""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import ClassVar, Final

from broker.blobs import BlobError, BlobLost, BlobsFull
from broker.contracts import UNUSABLE, FieldProblem, JobKind, JobRecord, Problem, ProblemType
from broker.store import NewerRecord, QuotaExceeded, Store
from broker.upkeep import store_away
from solver.errors import (
    MeshError,
    MisplacedLandmarks,
    OptionError,
    PrototypeError,
    SolverError,
    TransferError,
)
from worker.pictures import NoAlternative


class Gone(Exception):
    """Data that a job needs expired or was deleted before the job ran."""

    type: ClassVar[ProblemType]


class ShapeGone(Gone):
    """A shape was deleted or expired before the job ran.

    Parameters
    ----------
    shape
        Id of the shape.
    """

    type = ProblemType.SHAPE_DELETED

    def __init__(self, shape: str) -> None:
        super().__init__(f"shape {shape} was deleted, or expired, before this job could run")


class ShapeLost(Gone):
    """The blob store has lost the content of a shape.

    Parameters
    ----------
    shape
        Id of the shape.
    reason
        What is wrong with it, as :class:`~broker.blobs.BlobLost` has it.
    """

    type = ProblemType.CONTENT_LOST

    def __init__(self, shape: str, reason: str) -> None:
        lost = f"the stored content of shape {shape} is {reason}"
        super().__init__(f"{lost}; delete it, and upload it again")


class UploadGone(Gone):
    """An upload expired before the job that validates it ran."""

    type = ProblemType.UPLOAD_EXPIRED

    def __init__(self) -> None:
        super().__init__("The upload waited for too long to be read; send it again.")


class PrototypeGone(Gone):
    """A prototype was deleted or expired before the job ran.

    Parameters
    ----------
    prototype
        Id of the prototype.
    """

    type = ProblemType.PROTOTYPE_DELETED

    def __init__(self, prototype: str) -> None:
        gone = f"prototype {prototype} was deleted, or expired,"
        super().__init__(f"{gone} before this job could run")


class AttributesGone(Gone):
    """An attribute file was deleted or expired before the job ran.

    Parameters
    ----------
    attributes
        Id of the file.
    """

    type = ProblemType.ATTRIBUTES_DELETED

    def __init__(self, attributes: str) -> None:
        gone = f"attribute file {attributes} was deleted, or expired,"
        super().__init__(f"{gone} before this job could run")


class ResultGone(Gone):
    """The result to be drawn, or the match to be carried along, has expired."""

    type = ProblemType.RESULT_EXPIRED


class UnusableShape(Exception):
    """One of several shapes cannot be used.

    Parameters
    ----------
    field
        Field of the request that names the shape.
    reason
        What is wrong with it.
    """

    def __init__(self, field: str, reason: str) -> None:
        super().__init__(f"{field}: {reason}")
        self.field = FieldProblem(field=f"body.{field}", message=reason)


@contextmanager
def attributed_to(field: str) -> Iterator[None]:
    """Attribute mesh errors to a field of the request.

    Parameters
    ----------
    field
        Field that names the shape.

    Raises
    ------
    UnusableShape
        For any :class:`MeshError` inside.
    """
    try:
        yield
    except MeshError as error:
        raise UnusableShape(field, str(error)) from error


@contextmanager
def content_of(shape: str) -> Iterator[None]:
    """Name the shape whose content is read.

    Parameters
    ----------
    shape
        Id of the shape.

    Raises
    ------
    ShapeLost
        For any :class:`~broker.blobs.BlobLost` inside.
    """
    try:
        yield
    except BlobLost as error:
        raise ShapeLost(shape, error.reason) from error


def none_usable(
    shapes: Sequence[str], reasons: Sequence[str | None], store: Store
) -> ShapeGone | UnusableShape:
    """Return why a job of several shapes has none left: one that is gone, or the first reason.

    Parameters
    ----------
    shapes
        Ids, as `shapes` of the request has them.
    reasons
        Why each cannot be used, or ``None``; at least one is not.
    store
        Store of the shapes.
    """
    failed = [(place, reason) for place, reason in enumerate(reasons) if reason is not None]
    kept = store.shapes.records([shapes[place] for place, _ in failed])
    for (place, _), record in zip(failed, kept, strict=True):
        if record is None:
            return ShapeGone(shapes[place])
    place, reason = failed[0]
    return UnusableShape(f"shapes.{place}", reason)


class TooLarge(Exception):
    """A shape needs more memory than a job may take, as estimated before the computation.

    Parameters
    ----------
    vertices
        Number of vertices.
    needed, left
        Bytes.
    """

    def __init__(self, vertices: int, needed: float, left: float) -> None:
        super().__init__(
            f"The spectrum of {vertices} vertices takes {needed / 2**30:.2g} GiB of memory, and a"
            f" job has {left / 2**30:.2g} GiB left; give `simplify`, for fewer vertices."
        )


SHAPE_FAILURES: Final = (UnusableShape, ShapeGone, ShapeLost, TooLarge, MemoryError)
"""Failures of one of several shapes, without which a job of a collection goes on."""

_OUT_OF_MEMORY: Final = "this needs more memory than a job may take; simplify the mesh"


def reason_of(error: Exception) -> str:
    """Return the reason why one of several shapes failed, for the report on that shape."""
    if isinstance(error, MemoryError):
        return _OUT_OF_MEMORY
    return error.field.message if isinstance(error, UnusableShape) else str(error)


class TimeUp(Exception):
    """The time of a job was up before it had any part of its result."""


class JobTimedOut(BaseException):
    """A job took longer than it may, wherever it was.

    No :class:`Exception`: readers of damaged files take any of those for damage.
    """


class NotDelivered(Exception):
    """The receiver of a webhook did not accept it."""


def newer_version() -> Problem:
    """Return the problem of a job whose record, or data, only a newer version can read."""
    return Problem.of(
        ProblemType.NEWER_VERSION,
        "A newer version of the service was asked for this than the worker is that took it up, with"
        " something that is unknown to the latter; ask again when all workers are upgraded.",
    )


def unreadable(job_id: str, error: Exception | JobTimedOut) -> Problem:
    """Return the problem of a job whose record cannot be read."""
    return newer_version() if isinstance(error, NewerRecord) else _internal(job_id)


def problem_of(error: Exception | JobTimedOut, record: JobRecord) -> Problem:
    """Return the problem of a job that raised an error.

    Parameters
    ----------
    error
        Exception that the job raised. Details of unforeseen ones are only in the logs.
    record
        The job.
    """
    uploaded = record.kind in UNUSABLE
    file = (FieldProblem(field="body.file", message=str(error)),) if uploaded else ()
    match error:
        case OptionError():
            return _impossible(error, record)
        case MeshError() | UnusableShape():
            errors = (error.field,) if isinstance(error, UnusableShape) else file
            return Problem.of(ProblemType.UNUSABLE_MESH, str(error), errors)
        case PrototypeError():
            return Problem.of(ProblemType.UNUSABLE_PROTOTYPE, str(error), file)
        case TransferError():
            return _not_transferred(error, file)
        case SolverError():
            return Problem.of(ProblemType.NO_SOLUTION, str(error))
        case TooLarge() | MemoryError():
            detail = reason_of(error)
            stated = f"{detail[:1].upper()}{detail[1:].removesuffix('.')}."
            return Problem.of(ProblemType.OUT_OF_MEMORY, stated)
        case JobTimedOut() | TimeUp():
            return Problem.of(ProblemType.TIMED_OUT, _timed_out(record))
        case NoAlternative():
            return Problem.of(ProblemType.INVALID_REQUEST, str(error), (error.field,))
        case NewerRecord():
            return newer_version()
        case NotDelivered():
            return Problem.of(ProblemType.WEBHOOK_NOT_DELIVERED, str(error))
        case Gone():
            return Problem.of(error.type, str(error))
    return _store_failed(error) or _unforeseen(record)


def _not_transferred(error: TransferError, file: tuple[FieldProblem, ...]) -> Problem:
    if not isinstance(error, MisplacedLandmarks):
        return Problem.of(ProblemType.UNUSABLE_ATTRIBUTES, str(error), file)
    landmarks = FieldProblem(field="body.landmarks", message=str(error))
    return Problem.of(ProblemType.MISPLACED_LANDMARKS, str(error), (landmarks,))


def _timed_out(record: JobRecord) -> str:
    """Return what happened and what can be done, which only some requests can do by parameters."""
    if record.kind in UNUSABLE:
        return "Reading the file takes longer than a job may take; send a smaller or simpler one."
    if hasattr(record.payload, "shapes"):
        return "This takes longer than a job may take; give fewer shapes, or simplify them."
    if hasattr(getattr(record.payload, "parameters", None), "time_limit"):
        return "This takes longer than a job may take; try fewer points or a time_limit."
    return "This takes longer than a job may take; simplify the shapes."


def _store_failed(error: Exception | JobTimedOut) -> Problem | None:
    if isinstance(error, BlobsFull):
        detail = "There is no space left to store what this makes; try again later."
        return Problem.of(ProblemType.STORAGE_FULL, detail)
    if isinstance(error, QuotaExceeded):
        return Problem.of(ProblemType.QUOTA_EXCEEDED, error.detail)
    if isinstance(error, BlobLost):
        lost = f"The stored content that this needs is {error.reason}"
        detail = f"{lost}; delete it, and upload or request it"
        return Problem.of(ProblemType.CONTENT_LOST, f"{detail} again.")
    return store_away() if isinstance(error, BlobError) else None


def _impossible(error: OptionError, record: JobRecord) -> Problem:
    field = _asked(error.field, record)
    # A picture or file of a result is requested by its path.
    place = "path" if record.kind is JobKind.PICTURE else "body"
    return Problem.of(
        ProblemType.INVALID_OPTION,
        f"{field}: {error.message}",
        errors=(FieldProblem(field=f"{place}.{field}", message=error.message),),
    )


def _unforeseen(record: JobRecord) -> Problem:
    if record.kind in UNUSABLE:
        unusable = UNUSABLE[record.kind]
        detail = f"The file cannot be read: {unusable.title[:1].lower()}{unusable.title[1:]}."
        return Problem.of(unusable, detail)
    return _internal(record.id)


def _internal(job_id: str) -> Problem:
    detail = f"Something went wrong on our side; the logs of job {job_id} say what."
    return Problem.of(ProblemType.INTERNAL_ERROR, detail)


def _asked(field: str, record: JobRecord) -> str:
    """Path of an option in the request, where a structure for all levels is not a list."""
    name, place, *rest = field.split(".", 2) if "." in field else (field, "")
    parameters = getattr(record.payload, "parameters", None)
    if place.isdigit() and not isinstance(getattr(parameters, name, ()), tuple):
        return ".".join([name, *rest])
    return field
