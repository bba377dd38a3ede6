"""Submission of jobs: the record is stored and the job queued in one transaction.

A job that is done in time slices is not queued itself: its time slices are, and each of them queues
the next. Nor is a batch: its matches are.
"""

from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import BinaryIO, Final, Self

from redis.client import Pipeline
from redis.exceptions import OutOfMemoryError

from broker.blobs import BlobError
from broker.contracts import (
    BatchPayload,
    DeliveryPayload,
    IdempotencyRecord,
    JobKind,
    JobRecord,
    JobState,
    Payload,
    PicturePayload,
    RequestOrigin,
    SpectrumKey,
    SpectrumPayload,
    UploadPayload,
    ValidationPayload,
)
from broker.queue.batches import Batches
from broker.queue.new_jobs import (
    NO_REQUEST,
    new_batch_match,
    new_job,
    new_time_slice,
)
from broker.queue.prefetch import SpectralPayload, needed_by_others, wanted_spectra
from broker.queue.rq_queues import RqQueues
from broker.queue.settings import QueueSettings
from broker.queue.workers import any_worker, worker_states
from broker.store import (
    BlobReference,
    Quota,
    QuotaExceeded,
    Store,
    are_running,
    size_of,
    text,
    transact,
)
from broker.telemetry import logger

_MARKED_SECONDS: Final = 86400
"""Seconds for which a key names the job that draws a picture, computes a spectrum or delivers a
webhook: longer than that waits. It counts only until the job has ended."""

_IN_PARTS: Final = JobKind.DISSIMILARITIES, JobKind.BATCH
"""Kinds of jobs that are not queued themselves: their time slices or matches are."""

log = logger("isomatch.queue")


