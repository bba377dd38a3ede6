"""A job as the service said it is, without asking: what both clients' jobs have in common."""

from datetime import datetime

from isomatch._models import JobRecord, JobState, JobWebhook, Progress
from isomatch._problem import Problem


class RecordedJob:
    """A job as the service last described it."""

    def __init__(self, record: JobRecord) -> None:
        self._record = record

    def _remember(self, record: JobRecord) -> None:
        self._record = record

    def __repr__(self) -> str:
        return f"<Job {self.id} {self.state}>"

    @property
    def record(self) -> JobRecord:
        """Everything the service said last, as one value."""
        return self._record

    @property
    def id(self) -> str:
        """The job's id."""
        return self._record.id

    @property
    def kind(self) -> str:
        """What the job does, such as ``"match"``."""
        return self._record.kind

    @property
    def state(self) -> JobState:
        """One of queued, running, succeeded, failed, cancelled."""
        return self._record.state

    @property
    def source(self) -> str | None:
        """Id of a match's source, a shape or a prototype; None for other kinds."""
        return self._record.source

    @property
    def target(self) -> str | None:
        """Id of a match's target; None for other kinds."""
        return self._record.target

    @property
    def shapes(self) -> tuple[str, ...]:
        """Ids of the shapes it is of, each once; of a large collection, the first."""
        return self._record.shapes

    @property
    def shape_count(self) -> int:
        """How many shapes it is of."""
        return self._record.shape_count

    @property
    def prototype(self) -> str | None:
        """Id of the prototype that is matched, or that was uploaded; None for none."""
        return self._record.prototype

    @property
    def name(self) -> str | None:
        """Name of the prototype that is learned, or of an upload; None for other kinds."""
        return self._record.name

    @property
    def finished(self) -> bool:
        """Whether the job has ended, in whatever way."""
        return self._record.finished

    @property
    def progress(self) -> Progress:
        """How far it is."""
        return self._record.progress

    @property
    def position(self) -> int | None:
        """Place in the queue; None once it runs."""
        return self._record.position

    @property
    def created(self) -> datetime:
        """When it was queued."""
        return self._record.created

    @property
    def started(self) -> datetime | None:
        """When it began to run."""
        return self._record.started

    @property
    def ended(self) -> datetime | None:
        """When it ended."""
        return self._record.ended

    @property
    def caller(self) -> str | None:
        """Name of the API key it was asked for with; None where the service asks for none."""
        return self._record.caller

    @property
    def webhook(self) -> JobWebhook | None:
        """Whom its end is told to, and how that went; None for nobody."""
        return self._record.webhook

    @property
    def error(self) -> Problem | None:
        """Why it failed."""
        return self._record.error
