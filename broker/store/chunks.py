"""Chunks of jobs that are done in time slices: their stages, holders and results.

A *time slice* is a small job of its own that works on chunks of a large one and then lets others
have the worker. A time slice holds a chunk for as long as it is running: when its process is lost,
and the slice is queued again or has failed, another slice claims the chunk, without any clock. The
result of a chunk is stored as soon as it is done, and never computed again. Each step is one script
(:mod:`broker.store.scripts`).

A stage without unfinished chunks is *done*; the time slice that notices opens the next one.

A batch has matches instead of time slices, and no chunks: only how far it is.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from types import MappingProxyType
from typing import Final, cast

from redis.client import Pipeline

from broker.contracts import STAGES, JobState
from broker.store import scripts
from broker.store.connections import DAY
from broker.store.replies import blob, text
from broker.store.tenant_data import TenantData
from broker.store.watching import states_of

_LEAST_TTL: Final = 30 * DAY
"""Seconds a stage without finished chunks is kept at least, even where records expire sooner: a job
may wait long, and a chunk take long. All of it is deleted when the job ends."""

_NUMBERS: Final = ("next", "count", "done", "base", "share", "size", "taken")


class ClaimStatus(StrEnum):
    """Answer to a time slice that claims a chunk; the values are those of the script."""

    CLAIMED = "part"
    DONE = "done"
    BUSY = "busy"
    ENDED = "ended"


@dataclass(frozen=True)
class ClaimedChunk:
    """A chunk that a time slice has claimed, or the reason why there is none.

    Parameters
    ----------
    status
        Claimed; or all chunks of the stage are done; or the unfinished ones are held by others; or
        the job has ended.
    stage
        The present stage, empty if the job has ended.
    number
        Number of the chunk, -1 for none.
    """

    status: ClaimStatus
    stage: str
    number: int


@dataclass(frozen=True)
class StageCounts:
    """Progress of the present stage.

    Parameters
    ----------
    stage
        Its name, empty if the job has no chunks (any more).
    count, done, begun
        Numbers of chunks: all, done, and claimed at some time or known beforehand.
    size
        Size of a chunk, as given to :meth:`Chunks.open_stage`.
    claims
        Number of claims in all stages.
    seconds
        Sum of the times of the chunks, by stage.
    """

    stage: str
    count: int
    done: int
    begun: int
    size: int
    claims: int
    seconds: Mapping[str, float]


@dataclass(frozen=True)
class QueuedMatches:
    """How far a batch is.

    Parameters
    ----------
    next
        Place of the first match that was not queued yet; the number of matches if there is none.
        Some of those behind it may have been queued before their turn.
    ended
        Number of matches that have ended.
    live
        States of the matches that are queued or running, by id.
    """

    next: int
    ended: int
    live: Mapping[str, JobState]


@dataclass(frozen=True)
class Chunks(TenantData):
    """The chunks of jobs that are done in time slices."""

    @property
    def _ttl(self) -> int:
        return max(self.settings.job_ttl, _LEAST_TTL)

    def create(self, job_id: str, pipe: Pipeline) -> None:
        """Begin with a stage without name and chunks, as part of a transaction."""
        pipe.hset(self.keys.job_chunks(job_id), mapping={"stage": "", **dict.fromkeys(_NUMBERS, 0)})
        pipe.expire(self.keys.job_chunks(job_id), self._ttl)

    def claim(self, job_id: str, time_slice: str, runner: str) -> ClaimedChunk:
        """Claim a chunk for a time slice that this runner runs."""
        prefixes = self.keys.job(""), self.keys.chunk_results(job_id, "")
        status, stage, number = scripts.CLAIM_CHUNK(
            self.client, self._names(job_id), time_slice, runner, *prefixes
        )
        return ClaimedChunk(ClaimStatus(text(status)), text(stage), int(number))

    def open_stage(
        self,
        job_id: str,
        previous: str,
        stage: str,
        count: int,
        share: float,
        size: int = 1,
        known: Mapping[int, bytes] = MappingProxyType({}),
    ) -> bool:
        """Open the next stage; False if another time slice did, or the job has ended.

        Parameters
        ----------
        job_id
            The job.
        previous
            The stage that is done.
        stage, count
            Name and number of chunks of the next stage.
        share
            Its share of the whole job's progress.
        size
            Size of a chunk, for :meth:`counts`.
        known
            Results of chunks that are done already, by number.
        """
        names = [*self._names(job_id), self.keys.chunk_results(job_id, stage)]
        arguments = previous, stage, count, share, size, self._ttl
        results: list[bytes | int] = [one for entry in known.items() for one in entry]
        return bool(scripts.OPEN_STAGE(self.client, names, *arguments, *results) == 1)

    def complete(self, job_id: str, chunk: ClaimedChunk, result: bytes, seconds: float) -> bool:
        """Store the result of a chunk; False if it is known already, or not wanted any more."""
        names = [*self._names(job_id), self.keys.chunk_results(job_id, chunk.stage)]
        arguments = chunk.stage, chunk.number, result, seconds, self._ttl
        return bool(scripts.COMPLETE_CHUNK(self.client, names, *arguments) == 1)

    def results(self, job_id: str, stage: str) -> dict[int, bytes]:
        """Return the results of a stage's chunks that are done, by number."""
        found = self.client.hgetall(self.keys.chunk_results(job_id, stage))
        return {int(key): result for key, result in cast(dict[bytes, bytes], found).items()}

    def set_input(self, job_id: str, stage: str, data: bytes) -> None:
        """Store the common input of a stage's chunks."""
        self.client.set(self.keys.stage_input(job_id, stage), data, ex=self._ttl)

    def input(self, job_id: str, stage: str) -> bytes | None:
        """Return the common input of a stage's chunks."""
        return blob(self.client.get(self.keys.stage_input(job_id, stage)))

    def counts(self, job_id: str) -> StageCounts:
        """Return the progress of the present stage."""
        reply = self.client.hgetall(self.keys.job_chunks(job_id))
        fields = {text(name): text(value) for name, value in reply.items()}
        seconds = {
            name.partition(":")[2]: float(value)
            for name, value in fields.items()
            if name.startswith("seconds:")
        }
        count, done, begun, size, claims = (
            int(fields.get(name, 0)) for name in ("count", "done", "next", "size", "taken")
        )
        return StageCounts(fields.get("stage", ""), count, done, begun, size, claims, seconds)

    def add_time_slice(self, job_id: str, time_slice: str, pipe: Pipeline) -> None:
        """Record that a time slice, or a match of a batch, is queued, as part of a transaction."""
        pipe.sadd(self.keys.time_slices(job_id), time_slice)
        pipe.expire(self.keys.time_slices(job_id), self._ttl)

    def number_time_slice(self, job_id: str) -> int | None:
        """Return the number of a new time slice, from 2; None if the job has ended."""
        return scripts.NUMBER_TIME_SLICE(self.client, [self.keys.job_chunks(job_id)]) or None

    def time_slices(self, job_id: str) -> dict[str, JobState]:
        """Return the states of the time slices that have not ended, by id."""
        key = self.keys.time_slices(job_id)
        queued = [text(member) for member in self.client.smembers(key)]
        states = states_of(self, queued)
        found = {
            time_slice: state
            for time_slice, state in zip(queued, states, strict=True)
            if state is not None and not state.ended
        }
        if ended := set(queued) - set(found):
            self.client.srem(key, *ended)
        return found

    def matches(self, batch: str, count: int) -> QueuedMatches:
        """Return how far a batch of so many matches is.

        What was recorded is completed: also if an earlier version queued matches.
        """
        names = [self.keys.job_chunks(batch), self.keys.time_slices(batch)]
        arguments = self.keys.job(""), batch, count, self._ttl
        following, ended, *live = scripts.BATCH_MATCHES(self.client, names, *arguments)
        states = zip(live[::2], live[1::2], strict=True)
        return QueuedMatches(
            following, ended, {text(match): JobState(text(state)) for match, state in states}
        )

    def delete(self, job_id: str) -> None:
        """Delete what is kept of the parts of a job that has ended."""
        names = [
            self.keys.job_chunks(job_id),
            self.keys.chunk_holders(job_id),
            self.keys.time_slices(job_id),
        ]
        for stage in STAGES:
            names += [self.keys.chunk_results(job_id, stage), self.keys.stage_input(job_id, stage)]
        self.client.delete(*names)

    def _names(self, job_id: str) -> list[str]:
        return [
            self.keys.job(job_id),
            self.keys.job_chunks(job_id),
            self.keys.chunk_holders(job_id),
        ]
