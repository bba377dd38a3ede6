"""Turns of a job that compares a collection: each does some parts of it, then others may go on.

The parts are the signatures of the shapes, then ranges of pairs, then the result. There is no
leader: each turn takes parts until there are none, or until others wait for the worker, and the one
that notices that a stage is done opens the next (:mod:`broker.store.parts`).
"""

import time
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Final

import numpy as np
from redis.exceptions import RedisError

from broker.contracts import (
    PAIRS,
    RESULT,
    STRUCTURES,
    DissimilaritiesPayload,
    JobRecord,
    TurnPayload,
    subject_of,
)
from broker.queue import JobQueue
from broker.store import NewerRecord, Offer, Store, Taken
from broker.telemetry import logger
from broker.upkeep import forget_deleted
from solver.arrays import FloatArray
from solver.control import Control
from solver.errors import Cancelled
from solver.similarity import (
    Signature,
    SignatureCollection,
    SimilarityOptions,
    dissimilarities,
    number_of_pairs,
    pairs_between,
)
from worker.jobs.dissimilarities import arrays_of, result_of
from worker.jobs.failures import newer_version, problem_of
from worker.jobs.options import options_of
from worker.jobs.reporting import TOTAL, WAITING, Reporter
from worker.jobs.signatures import cached_signatures, compute_signature

SLICE: Final = 1.0
"""Seconds after which a turn ends if anything else is queued."""

LONGEST: Final = 10.0
"""Seconds after which it ends anyway, so that what is lost with a process is never much."""

PART_SECONDS: Final = 0.5
"""What a range of pairs is to take: long against a look into the store, short for who waits."""

SAMPLE: Final = 200
"""Pairs that are timed to tell how many make such a range."""

STRUCTURES_SHARE: Final = 0.6
"""Share of the progress that is given to signatures if none is known."""

RESULT_SHARE: Final = 0.02

log = logger("isomatch.turns")


@dataclass(frozen=True)
class Turn:
    """One turn.

    Parameters
    ----------
    queue
        The way to further turns, and the store.
    record
        The turn.
    runner
        Who runs it.
    """

    queue: JobQueue
    record: JobRecord
    runner: str

    def run(self) -> None:
        """Work on the job for a while; however that ends, it is said in the job's own record.

        Raises
        ------
        RedisError
            The store is away for longer than it is waited for; the turn can be begun again.
        """
        assert isinstance(self.record.payload, TurnPayload)
        jobs, parts, job_id = self.store.jobs, self.store.parts, self.record.payload.job
        # A job that is done in turns is held by itself.
        job = None
        try:
            job = jobs.get(job_id) if jobs.claim(job_id, job_id) else None
            if job is not None and isinstance(job.payload, DissimilaritiesPayload):
                _Work(self, job, job.payload).do()
        except RedisError:
            raise
        except NewerRecord:
            jobs.fail(job_id, job_id, newer_version())
        except Cancelled:
            jobs.leave(job_id, job_id)
        except Exception as error:
            assert job is not None
            problem = problem_of(error, job)
            # Of a job that was cancelled the rest is gone at any moment.
            if jobs.fail(job_id, job_id, problem):
                log.warning("failed", problem=problem.slug, exc_info=problem.status >= 500)
        parts.end_turn(job_id, self.record.id)
        state = jobs.state(job_id)
        if state is None or state.ended:
            parts.forget(job_id)
            if job is not None:
                forget_deleted(self.store, subject_of(job.payload).named)

    @property
    def store(self) -> Store:
        """Where everything is."""
        return self.queue.store