@dataclass(frozen=True)
class JobQueue:
    """Submission of jobs.

    Parameters
    ----------
    store
        The jobs' records.
    settings
        Limits of the jobs.
    """

    store: Store
    settings: QueueSettings

    @cached_property
    def rq(self) -> RqQueues:
        """The queues themselves, in the store's Redis."""
        return RqQueues(self.store.client, self.settings, self.store.keys.tenant)

    @cached_property
    def batches(self) -> Batches:
        """The matches of batches."""
        return Batches(self.store, self.rq)

    def of(self, tenant: str) -> Self:
        """Return the submission of a tenant's jobs."""
        return replace(self, store=self.store.of(tenant))

    def submit(self, payload: Payload, context: RequestOrigin = NO_REQUEST) -> JobRecord:
        """Submit a job as :meth:`submit_or_replay` does, and return it."""
        return self.submit_or_replay(payload, context)[0]

    def submit_or_replay(self, payload: Payload, context: RequestOrigin) -> tuple[JobRecord, bool]:
        """Store a new job and queue it, both or neither.

        The spectra that it needs, and that are neither cached nor queued, are queued before it. Of
        a batch, as many matches are queued as there are workers.

        Parameters
        ----------
        payload
            Kind and parameters of the job.
        context
            The request. If an equal one had the same idempotency key, its job is returned.

        Returns
        -------
        The job, and whether an equal request stored it.

        Raises
        ------
        KeyReused
            The idempotency key was used for a different request.
        TooManyQueued
            The caller has as many jobs queued as it may have, or its tenant as many jobs.
        QuotaExceeded
            The tenant has as many bytes as it may have.
        """
        admitted = self._admitted(new_job(payload, context), context.idempotency)
        if isinstance(payload, SpectralPayload):
            for key in wanted_spectra(payload, self.store.shapes):
                self._submit_spectrum(key, context)
        record = self._submit(admitted, context.idempotency)
        if isinstance(payload, BatchPayload):
            self.batches.advance(record.id)
        # Without a key it was stored by this very call, and the reply was lost.
        return record, record is not admitted and context.idempotency is not None

    def earlier_job(self, context: RequestOrigin) -> JobRecord | None:
        """Return the job of an equal request with the same idempotency key, if there was one.

        Raises
        ------
        KeyReused
            The idempotency key was used for a different request.
        """
        idempotency = context.idempotency
        job_id = None if idempotency is None else self.store.admission.job_of(idempotency)
        return None if job_id is None else self.store.jobs.get(job_id)

    def submit_validation(
        self,
        payload: UploadPayload,
        data: bytes | BinaryIO,
        context: RequestOrigin = NO_REQUEST,
        admitted: JobRecord | None = None,
        digest: str | None = None,
    ) -> str:
        """Queue the validation of an upload, unless an equal one is being validated.

        Parameters
        ----------
        payload
            The upload.
        data
            Its bytes, or a file of them.
        context
            The request.
        admitted
            The job, if it was admitted already.
        digest
            SHA-256 of the bytes, if it is known.

        Returns
        -------
        str
            Id of the job that validates it.

        Raises
        ------
        TooManyQueued
            The caller or its tenant has as many uploads being validated as it may have.
        BlobsFull, BlobsAway
            The bytes cannot be stored.
        QuotaExceeded
            The tenant has as many shapes or bytes as it may have.
        """
        record = admitted or new_job(payload, context)
        stored: BlobReference | None = None
        is_shape = isinstance(payload, ValidationPayload)
        size, quota = size_of(data), self.store.quotas.get()
        uploads, named = self.store.uploads, (payload.upload, payload.file_type)

        def store_candidate(pipe: Pipeline) -> Callable[[], object]:
            nonlocal stored
            self.admit(record, quota)
            stored = stored or uploads.put_candidate(*named, data, record.id, digest)
            try:
                # Once more, in the transaction: others may have been taken meanwhile.
                self.store.quotas.check(size, is_shape, pipe, quota)
            except QuotaExceeded:
                uploads.discard_candidate(*named, stored, record.id)
                raise
            return partial(uploads.add_candidate, *named, stored, record.id, pipe)

        try:
            self.store.quotas.check(size, is_shape, quota=quota)
            # A candidate that was put for nothing is left to the sweep: if the reply to the
            # transaction was lost, the holder may be this very job.
            holder = self._submit_once(
                record, self.store.keys.candidate_job(*named), store_candidate
            )
        except (BlobError, QuotaExceeded):
            self.store.admission.release(record)
            raise
        if holder != record.id:
            self.store.admission.release(record)
        return holder

    def admit(self, record: JobRecord, quota: Quota | None = None) -> None:
        """Count a job that is about to be submitted towards the limits; it is counted once.

        Parameters
        ----------
        record
            The job.
        quota
            The tenant's quota, if it is known already.

        Raises
        ------
        TooManyQueued
            The caller or its tenant has as many as it may have.
        """
        quota = quota or self.store.quotas.get()
        self.store.admission.admit(record, self.settings.max_queued_jobs, quota.jobs)

    def submit_picture(self, payload: PicturePayload, context: RequestOrigin = NO_REQUEST) -> str:
        """Queue the drawing of a picture unless it is being drawn; return the job that draws it."""
        return self._submit_once(new_job(payload, context), self._drawing(payload))

    def is_drawn(self, payload: PicturePayload) -> bool:
        """Return whether a job is queued to draw a picture, or draws it."""
        return self.store.jobs.named_by([self._drawing(payload)]) != [None]

    def submit_delivery(
        self, choose: Callable[[], tuple[DeliveryPayload, RequestOrigin] | None]
    ) -> None:
        """Queue the delivery of a webhook, unless one of the tenant is in flight.

        Parameters
        ----------
        choose
            Returns the delivery, None if none is due. It is called while none is in flight; if
            another process queues one after what it has read, its choice is dropped.
        """
        marker = self.store.keys.delivery

        def attempt(pipe: Pipeline) -> JobRecord | None:
            chosen = choose() if self._live_job(marker, pipe) is None else None
            if chosen is None:
                return None
            payload, context = chosen
            record = new_job(payload, context)
            self.rq.enqueue(record, pipe)
            self.store.jobs.create(record, pipe)
            pipe.set(marker, record.id, ex=_MARKED_SECONDS)
            self.store.webhooks.begin(payload.job, payload.attempt, pipe)
            return record

        record = transact(self.store.client, attempt)
        if record is not None:
            _log_queued(record)

    def spectra_ahead(self, record: JobRecord) -> int:
        """Return the number of spectra that a job needs and others compute, or will before it."""
        payload = record.payload
        if not isinstance(payload, SpectralPayload):
            return 0
        jobs = self._spectrum_jobs(wanted_spectra(payload, self.store.shapes))
        return sum(job is not None for job in jobs)

    def submit_time_slice(self, record: JobRecord) -> None:
        """Queue another time slice of a job, unless the job has ended."""
        number = self.store.chunks.number_time_slice(record.id)
        if number is None:
            return
        time_slice = new_time_slice(record, number)

        def attempt(pipe: Pipeline) -> None:
            if self._stored(time_slice, pipe) is None:
                self._enqueue_time_slice(record, time_slice, pipe)

        transact(self.store.client, attempt)

    def job(self, job_id: str) -> JobRecord | None:
        """Return a job in its present state, or None if it does not exist (any more).

        A match of a batch is a job before it is in a queue: queued, or cancelled with its batch.
        """
        jobs = self.store.jobs
        # What waited may have been queued meanwhile.
        return jobs.get(job_id) or self.batches.waiting_match(job_id) or jobs.get(job_id)

    def expired(self, job_id: str) -> bool:
        """Return whether a job that does not exist has expired."""
        return self.store.jobs.expired(job_id) or self.batches.expired(job_id)

    def cancel(self, job_id: str) -> None:
        """Cancel a job that has not ended, with all its parts and the spectra it alone needs."""
        self.batches.queue_waiting(job_id)
        before = self.store.jobs.state(job_id)
        after = self.store.jobs.cancel(job_id)
        if before is JobState.QUEUED and after is JobState.CANCELLED:
            self.rq.withdraw(job_id)
        record = self.store.jobs.readable(job_id)
        if record is None:
            return
        if after in (JobState.RUNNING, JobState.CANCELLED):
            self._withdraw_spectra(record)
        if record.batch is not None:
            # Where Redis is full, the next match is queued by recovery.
            with suppress(OutOfMemoryError):
                self.batches.advance(record.batch)
        elif after is JobState.CANCELLED and isinstance(record.payload, UploadPayload):
            self.store.uploads.reject(record.payload.upload, record.payload.file_type, job_id)
        elif after is JobState.CANCELLED and record.kind is JobKind.BATCH:
            # The others will not be queued any more.
            for match in self.batches.live(record):
                self.cancel(match)
            self.store.chunks.delete(job_id)

    def resume(self, record: JobRecord) -> None:
        """Queue a lost job again."""
        if record.kind is JobKind.DISSIMILARITIES:
            self.submit_time_slice(record)
        elif record.kind is JobKind.BATCH:
            self.batches.advance(record.id)
        else:
            self.rq.enqueue(record)

    def other_jobs_wait(self, job_id: str) -> bool:
        """Return whether jobs other than the time slices of a job wait in the queues."""
        waiting = self.rq.waiting()
        states = self.store.chunks.time_slices(job_id).values() if waiting else ()
        return waiting > sum(state is JobState.QUEUED for state in states)

    def giving_way(self, records: Iterable[JobRecord]) -> set[str]:
        """Return the ids of running jobs that wait, because none of their parts is running."""
        running = [
            record.id
            for record in records
            if record.state is JobState.RUNNING and record.kind in _IN_PARTS
        ]
        if not running:
            return set()
        with self.store.client.pipeline(transaction=False) as pipe:
            for job in running:
                pipe.smembers(self.store.keys.time_slices(job))
            parts = dict(zip(running, pipe.execute(), strict=True))
        whose = {text(part): job for job in running for part in parts[job]}
        worked_on = zip(whose.values(), are_running(self.store, list(whose)), strict=True)
        return set(running) - {job for job, is_running in worked_on if is_running}

    def workers(self) -> int:
        """Return the number of live workers."""
        return len(worker_states(self.store.client))

    def any_worker(self) -> bool:
        """Return whether a worker is alive."""
        return any_worker(self.store.client)

    def _enqueue(self, record: JobRecord, pipe: Pipeline) -> None:
        if record.kind is JobKind.DISSIMILARITIES:
            self._enqueue_time_slice(record, new_time_slice(record, 1), pipe)
            self.store.chunks.create(record.id, pipe)
        elif record.kind is JobKind.BATCH:
            self.batches.enqueue(new_batch_match(record, 0), pipe)
        else:
            self.rq.enqueue(record, pipe)

    def _enqueue_time_slice(self, record: JobRecord, time_slice: JobRecord, pipe: Pipeline) -> None:
        self.rq.enqueue(time_slice, pipe)
        self.store.jobs.create(time_slice, pipe)
        self.store.chunks.add_time_slice(record.id, time_slice.id, pipe)

    def _admitted(self, record: JobRecord, idempotency: IdempotencyRecord | None) -> JobRecord:
        """Admit a job, which gets the id of an equal earlier request."""
        if idempotency is not None:
            jobs, admission = self.store.jobs, self.store.admission
            reserved = admission.reserve(idempotency, record.id)
            # In this order: a job that is stored meanwhile has not expired.
            if jobs.expired(reserved) and not jobs.exists(reserved):
                # What is left of the matches of a batch would count as those of the new one.
                admission.forget(idempotency, reserved)
                reserved = admission.reserve(idempotency, record.id)
            record = record.model_copy(update={"id": reserved})
        if record.is_listed:
            quota = self.store.quotas.get()
            if self.store.jobs.state(record.id) is None:
                self.store.quotas.check(size=1, quota=quota)
            self.admit(record, quota)
        return record

    def _submit(self, record: JobRecord, idempotency: IdempotencyRecord | None) -> JobRecord:
        """Store an admitted job and queue it; return that of an equal request that was first."""

        def attempt(pipe: Pipeline) -> JobRecord:
            known = self._stored(record, pipe)
            if known is not None:
                return known
            # First, because RQ begins the transaction itself.
            self._enqueue(record, pipe)
            self.store.jobs.create(record, pipe)
            if idempotency is not None:
                self.store.admission.remember(idempotency, record.id, pipe)
            return record

        submitted = transact(self.store.client, attempt)
        if submitted is record:
            _log_queued(record)
        return submitted

    def _submit_once(
        self,
        record: JobRecord,
        marker: str,
        prepare: Callable[[Pipeline], Callable[[], object]] | None = None,
    ) -> str:
        """Queue a job unless the one that a key names has not ended; return that one's id.

        Parameters
        ----------
        record
            The job.
        marker
            The key.
        prepare
            Called before the transaction, which is repeated if keys that it watches change; returns
            what sets the key in the transaction.
        """

        def mark(pipe: Pipeline) -> Callable[[], object]:
            return partial(pipe.set, marker, record.id, ex=_MARKED_SECONDS)

        def attempt(pipe: Pipeline) -> str:
            if self._stored(record, pipe) is not None:
                return record.id
            holder = self._live_job(marker, pipe)
            if holder is not None:
                return holder
            finish = (prepare or mark)(pipe)
            self.rq.enqueue(record, pipe)
            self.store.jobs.create(record, pipe)
            finish()
            return record.id

        holder = transact(self.store.client, attempt)
        if holder == record.id:
            _log_queued(record)
        return holder

    def _drawing(self, payload: PicturePayload) -> str:
        """Key that names the job that draws a picture."""
        return self.store.keys.picture_job(payload.job, payload.variant)

    def _stored(self, record: JobRecord, pipe: Pipeline) -> JobRecord | None:
        """Return a job that is about to be stored, if it is already, and watch its key.

        The reply to the transaction that stored it may have been lost, or a request with the same
        idempotency key was first.
        """
        pipe.watch(self.store.keys.job(record.id))
        return self.store.jobs.get(record.id)

    def _live_job(self, marker: str, pipe: Pipeline) -> str | None:
        """Return the job that a key names, unless it has ended, and watch the key."""
        pipe.watch(marker)
        return self.store.jobs.named_by([marker])[0]

    def _spectrum_jobs(self, spectra: Sequence[SpectrumKey]) -> list[str | None]:
        """Return the job that is queued to compute each spectrum, or computes it."""
        return self.store.jobs.named_by(list(map(self.store.keys.spectrum_job, spectra)))

    def _submit_spectrum(self, key: SpectrumKey, context: RequestOrigin) -> None:
        spectra = self.store.spectra
        job = new_job(
            SpectrumPayload(
                shape=key.shape,
                eigenpairs=key.eigenpairs,
                largest_component=key.largest_component,
                simplify=key.simplify,
                file_type=key.file_type,
            ),
            context,
        )
        # One that only another tenant has used is queued, too: this tenant must not see that there
        # is one, by its place in the queue.
        if not (spectra.known([key])[0] and spectra.has(key)):
            self._submit_once(job, self.store.keys.spectrum_job(key))

    def _withdraw_spectra(self, record: JobRecord) -> None:
        """Withdraw the queued spectra of a cancelled job that no other live job needs.

        A job that is being submitted may count on one; it computes the spectrum itself then.
        """
        if not isinstance(record.payload, SpectralPayload):
            return
        wanted = wanted_spectra(record.payload, self.store.shapes)
        jobs = {
            key: job
            for key, job in zip(wanted, self._spectrum_jobs(wanted), strict=True)
            if job is not None and self.store.jobs.state(job) is JobState.QUEUED
        }
        needed = needed_by_others(record, jobs, self.store) if jobs else set()
        for key, job in jobs.items():
            if key in needed:
                continue
            # First, so that whoever needs it from now on queues it again.
            self.store.spectra.unmark_queued(key, job)
            if self.store.jobs.cancel(job) is JobState.CANCELLED:
                self.rq.withdraw(job)


def _log_queued(record: JobRecord) -> None:
    log.info("queued", job_id=record.id, kind=record.kind.value)
