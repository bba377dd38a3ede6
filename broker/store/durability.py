"""Promises of the queue's Redis: records are kept, and on its disk before they are accepted.

Redis answers before its append-only file is on the disk (``appendfsync everysec``), and where the
disk is busy before it is written at all. ``WAITAOF`` (Redis 7.2, Valkey) waits until it is; with
``appendfsync always`` it returns at once.
"""

from dataclasses import dataclass
from typing import Any, Final

from redis import Redis
from redis.exceptions import RedisError, ResponseError

from broker.store.keys import Keys
from broker.telemetry import logger

LEAST_WAIT: Final = 2.0
"""Seconds to wait for the disk at least: a file that is flushed every second takes about one."""

_NO_PROMISE: Final = ("unknown command", "appendonly is disabled", "not supported")
"""Marks in the answer of a Redis that cannot say what is on its disk."""

log = logger("isomatch.store")


class NotOnDisk(RedisError):
    """What was accepted is not on the disk of Redis, or was lost when it restarted."""


class RecordLost(NotOnDisk):
    """The record is not there: Redis was restarted and has lost it, or it was deleted."""


class EvictsRecords(RedisError):
    """Redis is set to delete records when its memory is full."""


def check_eviction(client: Redis) -> None:
    """Check that a Redis keeps records when its memory is full.

    Parameters
    ----------
    client
        Connection to the Redis of the queue.

    Raises
    ------
    EvictsRecords
        It has a limit, and an eviction policy. One that does not tell its policy passes.
    """
    memory = _info(client, "memory")
    policy = memory.get("maxmemory_policy", "noeviction")
    if memory.get("maxmemory") and policy != "noeviction":
        raise EvictsRecords(
            "The Redis at ISOMATCH_REDIS_URL deletes records when its memory is full: its"
            f" maxmemory-policy is {policy}; set it to noeviction."
        )


def possible_losses(client: Redis) -> list[str]:
    """Return how a Redis, by its settings, may lose what was accepted: a sentence for each way.

    Parameters
    ----------
    client
        Connection to the Redis of the queue.
    """
    found = []
    try:
        check_eviction(client)
    except EvictsRecords as error:
        found.append(str(error))
    if _info(client, "persistence").get("aof_enabled") == 0:
        found.append(
            "The Redis at ISOMATCH_REDIS_URL keeps no append-only file, and loses accepted jobs"
            " when it restarts; set its appendonly to yes."
        )
    return found


def _info(client: Redis, section: str) -> dict[str, Any]:
    try:
        told: dict[str, Any] = client.info(section)
    except ResponseError:
        return {}  # a managed server may permit other commands only
    return told


@dataclass(frozen=True)
class Durability:
    """Waiting until records are on the disk of Redis.

    Parameters
    ----------
    client
        Connection to Redis.
    seconds
        How long to wait for the disk.
    """

    client: Redis
    seconds: float

    def wait(self, key: str) -> None:
        """Wait until a record, and all that was written before, is on the disk.

        A Redis without ``WAITAOF`` or append-only file makes no promise; nothing is waited for.

        Parameters
        ----------
        key
            Key of the record.

        Raises
        ------
        NotOnDisk
            It is not there in time.
        RecordLost
            The record is gone: Redis was restarted and has lost it, or it was deleted.
        """
        with self.client.pipeline(transaction=False) as pipe:
            # The command waits for the writes of its own connection, and all before them.
            pipe.set(Keys.READY, b"", ex=60)
            pipe.execute_command("WAITAOF", 1, 0, max(1, round(1000 * self.seconds)))
            # A connection that broke is opened again, maybe to a server that lost the record.
            pipe.exists(key)
            written, waited, exists = pipe.execute(raise_on_error=False)
        if isinstance(written, Exception):
            raise written
        if isinstance(waited, ResponseError):
            if not any(mark in str(waited) for mark in _NO_PROMISE):
                raise waited
            log.debug("Redis does not say what is on its disk", error=str(waited))
        elif not waited[0]:
            raise NotOnDisk(f"Redis has not written its file within {self.seconds} s")
        if not exists:
            raise RecordLost("Redis was restarted and has lost what it had taken")
