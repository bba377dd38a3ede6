"""Jobs that are done in turns: their stages, the parts of each, who is at which, what came of it.

A *turn* is a small job of its own that works on parts of a large one and then lets others have the
worker. Turns take parts one by one. A part is held by a turn for as long as that turn is running:
if its process is gone, and the turn is to be begun again or has failed, whoever comes first takes
the part over, and no clock is needed to say when. What a part results in is kept as soon as it is
done, so that no part that is done is ever computed again. Each step is one script.

A stage that has no parts left is *done*, and the turn that notices opens the next one.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from typing import Final

from redis import Redis
from redis.client import Pipeline

from broker.contracts import STAGES, JobState
from broker.store import keys
from broker.store.connections import DAY, StoreSettings
from broker.store.replies import blob, text

_WANTED: Final = """
local job = redis.call('HMGET', KEYS[1], 'state', 'cancel')
if job[1] ~= 'running' or job[2] then
    return {'ended', '', -1}
end
"""
# KEYS of the scripts below: 1 the job, 2 its counts, 3 its holders.

_TAKE: Final = (
    _WANTED
    + """
-- ARGV: 1 turn, 2 its runner, 3 prefix of the jobs, 4 prefix of what is done
local function running(holder)
    local turn, runner = string.match(holder, '^(.-)|(.*)$')
    local record = redis.call('HMGET', ARGV[3] .. turn, 'state', 'runner')
    return record[1] == 'running' and record[2] == runner
end
local me = ARGV[1] .. '|' .. ARGV[2]
local counts = redis.call('HMGET', KEYS[2], 'stage', 'next', 'count', 'done')
local stage, next, count = counts[1], tonumber(counts[2]), tonumber(counts[3])
local holders = redis.call('HGETALL', KEYS[3])
for i = 1, #holders, 2 do
    if holders[i + 1] == me or not running(holders[i + 1]) then
        redis.call('HSET', KEYS[3], holders[i], me)
        redis.call('HINCRBY', KEYS[2], 'taken', 1)
        return {'part', stage, tonumber(holders[i])}
    end
end
while next < count and redis.call('HEXISTS', ARGV[4] .. stage, next) == 1 do
    next = next + 1
end
redis.call('HSET', KEYS[2], 'next', next < count and next + 1 or next)
if next < count then
    redis.call('HSET', KEYS[3], next, me)
    redis.call('HINCRBY', KEYS[2], 'taken', 1)
    return {'part', stage, next}
end
return {tonumber(counts[4]) >= count and 'done' or 'busy', stage, -1}
"""
)
"""Take a part whose holder is gone, or the next one that nobody has taken."""

_OPEN: Final = (
    _WANTED
    + """
-- KEYS: 4 done of the new stage.  ARGV: 1 stage before, 2 new stage, 3 count, 4 share of progress,
-- 5 size of a part, 6 ttl
if redis.call('HGET', KEYS[2], 'stage') ~= ARGV[1] then
    return 0
end
local before = redis.call('HMGET', KEYS[2], 'base', 'share')
local base = tonumber(before[1]) + tonumber(before[2])
redis.call('HSET', KEYS[2], 'stage', ARGV[2], 'next', 0, 'count', ARGV[3],
    'done', redis.call('HLEN', KEYS[4]), 'base', base, 'share', ARGV[4], 'size', ARGV[5])
redis.call('DEL', KEYS[3])
redis.call('EXPIRE', KEYS[2], ARGV[6])
redis.call('HSET', KEYS[1], 'stage', ARGV[2], 'fraction', math.min(base, 1))
return 1
"""
)
"""Go on to another stage, once."""

_COMPLETE: Final = (
    _WANTED
    + """
-- KEYS: 4 done of the stage.  ARGV: 1 stage, 2 part, 3 result, 4 seconds, 5 ttl
local counts = redis.call('HMGET', KEYS[2], 'stage', 'count', 'base', 'share')
if counts[1] ~= ARGV[1] or redis.call('HEXISTS', KEYS[4], ARGV[2]) == 1 then
    return 0
