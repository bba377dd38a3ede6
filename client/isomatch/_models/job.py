"""Jobs, their progress, and the delivery of their webhooks."""

from datetime import datetime
from typing import Annotated, Literal, TypeAlias

from pydantic import FiniteFloat

from isomatch._models.answer import Answer
from isomatch._models.arguments import READ_AS_TEXT
from isomatch._models.match_summary import MatchSummary
from isomatch._problem import Problem

JobState: TypeAlias = Literal["queued", "running", "succeeded", "failed", "cancelled"]

AnsweredState: TypeAlias = Annotated[JobState, READ_AS_TEXT]
"""State in an answer."""


class Progress(Answer):
    """Progress of a job.

    Attributes
    ----------
    stage
        Name of the running stage.
    fraction
        Completed share of the whole job, 0 to 1.
    """

    stage: str
    fraction: FiniteFloat


class JobWebhook(Answer):
    """Delivery of the webhook of a job.

    Attributes
    ----------
    url
        Address of the receiver, without its query.
    state
        ``"pending"``, ``"delivered"``, or ``"failed"`` after the last attempt.
    attempts, last_attempt, next_attempt
        Number of attempts, and the times of the last and the next one.
    status, error
        HTTP status of the receiver's last answer, and the error of the last attempt.
    """

    url: str
    state: Annotated[Literal["pending", "delivered", "failed"], READ_AS_TEXT]
    attempts: int
    last_attempt: datetime | None
    status: int | None
    error: str | None
    next_attempt: datetime | None


class JobRecord(Answer):
    """A job as the service last described it; :class:`isomatch.Job` documents the fields."""

    id: str
    kind: str
    state: AnsweredState
    batch: str | None = None
    source: str | None = None
    target: str | None = None
    shapes: tuple[str, ...] = ()
    shape_count: int = 0
    prototype: str | None = None
    summary: MatchSummary | None = None
    name: str | None = None
    names: tuple[str | None, ...] = ()
    progress: Progress
    created: datetime
    started: datetime | None
    ended: datetime | None
    position: int | None
    waiting_for: Annotated[Literal["worker", "turn"], READ_AS_TEXT] | None = None
    error: Problem | None
    caller: str | None
    webhook: JobWebhook | None

    @property
    def finished(self) -> bool:
        """True if the job has succeeded, failed or been cancelled."""
        return self.state in ("succeeded", "failed", "cancelled")

    @property
    def stage(self) -> str:
        """Stage of a running job, and what it waits for, in words."""
        if self.waiting_for == "worker":
            return "no worker is alive"
        if self.state == "running" and self.waiting_for == "turn":
            return f"{self.progress.stage}, waiting for its turn"
        if self.state != "queued":
            return self.progress.stage
        return f"{self.position} jobs ahead" if self.position else "next in the queue"
