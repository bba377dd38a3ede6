"""Running a job: claim it, call the function of its kind, record its end and its times.

A job function takes the payload and the :class:`JobContext`, loads what it needs from the store,
solves, stores what belongs in the store, and returns the result of kinds that have one.
"""

import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any, Final, TypeAlias

from redis.exceptions import RedisError

from broker import tracing
from broker.blobs import BlobsAway, NotMigrated
from broker.contracts import JobKind, JobRecord, UploadPayload, subject_of
from broker.queue import JobQueue
from broker.store import NewerRecord, Store
from broker.telemetry import logger
from broker.upkeep import evict_deleted, first_loss
from broker.webhooks import WebhookSettings, dispatch_next
from solver.errors import Cancelled
from worker.jobs.archives import validate_prototype
from worker.jobs.consistent_maps import map_consistently
from worker.jobs.context import JobContext, JobResult
from worker.jobs.delivery import deliver
from worker.jobs.drawing import draw
from worker.jobs.failures import JobTimedOut
from worker.jobs.matches import match
from worker.jobs.problems import problem_of, unreadable
from worker.jobs.progress import TOTAL, WAITING, Reporter
from worker.jobs.prototypes import learn
from worker.jobs.registrations import register
from worker.jobs.spectra import compute_spectrum
from worker.jobs.time_slices import run_time_slice
from worker.jobs.transfers import carry, validate_attributes
from worker.jobs.validation import validate_shape

JobFunction: TypeAlias = Callable[[Any, JobContext], JobResult | None]

FUNCTIONS: Final[Mapping[JobKind, JobFunction]] = {
    JobKind.VALIDATION: validate_shape,
    JobKind.PROTOTYPE_VALIDATION: validate_prototype,
    JobKind.SPECTRUM: compute_spectrum,
    JobKind.MATCH: match,
    JobKind.PROTOTYPE: learn,
    JobKind.TIME_SLICE: run_time_slice,
    JobKind.ATTRIBUTES_VALIDATION: validate_attributes,
    JobKind.TRANSFER: carry,
    JobKind.REGISTRATION: register,
    JobKind.CONSISTENT_MAPS: map_consistently,
    JobKind.PICTURE: draw,
    JobKind.WEBHOOK: deliver,
}
"""Function of each kind of jobs that RQ runs; dissimilarities are computed in time slices, and
batches are matches."""

BLOB_PATIENCE: Final = 20.0
"""Seconds for which a job waits at most for a blob store that is away before it is queued again:
with its repetitions, a minute and more."""

_LOOK: Final = 0.5
"""Seconds between two looks whether it is there."""

log = logger("isomatch.runner")


@dataclass(frozen=True)
class Runner:
    """Runs jobs, one at a time.

    Parameters
    ----------
    queue
        Submission of further jobs, and the store.
    name
        Id by which this runner holds jobs and locks; no two run at a time under the same.
    webhooks
        Settings of webhook deliveries.
    blob_patience
        Seconds for which a job waits for a blob store that is away before it is queued again.
    """

    queue: JobQueue
    name: str
    webhooks: WebhookSettings = field(default_factory=WebhookSettings)
    blob_patience: float = BLOB_PATIENCE

    def run(self, job_id: str) -> None:
        """Run a job to its end, unless it is no longer queued.

        Raises
        ------
        RedisError, BlobsAway, NotMigrated
            The store has not answered for too long; the job can be queued again.
        """
        record = self._claim(job_id)
        if record is None:
            return
        with _traced(record, self.queue.store):
            self._run(record)

    def _run(self, record: JobRecord) -> None:
        log.info("begun")
        start = time.perf_counter()
        reporter = Reporter(self.queue.store.jobs, record.id, self.name)
        if record.batch is not None and not self.queue.batches.begin(record.batch):
            self.queue.store.jobs.finish_cancelled(record.id, self.name)
            return
        self._call(JobContext(record, self.name, self.queue, reporter, self.webhooks), start)
        evict_deleted(self.queue.store, subject_of(record.payload).named)
        stages = reporter.seconds() | {TOTAL: time.perf_counter() - start}
        if record.started is not None:
            stages[WAITING] = (record.started - record.created).total_seconds()
        self.queue.store.counters.observe(record.kind, stages)
        if record.batch is not None:
            self.queue.batches.advance(record.batch)
        if record.kind is JobKind.WEBHOOK:
            dispatch_next(self.queue, self.webhooks)

    def _claim(self, job_id: str) -> JobRecord | None:
        jobs = self.queue.store.jobs
        if not jobs.claim(job_id, self.name):
            log.info("not to be run")
            return None
        try:
            record = jobs.get(job_id)
        except (NewerRecord, ValueError, KeyError) as error:
            log.error("damaged, or of a newer version, and unreadable", error=type(error).__name__)
            jobs.fail(job_id, self.name, unreadable(job_id, error))
            return None
        assert record is not None
        return record

    def _call(self, context: JobContext, start: float) -> None:
        record, jobs = context.record, context.store.jobs
        try:
            try:
                if record.batch is not None:
                    # A batch is admitted once, and may have a thousand results.
                    context.store.quotas.check(size=1)
                result = FUNCTIONS[record.kind](record.payload, context) or JobResult()
            finally:
                context.reporter.end()
            with tracing.span("storing"):
                kept = jobs.succeed(
                    record.id, self.name, result.document, result.arrays, result.summary
                )
        except BlobsAway:
            _await_blobs(context.store, self.blob_patience)
            raise
        except (RedisError, NotMigrated):
            raise
        except Cancelled:
            if jobs.finish_cancelled(record.id, self.name):
                _reject_upload(context)
            log.info("cancelled")
        except (Exception, JobTimedOut) as error:
            problem = problem_of(error, record)
            # A traceback only of unforeseen errors.
            log.warning("failed", problem=problem.slug, exc_info=problem.status == 500)
            tracing.failed(problem.slug)
            if jobs.fail(record.id, self.name, problem):
                _reject_upload(context)
        else:
            log.info("done", seconds=round(time.perf_counter() - start, 3), kept=kept)


def _await_blobs(store: Store, patience: float) -> None:
    """Wait for a blob store that is away: all queued jobs would be lost to it in a moment."""
    deadline = time.monotonic() + patience
    while time.monotonic() < deadline:
        try:
            store.blobs.check_owner()
        except BlobsAway:
            time.sleep(_LOOK)
        else:
            return


def _reject_upload(context: JobContext) -> None:
    """Delete the upload of a job that has ended; before, another run of it may need it."""
    upload = context.record.payload
    if isinstance(upload, UploadPayload):
        context.store.uploads.reject(upload.upload, upload.file_type, context.record.id)


@contextmanager
def _traced(record: JobRecord, store: Store) -> Iterator[None]:
    """Trace a job as a part of its request, with the time it waited, linked to a lost attempt."""
    if record.started is not None:
        tracing.past_span("in the queue", record.traceparent, record.created, record.started)
    with tracing.span(
        record.kind.value,
        kind="CONSUMER",
        parent=record.traceparent,
        linked=first_loss(store, record.id) if tracing.enabled() else None,
        job_id=record.id,
    ):
        yield
