"""What the service answers, as typed values.

Fields this version does not know are left aside, so that a newer service can be spoken to; fields
that are missing, or numbers that are not finite, are errors.
"""

from datetime import datetime
from typing import Generic, Literal, TypeAlias, TypeVar

from pydantic import BaseModel, ConfigDict, FiniteFloat

from isomatch._problem import Problem

JobState: TypeAlias = Literal["queued", "running", "succeeded", "failed", "cancelled"]

ItemT = TypeVar("ItemT")


class Answer(BaseModel):
    """Anything the service answers: unchangeable, and open to fields of newer services."""

    model_config = ConfigDict(frozen=True, extra="ignore")


class Shape(Answer):
    """An uploaded shape.

    Attributes
    ----------
    id
        Content hash: the same bytes have the same id.
    name
        The name given at upload, or the name of the file.
    file_type
        Mesh format, such as ``"off"``.
    bytes
        Size of the uploaded file.
    vertices, faces
        Their numbers, after repair.
    area
        Surface area, in the square of the file's unit of length.
    components
        Number of connected components.
    closed
        Whether the surface has no boundary.
    has_colors
        Whether the vertices have colours.
    warnings
        What was repaired.
    created
        When it was uploaded.
    """

    id: str
    name: str
    file_type: str
    bytes: int
    vertices: int
    faces: int
    area: FiniteFloat
    components: int
    closed: bool
    has_colors: bool
    warnings: tuple[str, ...]
    created: datetime


class Progress(Answer):
    """How far a job is.

    Attributes
    ----------
    stage
        What is being done.
    fraction
        Share of the whole job that is done, 0 to 1.
    """

    stage: str
    fraction: FiniteFloat


class JobWebhook(Answer):
    """Whom the end of a job is told to, and how that went.

    Attributes
    ----------
    url
        The receiver's address, without its query.
    state
        ``"pending"``, ``"delivered"``, or ``"failed"`` after the last attempt.
    attempts, last_attempt, next_attempt
        How often and when it was tried last, and when it is tried again.
    status, error
        HTTP status the receiver answered with last, and what went wrong.
    """

    url: str
    state: Literal["pending", "delivered", "failed"]
    attempts: int
    last_attempt: datetime | None
    status: int | None
    error: str | None
    next_attempt: datetime | None


class JobRecord(Answer):
    """A job as the service last described it; :class:`isomatch.Job` says what the fields mean."""

    id: str
    kind: str
    state: JobState
    source: str | None = None
    target: str | None = None
    shapes: tuple[str, ...] = ()
    shape_count: int = 0
    prototype: str | None = None
    name: str | None = None
    progress: Progress
    created: datetime
    started: datetime | None
    ended: datetime | None
    position: int | None
    error: Problem | None
    caller: str | None
    webhook: JobWebhook | None

    @property
    def finished(self) -> bool:
        """Whether the job has ended, in whatever way."""
        return self.state in ("succeeded", "failed", "cancelled")


class Page(Answer, Generic[ItemT]):
    """One page of a listing, and the cursor of the next."""

    items: tuple[ItemT, ...]
    next_cursor: str | None
