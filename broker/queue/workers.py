"""States of the workers and lengths of the queues, from RQ's own records."""

from collections.abc import Iterable, Sequence
from datetime import UTC, datetime, timedelta
from typing import Final, cast

from redis import Redis
from rq import Queue, Worker
from rq.job import Job
from rq.utils import utcparse
from rq.worker_registration import REDIS_WORKER_KEYS

from broker.store import text

WORKER_TIMEOUT: Final = timedelta(seconds=30)
"""A worker without a heartbeat for so long counts as dead; one is due every 15 s at least."""

_SAMPLE: Final = 8
"""Workers of which one is alive, unless hardly any is."""

_NEXT: Final = 200
"""Jobs at the front of a queue, of which the oldest is sought."""


def worker_states(client: Redis) -> list[str]:
    """Return the state of each live worker, such as ``idle`` or ``busy``.

    A killed worker counts as alive until its heartbeat is overdue.

    Parameters
    ----------
    client
        Connection to the Redis of the queue.
    """
    return _states(client, Worker.all_keys(connection=client))


def any_worker(client: Redis) -> bool:
    """Return whether a worker is alive; takes as long with a thousand workers as with one."""
    some = cast(list[bytes], client.srandmember(REDIS_WORKER_KEYS, _SAMPLE))
    return bool(_states(client, map(text, some)) or worker_states(client))


def _states(client: Redis, names: Iterable[str]) -> list[str]:
    with client.pipeline(transaction=False) as pipe:
        for name in names:
            pipe.hmget(name, ["death", "last_heartbeat", "state"])
        replies = pipe.execute()
    oldest = datetime.now(UTC) - WORKER_TIMEOUT
    return [
        text(state or b"?")
        for death, heartbeat, state in replies
        if death is None and heartbeat is not None and utcparse(text(heartbeat)) >= oldest
    ]


def longest_wait(queues: Sequence[Queue]) -> float:
    """Return the seconds for which the oldest of the next jobs has waited; 0 if none waits.

    Parameters
    ----------
    queues
        The queues.
    """
    waiting = [job for queue in queues for job in queue.get_job_ids(0, _NEXT)]
    with queues[0].connection.pipeline(transaction=False) as pipe:
        for job in waiting:
            pipe.hget(Job.key_for(job), "enqueued_at")
        replies = pipe.execute()
    times = [utcparse(text(reply)) for reply in replies if reply is not None]
    # The clock of the machine that queued it may be ahead.
    return max(((datetime.now(UTC) - min(times)).total_seconds(), 0.0)) if times else 0.0


def depths(queues: Sequence[Queue]) -> dict[str, tuple[int, int]]:
    """Return the numbers of waiting and running jobs, by queue name."""
    with queues[0].connection.pipeline(transaction=False) as pipe:
        for queue in queues:
            pipe.llen(queue.key)
            pipe.zcard(queue.started_job_registry.key)
        counts = pipe.execute()
    names = (queue.name for queue in queues)
    return dict(zip(names, zip(counts[::2], counts[1::2], strict=True), strict=True))
