"""The queue: jobs go in by the name of what runs them, so the API imports none of it.

Three queues, served in this order: ``interactive`` (somebody waits for the answer of a request),
``structures`` (spectra that matches will need), ``matches``. Jobs that are done in turns are not
queued themselves: their turns are, and each queues at the end again.
"""

from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Final
from uuid import uuid4

from pydantic import Field
from pydantic_settings import BaseSettings
from redis.client import Pipeline
from redis.exceptions import WatchError
from rq import Queue, Retry
from rq.exceptions import InvalidJobOperation, NoSuchJobError
from rq.job import Callback, Job
from rq.serializers import JSONSerializer

from worker.contracts import (
    JobKind,
    JobRecord,
    JobState,
    MatchPayload,
    Once,
    Order,
    Payload,
    PrototypePayload,
    SpectrumKey,
    SpectrumPayload,
    TurnPayload,
    UploadPayload,
    ValidationPayload,
)
from worker.environment import FROM_ENVIRONMENT
from worker.prefetch import wanted_spectra
from worker.store import Store, keys
from worker.store.jobs import LISTED_KINDS
from worker.store.uploads import Uploads
from worker.telemetry import logger
from worker.workforce import depths, worker_states

INTERACTIVE: Final = "interactive"
STRUCTURES: Final = "structures"
MATCHES: Final = "matches"
QUEUES: Final = (INTERACTIVE, STRUCTURES, MATCHES)

_QUEUE_OF: Final = {
    JobKind.VALIDATION: INTERACTIVE,
    JobKind.PROTOTYPE_VALIDATION: INTERACTIVE,
    JobKind.PICTURE: INTERACTIVE,
    JobKind.WEBHOOK: INTERACTIVE,
    JobKind.SPECTRUM: STRUCTURES,
    JobKind.MATCH: MATCHES,
    JobKind.DISSIMILARITIES: MATCHES,
    JobKind.PROTOTYPE: MATCHES,
    JobKind.TURN: MATCHES,
}
_ENTRY_POINT: Final = "worker.jobs.run"
_STOPPED: Final = "worker.jobs.stopped"
_RQ_RESULT_TTL: Final = 300
_RQ_FAILURE_TTL: Final = 86400
_RQ_RETRIES: Final = 10
"""More than any job gets: how often one is repeated is decided in our own record."""


class QueueSettings(BaseSettings):
    """How many jobs there may be and how long they may take; from ``ISOMATCH_*``."""

    model_config = FROM_ENVIRONMENT

    job_timeout: int = Field(
        default=3600, ge=1, description="Seconds a match or a spectrum may take."
    )
    interactive_timeout: int = Field(
        default=300, ge=1, description="Seconds a validation or a picture may take."
    )
    heartbeat: int = Field(
        default=5,
        ge=1,
        le=10,
        description="Seconds between two heartbeats of a worker that is busy; after four without"
        " one its job is given to another. API and workers need the same.",
    )
    max_queued_jobs: int = Field(
        default=1000, ge=0, description="Jobs a caller may have queued at a time; 0 for any number."
    )

    def timeout(self, kind: JobKind) -> int:
        """Seconds a job of this kind may take."""
        interactive = _QUEUE_OF[kind] == INTERACTIVE
        return self.interactive_timeout if interactive else self.job_timeout


log = logger("isomatch.queue")

UNASKED: Final = Order()
"""How a job comes about that no request asked for."""


def new_job(payload: Payload, order: Order = UNASKED) -> JobRecord:
    """Return the record of a new job.

    Parameters
    ----------
    payload
        What it is to do.
    order
        How it was asked for.
    """
    return JobRecord(
        id=uuid4().hex,
        payload=payload,
        created=datetime.now(UTC),
        request_id=order.request_id,
        caller=order.caller,
        # Jobs that only serve the one that was asked for have an end of their own.
        webhook=order.webhook if payload.kind in LISTED_KINDS else None,
    )


