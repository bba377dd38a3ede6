"""Lua scripts of the store: steps that Redis runs atomically, one file each."""

from dataclasses import dataclass
from importlib.resources import files
from typing import Any, Final

from redis import Redis
from redis.client import Pipeline
from redis.commands.core import Script


@dataclass(frozen=True)
class LuaScript:
    """A script, run by its hash.

    Parameters
    ----------
    source
        Lua; each file says what its ``KEYS`` and ``ARGV`` are.
    """

    source: str

    def __call__(self, client: Redis, keys: list[str], *arguments: str | bytes | float) -> Any:
        """Run the script, or add it to a transaction."""
        if isinstance(client, Pipeline):
            # By its hash it would fail alone if Redis restarted before the transaction began.
            return client.eval(self.source, len(keys), *keys, *arguments)
        return Script(client, self.source)(keys, arguments)


def _read(*names: str) -> LuaScript:
    """Return the script in the last file, after the preludes in the files before it."""
    return LuaScript("".join((files(__name__) / f"{name}.lua").read_text() for name in names))


CLAIM_JOB: Final = _read("job_transitions", "claim_job")
FINISH_JOB: Final = _read("when_full", "held", "job_transitions", "finish_job")
CANCEL_JOB: Final = _read("when_full", "job_transitions", "cancel_job")
LOSE_JOB: Final = _read("job_transitions", "lose_job")
ADMIT_JOB: Final = _read("admit_job")
BATCH_MATCHES: Final = _read("when_full", "batch_matches")
JOB_FIELDS: Final = _read("job_fields")
REPORT_PROGRESS: Final = _read("when_full", "report_progress")
CLAIM_CHUNK: Final = _read("sliced_job", "claim_chunk")
OPEN_STAGE: Final = _read("sliced_job", "open_stage")
COMPLETE_CHUNK: Final = _read("sliced_job", "complete_chunk")
NUMBER_TIME_SLICE: Final = _read("number_time_slice")
BEGIN_DELIVERY: Final = _read("begin_delivery")
RECORD_DELIVERY: Final = _read("record_delivery")
COUNT_LISTED: Final = _read("count_listed")
HOLD: Final = _read("held", "hold")
RELEASE: Final = _read("held", "release")
COUNT_HELD: Final = _read("count_held")
QUEUE_JOB: Final = _read("queue_job")
UNLIST: Final = _read("unlist")
RELEASE_LOCK: Final = _read("release_lock")
RENEW_LOCK: Final = _read("renew_lock")
CACHE_DROP: Final = _read("cache_entries", "cache_drop")
CACHE_PUT: Final = _read("cache_entries", "cache_put")
