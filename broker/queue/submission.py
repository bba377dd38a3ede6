"""The way into the queues: a job's record is stored and the job queued, both or neither.

Jobs that are done in turns are not queued themselves: their turns are, and each queues at the end
again.
"""

from dataclasses import dataclass

from redis.client import Pipeline
from redis.exceptions import WatchError

from broker.contracts import (
    JobKind,
    JobRecord,
    MatchPayload,
    Once,
    Order,
    PrototypePayload,
    SpectrumKey,
    SpectrumPayload,
    UploadPayload,
    ValidationPayload,
)
from broker.queue.channels import Channels
from broker.queue.prefetch import wanted_spectra
from broker.queue.records import UNASKED, new_job, turn_of
from broker.store import LISTED_KINDS, Uploads, keys
from broker.telemetry import logger

log = logger("isomatch.queue")


@dataclass(frozen=True)
class JobQueue(Channels):
    """The way into the queues; made of a store and settings, as :class:`Channels`."""

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

    def submit_turn(self, record: JobRecord) -> None:
        """Queue another turn of a job that is done in turns, unless it has ended."""
        number = self.store.parts.number_turn(record.id)
        if number is None:
            return
        with self.store.client.pipeline() as pipe:
            self._hand_over_turn(record, number, pipe)
            pipe.execute()

    def resume(self, record: JobRecord) -> None:
        """Hand a job that was lost to RQ again."""
        if record.kind is JobKind.DISSIMILARITIES:
            self.submit_turn(record)
        else:
            self.enqueue(record)

    def uploads(self, payload: UploadPayload) -> Uploads:
        """Return where an upload waits for its validation."""
        shape = isinstance(payload, ValidationPayload)
        return self.store.shapes if shape else self.store.prototypes

    def _hand_over(self, record: JobRecord, pipe: Pipeline) -> None:
        if record.kind is JobKind.DISSIMILARITIES:
            self._hand_over_turn(record, 1, pipe)
            self.store.parts.create(record.id, pipe)
        else:
            self.enqueue(record, pipe)

    def _hand_over_turn(self, record: JobRecord, number: int, pipe: Pipeline) -> None:
        turn = turn_of(record, number)
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


def _say_queued(record: JobRecord) -> None:
    log.info("queued", job_id=record.id, kind=record.kind.value)