end
redis.call('HSET', KEYS[4], ARGV[2], ARGV[3])
redis.call('HDEL', KEYS[3], ARGV[2])
local done = redis.call('HINCRBY', KEYS[2], 'done', 1)
redis.call('HINCRBYFLOAT', KEYS[2], 'seconds:' .. ARGV[1], ARGV[4])
redis.call('EXPIRE', KEYS[2], ARGV[5])
redis.call('EXPIRE', KEYS[4], ARGV[5])
-- Rounded as the sum at the end of the stage is: a bar runs neither back nor beyond its end.
redis.call('HSET', KEYS[1], 'fraction', math.min(counts[3] + counts[4] * (done / counts[2]), 1))
return 1
"""
)
"""Keep what came of a part, once."""


_NUMBER: Final = """
-- KEYS: 1 counts.
if redis.call('EXISTS', KEYS[1]) == 0 then
    return 0
end
return redis.call('HINCRBY', KEYS[1], 'turns', 1) + 1
"""
"""Number a new turn, 2 for the first that is asked for, unless the job has ended."""

_KEPT: Final = 30 * DAY
"""Seconds for which a stage is kept of which no part is done, however soon records expire: a job
may wait, and a part take, for long. At its end all of it is deleted."""

_NUMBERS: Final = ("next", "count", "done", "base", "share", "size", "taken")


class Offer(StrEnum):
    """What a turn that asks for a part is told."""

    PART = "part"
    DONE = "done"
    BUSY = "busy"
    ENDED = "ended"


@dataclass(frozen=True)
class Taken:
    """A part that a turn has taken, or why there is none.

    Parameters
    ----------
    offer
        A part; or all of the stage are done; or others are at those that are left; or the job has
        ended and nothing is to be done any more.
    stage
        The present stage, empty if the job has ended.
    part
        Number of the part, -1 for none.
    """

    offer: Offer
    stage: str
    part: int


@dataclass(frozen=True)
class StageCounts:
    """How far the present stage is.

    Parameters
    ----------
    stage
        Its name, empty if nothing is known of the job (any more).
    count, done, begun
        Numbers of parts: all, done, and taken at some time or done beforehand.
    size
        What a part is made of, as many as whoever opened the stage has said.
    taken
        How often a part was taken, in all stages.
    seconds
        What the parts took in sum, by stage.
    """

    stage: str
    count: int
    done: int
    begun: int
    size: int
    taken: int
    seconds: Mapping[str, float]


@dataclass(frozen=True)
class Parts:
    """The parts of jobs that are done in turns.

    Parameters
    ----------
    client
        Connection to Redis.
    settings
        How long what is kept.
    """

    client: Redis
    settings: StoreSettings

    @property
    def _ttl(self) -> int:
        return max(self.settings.job_ttl, _KEPT)

    def create(self, job_id: str, pipe: Pipeline) -> None:
        """Begin with a stage without a name that has no parts, as part of a transaction."""
        pipe.hset(keys.job_parts(job_id), mapping={"stage": "", **dict.fromkeys(_NUMBERS, 0)})
        pipe.expire(keys.job_parts(job_id), self._ttl)

    def take(self, job_id: str, turn: str, runner: str) -> Taken:
        """Take a part for a turn that this runner runs."""
        offer, stage, part = self.client.eval(
            _TAKE,
            3,
            *self._keys(job_id),
            turn,
            runner,
            keys.job(""),
            keys.job_done(job_id, ""),
        )
        return Taken(Offer(text(offer)), text(stage), int(part))

    def open(
        self, job_id: str, before: str, stage: str, count: int, share: float, size: int = 1
    ) -> bool:
        """Go on to another stage; False if somebody else did, or the job has ended.

        Parameters
        ----------
        job_id
            The job.
        before
            The stage that is done.
        stage, count
            The one that is next, and its number of parts; those that :meth:`supply` knows are done.
        share
            Its share of the whole job's progress.
        size
            What to remember of how the parts are made.
        """
        answer = self.client.eval(
            _OPEN,
            4,
            *self._keys(job_id),
            keys.job_done(job_id, stage),
            before,
            stage,
            count,
            share,
            size,
            self._ttl,
        )
        return bool(answer == 1)

    def complete(self, job_id: str, taken: Taken, result: bytes, seconds: float) -> bool:
        """Keep what came of a part; False if it is known already, or not wanted any more."""
        answer = self.client.eval(
            _COMPLETE,
            4,
            *self._keys(job_id),
            keys.job_done(job_id, taken.stage),
            taken.stage,
            taken.part,
            result,
            seconds,
            self._ttl,
        )
        return bool(answer == 1)

    def supply(self, job_id: str, stage: str, known: Mapping[int, bytes]) -> None:
        """Keep what is known beforehand of parts of a stage that is not open yet."""
        if known:
            key = keys.job_done(job_id, stage)
            self.client.hset(key, mapping={str(part): result for part, result in known.items()})
            self.client.expire(key, self._ttl)

    def results(self, job_id: str, stage: str) -> dict[int, bytes]:
        """Return what came of the parts of a stage that are done, by their numbers."""
        found: dict[bytes, bytes] = self.client.hgetall(keys.job_done(job_id, stage))  # type: ignore[assignment]
        return {int(part): result for part, result in found.items()}

    def set_input(self, job_id: str, stage: str, data: bytes) -> None:
        """Keep what all parts of a stage need."""
        self.client.set(keys.job_input(job_id, stage), data, ex=self._ttl)

    def input(self, job_id: str, stage: str) -> bytes | None:
        """Return what all parts of a stage need."""
        return blob(self.client.get(keys.job_input(job_id, stage)))

    def counts(self, job_id: str) -> StageCounts:
        """Return how far the present stage is."""
        reply = self.client.hgetall(keys.job_parts(job_id))
        fields = {text(name): text(value) for name, value in reply.items()}
        seconds = {
            name.partition(":")[2]: float(value)
            for name, value in fields.items()
            if name.startswith("seconds:")
        }
        count, done, begun, size, taken = (
            int(fields.get(name, 0)) for name in ("count", "done", "next", "size", "taken")
        )
        return StageCounts(fields.get("stage", ""), count, done, begun, size, taken, seconds)

    def add_turn(self, job_id: str, turn: str, pipe: Pipeline) -> None:
        """Note that a turn is queued, as part of a transaction."""
        pipe.sadd(keys.job_turns(job_id), turn)
        pipe.expire(keys.job_turns(job_id), self._ttl)

    def end_turn(self, job_id: str, turn: str) -> None:
        """Note that a turn is at its end."""
        self.client.srem(keys.job_turns(job_id), turn)

    def number_turn(self, job_id: str) -> int | None:
        """Return the number of a new turn, 2 for the first that is asked for.

        None if nothing is known of the job, for it has ended.
        """
        return self.client.eval(_NUMBER, 1, keys.job_parts(job_id)) or None

    def turns(self, job_id: str) -> dict[str, JobState]:
        """Return the turns that have not ended, and whether they are queued or running."""
        found: dict[str, JobState] = {}
        for member in self.client.smembers(keys.job_turns(job_id)):
            turn = text(member)
            state = self.client.hget(keys.job(turn), "state")
            if state is not None and not JobState(text(state)).ended:
                found[turn] = JobState(text(state))
            else:
                self.end_turn(job_id, turn)
        return found

    def forget(self, job_id: str) -> None:
        """Forget all about the parts of a job that has ended."""
        names = [keys.job_parts(job_id), keys.job_holders(job_id), keys.job_turns(job_id)]
        for stage in STAGES:
            names += [keys.job_done(job_id, stage), keys.job_input(job_id, stage)]
        self.client.delete(*names)

    def _keys(self, job_id: str) -> tuple[str, str, str]:
        return keys.job(job_id), keys.job_parts(job_id), keys.job_holders(job_id)
