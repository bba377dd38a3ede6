"""Stages of comparing a collection: signatures of the shapes, ranges of pairs, the result."""

import time
from collections.abc import Callable
from dataclasses import dataclass
from datetime import UTC, datetime
from functools import cached_property
from typing import Final

import numpy as np

from broker.contracts import PAIRS, RESULT, STRUCTURES, DissimilaritiesPayload, JobRecord
from broker.store import ClaimedChunk
from solver.arrays import FloatArray
from solver.control import Control
from solver.similarity import (
    Signature,
    SignatureCollection,
    SimilarityOptions,
    dissimilarities,
    number_of_pairs,
    pairs_between,
)
from worker.jobs.context import JobContext
from worker.jobs.dissimilarities import arrays_of, result_of
from worker.jobs.options import options_of
from worker.jobs.progress import TOTAL, WAITING
from worker.jobs.shape_names import shape_names
from worker.jobs.signatures import cached_signatures, compute_signature

CHUNK_SECONDS: Final = 0.5
"""Seconds that a range of pairs is to take: long beside a claim, short beside a time slice."""

TIMED_PAIRS: Final = 200
"""Pairs whose comparison is timed, to choose the size of the ranges."""

SIGNATURES_SHARE: Final = 0.6
"""Share of the progress for the signatures if none is cached."""

RESULT_SHARE: Final = 0.02
"""Share of the progress for the result."""


@dataclass(frozen=True)
class Comparison:
    """A job that compares a collection, in the hands of one time slice.

    Parameters
    ----------
    job, payload
        The job.
    context
        Context of the time slice.
    control
        Cancellation of the job.
    """

    job: JobRecord
    payload: DissimilaritiesPayload
    context: JobContext
    control: Control

    def open_next_stage(self, done: str) -> None:
        """Open the stage that follows a stage that is done."""
        following: dict[str, Callable[[], None]] = {
            "": self._open_signatures,
            STRUCTURES: self._open_pairs,
            PAIRS: self._open_result,
        }
        if done in following:
            following[done]()

    def compute(self, chunk: ClaimedChunk) -> bytes:
        """Return the result of a chunk: a signature, or the dissimilarities of a range of pairs.

        Raises
        ------
        UnusableShape, ShapeGone, OptionError
            A shape cannot be compared.
        Cancelled
            The job was cancelled.
        """
        self.control.check()
        if chunk.stage == STRUCTURES:
            return compute_signature(self.payload, chunk.number, self.context, self.control)
        return self._compare(chunk.number)

    def succeed(self) -> None:
        """Make the result of all chunks, and end the job."""
        store, job = self.context.store, self.job
        found = store.chunks.results(job.id, PAIRS)
        data = b"".join(found[number] for number in range(len(found)))
        values = np.frombuffer(data, dtype="<f8").astype(np.float64)
        known = shape_names(self.payload.shapes, self.payload.names, store)
        names = tuple(name or "" for name in known)
        result = result_of(self.payload, values, self._timings(), names)
        result = result.model_copy(update={"job": job.id})
        document, arrays = result.model_dump_json().encode(), arrays_of(result, values)
        waiting = self._started() - job.created
        timings = self._timings() | {WAITING: waiting.total_seconds()}
        if store.jobs.succeed(job.id, job.id, document, arrays):
            store.counters.observe(job.kind, timings)

    def _open_signatures(self) -> None:
        store, job, count = self.context.store, self.job, len(self.payload.shapes)
        known = cached_signatures(self.payload, store)
        share = SIGNATURES_SHARE * (1.0 - len(known) / count)
        if store.chunks.open_stage(job.id, "", STRUCTURES, count, share, known=known):
            self._queue_time_slices(count - len(known))

    def _open_pairs(self) -> None:
        store, job, count = self.context.store, self.job, len(self.payload.shapes)
        signatures = store.chunks.results(job.id, STRUCTURES)
        collection = SignatureCollection.of(
            [Signature.from_bytes(signatures[place]) for place in range(count)],
            self.payload.parameters.points,
        )
        store.chunks.set_input(job.id, PAIRS, collection.to_bytes())
        size = self._chunk_size(collection)
        ranges = -(-number_of_pairs(count) // size)
        record = store.jobs.get(job.id)
        done = 0.0 if record is None else record.progress.fraction
        share = 1.0 - RESULT_SHARE - done
        if store.chunks.open_stage(job.id, STRUCTURES, PAIRS, ranges, share, size):
            self._queue_time_slices(ranges)

    def _open_result(self) -> None:
        self.context.store.chunks.open_stage(self.job.id, PAIRS, RESULT, 1, RESULT_SHARE)

    def _chunk_size(self, collection: SignatureCollection) -> int:
        """Number of pairs that take CHUNK_SECONDS."""
        count = number_of_pairs(len(collection))
        if count <= TIMED_PAIRS:
            return count
        # Spread over all shapes: the pairs of one shape take about the same time.
        some = pairs_between(len(collection), 0, count)[:: max(count // TIMED_PAIRS, 1)]
        start = time.perf_counter()
        dissimilarities(collection, some, options_of(SimilarityOptions, self.payload.parameters))
        seconds = (time.perf_counter() - start) / len(some)
        return min(max(int(CHUNK_SECONDS / seconds), 1), count)

    @cached_property
    def _pairs(self) -> tuple[SignatureCollection, int]:
        """The collection whose pairs are compared, and the number of pairs of a chunk."""
        chunks, job_id = self.context.store.chunks, self.job.id
        stored, size = chunks.input(job_id, PAIRS), chunks.counts(job_id).size
        if stored is None or size == 0:
            raise LookupError("the chunks of this job are deleted: it has ended")
        return SignatureCollection.from_bytes(stored), size

    def _compare(self, number: int) -> bytes:
        collection, size = self._pairs
        last = min((number + 1) * size, number_of_pairs(len(collection)))
        pairs = pairs_between(len(collection), number * size, last)
        options = options_of(SimilarityOptions, self.payload.parameters)
        costs: FloatArray = dissimilarities(collection, pairs, options).costs
        return costs.astype("<f8").tobytes()

    def _queue_time_slices(self, open_chunks: int) -> None:
        """Queue as many time slices as there are workers, but not more than chunks."""
        queue = self.context.queue
        wanted = min(queue.workers(), open_chunks)
        for _ in range(wanted - len(queue.store.chunks.time_slices(self.job.id))):
            queue.submit_time_slice(self.job)

    def _timings(self) -> dict[str, float]:
        total = datetime.now(UTC) - self._started()
        seconds = self.context.store.chunks.counts(self.job.id).seconds
        # The clock of the machine where the job started may be ahead.
        return {STRUCTURES: 0.0, PAIRS: 0.0, **seconds, TOTAL: max(total.total_seconds(), 0.0)}

    def _started(self) -> datetime:
        return self.job.started or self.job.created