@dataclass(frozen=True)
class _Work:
    turn: Turn
    job: JobRecord
    payload: DissimilaritiesPayload

    def do(self) -> None:
        parts, control = self.turn.store.parts, self._control()
        start = time.monotonic()
        while True:
            taken = parts.take(self.job.id, self.turn.record.id, self.turn.runner)
            if taken.offer is Offer.DONE:
                self._open_next(taken.stage)
            elif taken.offer is Offer.PART:
                began = time.perf_counter()
                result = self._part(taken, control)
                if taken.stage == RESULT:
                    self._succeed(result)
                    return
                parts.complete(self.job.id, taken, result, time.perf_counter() - began)
            else:
                return
            worked = time.monotonic() - start
            if worked > LONGEST or (worked > SLICE and self.turn.queue.others_wait(self.job.id)):
                self.turn.queue.submit_turn(self.job)
                return

    def _control(self) -> Control:
        reporter = Reporter(self.turn.store.jobs, self.job.id, self.job.id)
        return Control(is_cancelled=reporter.control().is_cancelled)

    def _part(self, taken: Taken, control: Control) -> bytes:
        store, runner = self.turn.store, self.turn.runner
        if taken.stage == STRUCTURES:
            return compute_signature(self.payload, taken.part, store, runner, control)
        if taken.stage == PAIRS:
            return self._compare(taken.part, control)
        return self._result()

    def _result(self) -> bytes:
        parts, jobs = self.turn.store.parts, self.turn.store.jobs
        found = parts.results(self.job.id, PAIRS)
        data = b"".join(found[part] for part in range(len(found)))
        values = np.frombuffer(data, dtype="<f8").astype(np.float64)
        result = result_of(self.payload, values, self._timings())
        jobs.set_arrays(self.job.id, arrays_of(result, values))
        return result.model_dump_json().encode()

    def _timings(self) -> dict[str, float]:
        total = datetime.now(UTC) - self._started()
        seconds = self.turn.store.parts.counts(self.job.id).seconds
        # It may have begun by another clock.
        return {STRUCTURES: 0.0, PAIRS: 0.0, **seconds, TOTAL: max(total.total_seconds(), 0.0)}

    def _started(self) -> datetime:
        return self.job.started or self.job.created

    def _succeed(self, result: bytes) -> None:
        waiting = self._started() - self.job.created
        timings = self._timings() | {WAITING: waiting.total_seconds()}
        if self.turn.store.jobs.succeed(self.job.id, self.job.id, result):
            self.turn.store.tallies.time(self.job.kind, timings)

    def _open_next(self, stage: str) -> None:
        parts, count = self.turn.store.parts, len(self.payload.shapes)
        if stage == "":
            known = cached_signatures(self.payload, self.turn.store)
            parts.supply(self.job.id, STRUCTURES, known)
            share = STRUCTURES_SHARE * (1.0 - len(known) / count)
            if parts.open(self.job.id, stage, STRUCTURES, count, share):
                self._call_others(count - len(known))
        elif stage == STRUCTURES:
            signatures = parts.results(self.job.id, STRUCTURES)
            collection = SignatureCollection.of(
                [Signature.from_bytes(signatures[place]) for place in range(count)],
                self.payload.parameters.points,
            )
            parts.set_input(self.job.id, PAIRS, collection.to_bytes())
            size = self._pairs_in_a_part(collection)
            ranges = -(-number_of_pairs(count) // size)
            share = 1.0 - RESULT_SHARE - self._progress()
            if parts.open(self.job.id, stage, PAIRS, ranges, share, size):
                self._call_others(ranges)
        elif stage == PAIRS:
            parts.open(self.job.id, stage, RESULT, 1, RESULT_SHARE)

    def _pairs_in_a_part(self, collection: SignatureCollection) -> int:
        count = number_of_pairs(len(collection))
        if count <= SAMPLE:
            return count
        # Pairs of one shape are alike; these are of all.
        some = pairs_between(len(collection), 0, count)[:: max(count // SAMPLE, 1)]
        began = time.perf_counter()
        dissimilarities(collection, some, options_of(SimilarityOptions, self.payload.parameters))
        cost = (time.perf_counter() - began) / len(some)
        return min(max(int(PART_SECONDS / cost), 1), count)

    def _progress(self) -> float:
        record = self.turn.store.jobs.get(self.job.id)
        return 0.0 if record is None else record.progress.fraction

    def _compare(self, part: int, control: Control) -> bytes:
        control.check()
        parts = self.turn.store.parts
        stored, size = parts.input(self.job.id, PAIRS), parts.counts(self.job.id).size
        if stored is None or size == 0:
            raise LookupError("nothing is kept of what is to be compared: the job has ended")
        collection = SignatureCollection.from_bytes(stored)
        last = min((part + 1) * size, number_of_pairs(len(collection)))
        pairs = pairs_between(len(collection), part * size, last)
        costs: FloatArray = dissimilarities(
            collection, pairs, options_of(SimilarityOptions, self.payload.parameters)
        ).costs
        return costs.astype("<f8").tobytes()

    def _call_others(self, open_parts: int) -> None:
        """Have as many turns as there are workers, but not more than there are parts."""
        queue = self.turn.queue
        wanted = min(queue.workers(), open_parts)
        for _ in range(wanted - len(self.turn.store.parts.turns(self.job.id))):
            queue.submit_turn(self.job)
