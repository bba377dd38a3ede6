"""Batches: one job whose matches are jobs of their own, a few of them queued at a time.

As many matches of a batch are queued or running as there are workers; as each ends, the next is
queued behind all other jobs. There is no leader: whoever notices that a match has ended calls
:meth:`Batches.advance`, which may be repeated at any time, and recovery does so regularly. A match
that fails, or whose shape was deleted, does not end the batch.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from itertools import compress

from redis.client import Pipeline
from redis.exceptions import WatchError

from broker.contracts import (
    BatchMatch,
    BatchPayload,
    BatchResult,
    JobRecord,
    JobState,
    MatchSummary,
    Problem,
    ProblemType,
    Progress,
    Summary,
)
from broker.queue.new_jobs import batch_match_id, new_batch_match, parsed_match_id
from broker.queue.rq_queues import RqQueues
from broker.queue.workers import worker_states
from broker.store import QueuedMatches, Store

_EXPIRED = Problem.of(ProblemType.JOB_EXPIRED, "The match ended long ago and is no longer kept.")


@dataclass(frozen=True)
class Batches:
    """The matches of batches.

    Parameters
    ----------
    store
        Records of batches and of their matches.
    rq
        The queues.
    """

    store: Store
    rq: RqQueues

    def advance(self, batch: str) -> None:
        """Queue further matches of a batch, report its progress, and end it after its last match.

        Parameters
        ----------
        batch
            Id of the batch; one that has ended, or does not exist, is left as it is.
        """
        window = max(len(worker_states(self.store.client)), 1)
        while (record := self._active(batch)) is not None:
            found = self._look(record)
            if found.next == _count(record) or len(found.live) >= window:
                self._report(record, found.ended)
                return
            self._queue(record, found.next)

    def begin(self, batch: str) -> bool:
        """Start a batch with the first of its matches; False if it has ended, or is cancelled."""
        jobs = self.store.jobs
        if jobs.claim(batch, batch):
            record = jobs.get(batch)
            # Later matches find the progress of those before.
            if record is not None and record.progress.stage == JobState.QUEUED.value:
                self._report(record, self._look(record).ended)
        return jobs.is_held(batch, batch)

    def matches(self, record: JobRecord) -> tuple[BatchMatch, ...]:
        """Return what is known of the matches of a batch, in the order of its targets."""
        names = [batch_match_id(record.id, place) for place in range(_count(record))]
        found = dict(zip(names, self.store.jobs.records(names), strict=True))
        begun = self._begun([name for name, one in found.items() if one is None])
        # Matches that were queued between the two reads have a record now.
        found |= zip(begun, self.store.jobs.records(begun), strict=True)
        expired = {name for name in begun if found[name] is None}
        summaries = self.store.results.summaries(names)
        known = zip(found.values(), (name in expired for name in names), summaries, strict=True)
        return tuple(_match(record, place, *one) for place, one in enumerate(known))

    def waiting_match(self, match: str) -> JobRecord | None:
        """Return a match that was never queued, as it is now; None if there is none.

        It is queued, or cancelled together with its batch.
        """
        found = self._waiting(match)
        if found is None:
            return None
        batch = found[0]
        # It is created when it is queued; until then it has the times of the batch.
        times = {"created": batch.created, "ended": batch.ended}
        return new_batch_match(*found).model_copy(update={"state": _unqueued(batch), **times})

    def expired(self, match: str) -> bool:
        """Return whether a match has expired together with its batch, which never queued it."""
        batch, place = parsed_match_id(match)
        return place < self.store.jobs.matches_of(batch) and not self.store.jobs.exists(batch)

    def is_cancelled(self, match: str) -> bool:
        """Return whether the batch of a match is cancelled; False for a job of no batch."""
        batch, _ = parsed_match_id(match)
        return bool(batch) and self.store.jobs.state(batch) is JobState.CANCELLED

    def queue_waiting(self, match: str) -> None:
        """Queue a match of an active batch before its turn, unless it is or was queued."""
        # Any change of the batch meanwhile prevents it, a report of progress, too.
        while (found := self._waiting(match)) is not None and not found[0].state.ended:
            self._queue(*found)

    def live(self, record: JobRecord) -> list[str]:
        """Return the ids of the matches of a batch that are queued or running."""
        return list(self._look(record).live)

    def enqueue(self, match: JobRecord, pipe: Pipeline) -> None:
        """Queue a match, as part of a transaction."""
        assert match.batch is not None
        self.rq.enqueue(match, pipe)
        self.store.jobs.create(match, pipe)
        self.store.chunks.add_time_slice(match.batch, match.id, pipe)

    def _active(self, batch: str) -> JobRecord | None:
        record = self.store.jobs.get(batch)
        return None if record is None or record.state.ended else record

    def _waiting(self, match: str) -> tuple[JobRecord, int] | None:
        """Batch of a match that was never queued, and its place there."""
        batch, place = parsed_match_id(match)
        record = self.store.jobs.get(batch) if batch else None
        if record is None or not isinstance(record.payload, BatchPayload):
            return None
        if place >= _count(record) or self.store.jobs.expired(match):
            return None
        return record, place

    def _look(self, record: JobRecord) -> QueuedMatches:
        return self.store.chunks.matches(record.id, _count(record))

    def _begun(self, matches: Sequence[str]) -> list[str]:
        """Return those of these matches that were queued at some time."""
        with self.store.client.pipeline(transaction=False) as pipe:
            for match in matches:
                pipe.exists(self.store.keys.job_tombstone(match))
            return list(compress(matches, pipe.execute()))

    def _queue(self, record: JobRecord, place: int) -> None:
        """Queue a match, unless another process has, or the batch has changed meanwhile."""
        match = new_batch_match(record, place)
        with self.store.client.pipeline() as pipe:
            keys = self.store.keys
            pipe.watch(keys.job(record.id), keys.job_tombstone(match.id))
            state = self.store.jobs.state(record.id)
            if state is None or state.ended or self.store.jobs.expired(match.id):
                return
            try:
                self.enqueue(match, pipe)
                pipe.execute()
            except WatchError:
                return

    def _report(self, record: JobRecord, ended: int) -> None:
        jobs, count = self.store.jobs, _count(record)
        if ended == count:
            self._finish(record)
        else:
            # A batch is its own runner; it reports nothing before it has begun.
            stage = f"{ended} of {count} matches"
            jobs.report(record.id, record.id, Progress(stage=stage, fraction=ended / count))

    def _finish(self, record: JobRecord) -> None:
        jobs, payload = self.store.jobs, record.payload
        assert isinstance(payload, BatchPayload)
        jobs.claim(record.id, record.id)  # none of its matches may have begun
        matches, started = self.matches(record), record.started or record.created
        # The clock of the machine where the batch started may be ahead.
        seconds = max((datetime.now(UTC) - started).total_seconds(), 0.0)
        result = BatchResult(
            job=record.id,
            source=payload.source,
            source_name=payload.source_name,
            parameters=payload.parameters,
            matches=matches,
            succeeded=sum(one.state is JobState.SUCCEEDED for one in matches),
            warnings=(),
            timings={"total": seconds},
        )
        document = result.model_dump_json().encode()
        if jobs.succeed(record.id, record.id, document):
            self.store.counters.observe(record.kind, {"total": seconds})
        # Whoever else notices the end may just have recorded it again.
        self.store.chunks.delete(record.id)


def _count(record: JobRecord) -> int:
    assert isinstance(record.payload, BatchPayload)
    return len(record.payload.targets)


def _unqueued(batch: JobRecord) -> JobState:
    """State of a match that was never queued: none is any more when its batch has ended."""
    return JobState.CANCELLED if batch.state.ended else JobState.QUEUED


def _match(
    batch: JobRecord,
    place: int,
    record: JobRecord | None,
    has_expired: bool,
    summary: Summary | None,
) -> BatchMatch:
    payload = batch.payload
    assert isinstance(payload, BatchPayload)
    error = None if record is None else record.error
    if record is not None:
        shown = record.state
    elif has_expired:
        shown, error = JobState.FAILED, _EXPIRED
    else:
        shown = _unqueued(batch)
    done = shown is JobState.SUCCEEDED
    return BatchMatch(
        target=payload.targets[place],
        target_name=payload.target_names[place],
        job=batch_match_id(batch.id, place),
        state=shown,
        fraction=0.0 if record is None else record.progress.fraction,
        error=error,
        summary=summary if done and isinstance(summary, MatchSummary) else None,
    )
