"""Problem documents of failed jobs."""

from broker.blobs import BlobError, BlobLost, BlobsFull
from broker.contracts import UNUSABLE, FieldProblem, JobKind, JobRecord, Problem, ProblemType
from broker.store import NewerRecord, QuotaExceeded
from broker.upkeep import store_away
from solver.errors import (
    MeshError,
    MisplacedLandmarks,
    OptionError,
    PrototypeError,
    SolverError,
    TransferError,
)
from worker.jobs.failures import (
    Gone,
    JobTimedOut,
    NotDelivered,
    TimeUp,
    TooLarge,
    UnusableShape,
    reason_of,
)
from worker.pictures import NoAlternative


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


def timed_out(record: JobRecord | None) -> Problem:
    """Return the problem of a job, unreadable perhaps, that took longer than it may."""
    what, remedy = "This", "simplify the shapes"
    payload = getattr(record, "payload", None)
    if record is not None and record.kind in UNUSABLE:
        what, remedy = "Reading the file", "send a smaller or simpler one"
    elif hasattr(payload, "shapes"):
        remedy = "give fewer shapes, or simplify them"
    elif hasattr(getattr(payload, "parameters", None), "time_limit"):
        remedy = "try fewer points or a time_limit"
    detail = f"{what} takes longer than a job may take; {remedy}."
    return Problem.of(ProblemType.TIMED_OUT, detail)


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
            return timed_out(record)
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
