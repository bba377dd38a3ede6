"""Attributes of a job, the same for both clients."""

from datetime import datetime

from isomatch._models import JobRecord, JobState, JobWebhook, MatchSummary, Progress
from isomatch._problem import Problem


class RecordedJob:
    """A job as of the service's last answer."""

    def __init__(self, record: JobRecord) -> None:
        self._record = record

    def _remember(self, record: JobRecord) -> None:
        self._record = record

    def __eq__(self, other: object) -> bool:
        return self.id == other.id if isinstance(other, RecordedJob) else NotImplemented

    def __hash__(self) -> int:
        return hash(self.id)

    def __repr__(self) -> str:
        return f"<Job {self.id} {self.state}>"

    @property
    def record(self) -> JobRecord:
        """The service's last answer."""
        return self._record

    @property
    def id(self) -> str:
        """Id of the job."""
        return self._record.id

    @property
    def kind(self) -> str:
        """Kind, such as ``"match"``, ``"batch"``, ``"dissimilarities"`` or ``"registration"``."""
        return self._record.kind

    @property
    def batch(self) -> str | None:
        """Id of the batch that it is a match of; None for a job of its own."""
        return self._record.batch

    @property
    def state(self) -> JobState:
        """``"queued"``, ``"running"``, ``"succeeded"``, ``"failed"`` or ``"cancelled"``."""
        return self._record.state

    @property
    def source(self) -> str | None:
        """Id of the source of a match, batch or transfer, or of a registration's template."""
        return self._record.source

    @property
    def target(self) -> str | None:
        """Id of the target of a match or transfer; None for other kinds."""
        return self._record.target

    @property
    def shapes(self) -> tuple[str, ...]:
        """Ids of the job's shapes; of a large collection, the first ones."""
        return self._record.shapes

    @property
    def shape_count(self) -> int:
        """Number of shapes."""
        return self._record.shape_count

    @property
    def prototype(self) -> str | None:
        """Id of the prototype that is matched, or was uploaded or learned; None without one."""
        return self._record.prototype

    @property
    def summary(self) -> MatchSummary | None:
        """The answer of a match in brief, without its result; None before and for other kinds."""
        return self._record.summary

    @property
    def name(self) -> str | None:
        """Name of the learned prototype or of the upload; None for other kinds."""
        return self._record.name

    @property
    def names(self) -> tuple[str | None, ...]:
        """Names given with :attr:`shapes`, the source first; None for the stored one."""
        return self._record.names

    @property
    def stage(self) -> str:
        """Stage of a running job, and what it waits for, in words."""
        return self._record.stage

    @property
    def finished(self) -> bool:
        """True if the job has succeeded, failed or been cancelled."""
        return self._record.finished

    @property
    def progress(self) -> Progress:
        """Running stage and completed fraction."""
        return self._record.progress

    @property
    def position(self) -> int | None:
        """Number of jobs ahead in the queue; None once the job runs."""
        return self._record.position

    @property
    def waiting_for(self) -> str | None:
        """What a queued job waits for: ``"worker"``, as none is alive, or ``"turn"``; else None."""
        return self._record.waiting_for

    @property
    def created(self) -> datetime:
        """Time of queueing."""
        return self._record.created

    @property
    def started(self) -> datetime | None:
        """Start of the computation."""
        return self._record.started

    @property
    def ended(self) -> datetime | None:
        """End of the job."""
        return self._record.ended

    @property
    def caller(self) -> str | None:
        """Name of the API key that started the job; None without API keys."""
        return self._record.caller

    @property
    def webhook(self) -> JobWebhook | None:
        """Delivery of the job's webhook; None without one."""
        return self._record.webhook

    @property
    def error(self) -> Problem | None:
        """Problem that made the job fail; None otherwise."""
        return self._record.error
