"""Batches: one job whose matches are jobs of their own, a few of them queued at a time.

As many matches of a batch are queued or running as there are workers; as each ends, the next is
queued behind all other jobs. There is no leader: whoever notices that a match has ended calls
:meth:`Batches.advance`, which may be repeated at any time, and recovery does so regularly. A match
that fails, or whose shape was deleted, does not end the batch.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime

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
from broker.queue.new_jobs import batch_match_id, new_batch_match
from broker.queue.rq_queues import RqQueues
from broker.queue.workers import worker_states
from broker.store import Store, text

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
            states = self._states(record)
            waiting = [place for place, state in enumerate(states) if state is None]
            live = sum(state is not None and not state.ended for state in states)
            if not waiting or live >= window:
                self._report(record, states)
                return
            self._queue(record, waiting[0])

    def begin(self, batch: str) -> bool:
        """Start a batch with the first of its matches; False if it has ended, or is cancelled."""
        jobs = self.store.jobs
        if jobs.claim(batch, batch):
            record = jobs.get(batch)
            # Later matches find the progress of those before.
            if record is not None and record.progress.stage == JobState.QUEUED.value:
                self._report(record, self._states(record))
        return jobs.is_held(batch, batch)

    def matches(self, record: JobRecord) -> tuple[BatchMatch, ...]:
        """Return what is known of the matches of a batch, in the order of its targets."""
        assert isinstance(record.payload, BatchPayload)
        count = len(record.payload.targets)
        names = [batch_match_id(record.id, place) for place in range(count)]
        found = self.store.jobs.records(names)
        summaries = self.store.results.summaries(names)
        known = zip(self._states(record), found, summaries, strict=True)
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
        batch = match.rpartition("-")[0]
        return self.store.jobs.expired(batch) and not self.store.jobs.exists(batch)

    def queue_waiting(self, match: str) -> None:
        """Queue a match of an active batch before its turn, unless it is or was queued."""
        # Any change of the batch meanwhile prevents it, a report of progress, too.
        while (found := self._waiting(match)) is not None and not found[0].state.ended:
            self._queue(*found)

    def live(self, record: JobRecord) -> list[str]:
        """Return the ids of the matches of a batch that are queued or running."""
        states = enumerate(self._states(record))
        return [batch_match_id(record.id, at) for at, one in states if one and not one.ended]

    def _active(self, batch: str) -> JobRecord | None:
        record = self.store.jobs.get(batch)
        return None if record is None or record.state.ended else record

    def _waiting(self, match: str) -> tuple[JobRecord, int] | None:
        """Batch of a match that was never queued, and its place there."""
        record = self.store.jobs.get(match.rpartition("-")[0])
        if record is None or not isinstance(record.payload, BatchPayload):
            return None
        names = [batch_match_id(record.id, place) for place in range(len(record.payload.targets))]
        if match not in names or self.store.jobs.expired(match):
            return None
        return record, names.index(match)

    def _states(self, record: JobRecord) -> list[JobState | None]:
        """State of each match; ``None`` before it is queued, and failed when it has expired."""
        assert isinstance(record.payload, BatchPayload)
        count = len(record.payload.targets)
        names = [batch_match_id(record.id, place) for place in range(count)]
        with self.store.client.pipeline(transaction=False) as pipe:
            for name in names:
                pipe.hget(self.store.keys.job(name), "state")
                pipe.exists(self.store.keys.job_tombstone(name))
            replies = pipe.execute()
        found = zip(replies[::2], replies[1::2], strict=True)
        return [
            JobState(text(state)) if state else (JobState.FAILED if begun else None)
            for state, begun in found
        ]

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
                self.rq.enqueue(match, pipe)
                self.store.jobs.create(match, pipe)
                pipe.execute()
            except WatchError:
                return

    def _report(self, record: JobRecord, states: Sequence[JobState | None]) -> None:
        jobs, count = self.store.jobs, len(states)
        ended = sum(state is not None and state.ended for state in states)
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


def _unqueued(batch: JobRecord) -> JobState:
    """State of a match that was never queued: none is any more when its batch has ended."""
    return JobState.CANCELLED if batch.state.ended else JobState.QUEUED


def _match(
    batch: JobRecord,
    place: int,
    state: JobState | None,
    record: JobRecord | None,
    summary: Summary | None,
) -> BatchMatch:
    payload = batch.payload
    assert isinstance(payload, BatchPayload)
    error = None if record is None else record.error
    if state is None:
        shown = _unqueued(batch)
    elif record is None:
        shown, error = state, _EXPIRED
    else:
        shown = record.state
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