@dataclass(frozen=True)
class JobQueue:
    """The way into the queues.

    Parameters
    ----------
    store
        Where the jobs' records are.
    settings
        How long jobs may take.
    """

    store: Store
    settings: QueueSettings

    def submit(self, record: JobRecord, once: Once | None = None) -> JobRecord:
        """Store a new job and queue it, both or neither.

        Parameters
        ----------
        record
            The job.
        once
            How the request is known; the job of an equal one before it is returned instead.

        Raises
        ------
        KeyReused
            The idempotency key came with another request.
        TooManyQueued
            The caller has as many jobs queued as it may have.
        """
        record = self._agreed(record, once)
        self._admit(record)
        with self.store.client.pipeline() as pipe:
            while True:
                if once is not None:
                    pipe.watch(keys.job(record.id))  # type: ignore[no-untyped-call]
                    known = self.store.jobs.get(record.id)
                    if known is not None:
                        return known
                try:
                    # RQ begins the transaction itself, which must be empty then.
                    self._hand_over(record, pipe)
                    self.store.jobs.create(record, pipe)
                    if once is not None:
                        self.store.orders.note(once, record.id, pipe)
                    pipe.execute()
                except WatchError:
                    # An equal request came in between.
                    continue
                _say_queued(record)
                return record

    def asked_before(self, order: Order) -> JobRecord | None:
        """Return the job that an equal request with the same key made, if there was one.

        Raises
        ------
        KeyReused
            The idempotency key came with another request.
        """
        job_id = None if order.once is None else self.store.orders.job_of(order.once)
        return None if job_id is None else self.store.jobs.get(job_id)

    def submit_validation(self, payload: UploadPayload, data: bytes, order: Order = UNASKED) -> str:
        """Queue the validation of an upload, unless an equal one is being validated.

        Parameters
        ----------
        payload
            What is known of the upload.
        data
            Its bytes.
        order
            How it came.

        Returns
        -------
        str
            The job that validates it.
        """
        record = new_job(payload, order)
        uploads = self.uploads(payload)
        with self.store.client.pipeline() as pipe:
            while True:
                holder = uploads.validated_by(payload.upload, payload.file_type, pipe)
                state = None if holder is None else self.store.jobs.state(holder)
                if holder is not None and state is not None and not state.ended:
                    return holder
                try:
                    self.enqueue(record, pipe)
                    self.store.jobs.create(record, pipe)
                    uploads.add_candidate(payload.upload, payload.file_type, data, record.id, pipe)
                    pipe.execute()
                except WatchError:
                    # An equal upload came in between.
                    continue
                _say_queued(record)
                return record.id

    def submit_match(self, payload: MatchPayload, order: Order = UNASKED) -> JobRecord:
        """Queue a match, and before it the spectra it needs that nobody has or computes yet.

        Raises
        ------
        KeyReused, TooManyQueued
            As by :meth:`submit`.
        """
        return self._submit_after_spectra(payload, order)

    def submit_prototype(self, payload: PrototypePayload, order: Order = UNASKED) -> JobRecord:
        """Queue the learning of a prototype, and before it the spectra it needs, likewise.

        Raises
        ------
        KeyReused, TooManyQueued
            As by :meth:`submit`.
        """
        return self._submit_after_spectra(payload, order)

    def enqueue(self, record: JobRecord, pipe: Pipeline | None = None) -> None:
        """Hand a job that has a record to RQ, as part of a transaction if one is given."""
        self.queue(record.kind).enqueue_call(
            _ENTRY_POINT,
            args=(record.id,),
            job_id=record.id,
            timeout=self.settings.timeout(record.kind),
            result_ttl=_RQ_RESULT_TTL,
            failure_ttl=_RQ_FAILURE_TTL,
            retry=Retry(max=_RQ_RETRIES),
            on_stopped=Callback(_STOPPED),
            description=f"{record.kind.value} {record.id}",
            meta={
                "kind": record.kind.value,
                "request_id": record.request_id,
                "caller": record.caller,
            },
            pipeline=pipe,
        )

    def submit_turn(self, record: JobRecord) -> None:
        """Queue another turn of a job that is done in turns."""
        number = self.store.parts.number_turn(record.id)
        with self.store.client.pipeline() as pipe:
            self._hand_over_turn(record, number, pipe)
            pipe.execute()

    def resume(self, record: JobRecord) -> None:
        """Hand a job that was lost to RQ again."""
        if record.kind is JobKind.DISSIMILARITIES:
            self.submit_turn(record)
        else:
            self.enqueue(record)

    def withdraw(self, job_id: str) -> None:
        """Take a job that was cancelled out of its queue."""
        try:
            job = Job.fetch(job_id, connection=self.store.client, serializer=JSONSerializer)
            job.delete()
        except (NoSuchJobError, InvalidJobOperation):
            return

    def position(self, record: JobRecord) -> int | None:
        """Return how many jobs will be started before a queued one; None once it has begun."""
        queue = self.queue(record.kind)
        in_turns = record.kind is JobKind.DISSIMILARITIES
        place = queue.get_job_position(_turn_id(record, 1) if in_turns else record.id)
        if place is None:
            return None
        served_before = QUEUES[: QUEUES.index(queue.name)]
        return int(place) + sum(self._named(name).count for name in served_before)

    def others_wait(self, job_id: str) -> bool:
        """Whether anything is queued beside the turns of a job."""
        queued = sum(waits for waits, _ in depths(self.queues()).values())
        states = self.store.parts.turns(job_id).values() if queued else ()
        return queued > sum(state is JobState.QUEUED for state in states)

    def uploads(self, payload: UploadPayload) -> Uploads:
        """Return where an upload waits for its validation."""
        shape = isinstance(payload, ValidationPayload)
        return self.store.shapes if shape else self.store.prototypes

    def queue(self, kind: JobKind) -> Queue:
        """Return the queue of a kind of jobs."""
        return self._named(_QUEUE_OF[kind])

    def queues(self) -> list[Queue]:
        """Return all queues, in the order they are served."""
        return [self._named(name) for name in QUEUES]

    def workers(self) -> int:
        """Return the number of workers that are alive and ready."""
        return len(worker_states(self.store.client))

    def _hand_over(self, record: JobRecord, pipe: Pipeline) -> None:
        if record.kind is JobKind.DISSIMILARITIES:
            self._hand_over_turn(record, 1, pipe)
            self.store.parts.create(record.id, pipe)
        else:
            self.enqueue(record, pipe)

    def _hand_over_turn(self, record: JobRecord, number: int, pipe: Pipeline) -> None:
        turn = JobRecord(
            id=_turn_id(record, number),
            payload=TurnPayload(job=record.id),
            created=datetime.now(UTC),
            request_id=record.request_id,
            caller=record.caller,
        )
        self.enqueue(turn, pipe)
        self.store.jobs.create(turn, pipe)
        self.store.parts.add_turn(record.id, turn.id, pipe)

    def _admit(self, record: JobRecord) -> None:
        if record.kind in LISTED_KINDS:
            limit = self.settings.max_queued_jobs
            self.store.orders.admit(record.caller, record.id, limit)

    def _agreed(self, record: JobRecord, once: Once | None) -> JobRecord:
        if once is None:
            return record
        return record.model_copy(update={"id": self.store.orders.reserve(once, record.id)})

    def _submit_after_spectra(
        self, payload: MatchPayload | PrototypePayload, order: Order
    ) -> JobRecord:
        record = self._agreed(new_job(payload, order), order.once)
        self._admit(record)
        for key in wanted_spectra(payload, self.store.shapes):
            self._submit_spectrum(key, order)
        return self.submit(record, order.once)

    def _submit_spectrum(self, key: SpectrumKey, order: Order) -> None:
        spectra = self.store.spectra
        job = new_job(
            SpectrumPayload(
                shape=key.shape,
                eigenpairs=key.eigenpairs,
                largest_component=key.largest_component,
                simplify=key.simplify,
            ),
            order,
        )
        if not spectra.has(key) and spectra.order(key, job.id, self.settings.job_timeout):
            self.submit(job)

    def _named(self, name: str) -> Queue:
        return Queue(name, connection=self.store.client, serializer=JSONSerializer)


def _say_queued(record: JobRecord) -> None:
    log.info("queued", job_id=record.id, kind=record.kind.value)


def _turn_id(record: JobRecord, number: int) -> str:
    return f"{record.id}-{number}"
