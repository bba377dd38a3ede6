"""Who is there to work, and how much there is to do, as the queue's own records say."""

from collections.abc import Sequence
from datetime import UTC, datetime, timedelta
from typing import Final

from redis import Redis
from rq import Queue, Worker
from rq.utils import utcparse

from broker.store import text

SILENCE: Final = timedelta(seconds=30)
"""After so long without a heartbeat a worker counts as dead; one is due every 15 s at least."""


def worker_states(client: Redis) -> list[str]:
    """Return what each worker does that is alive and ready: ``idle``, ``busy`` and the like.

    One that was killed counts as alive until its heartbeat is overdue.

    Parameters
    ----------
    client
        Connection to the Redis of the queue.
    """
    with client.pipeline(transaction=False) as pipe:
        for name in Worker.all_keys(connection=client):
            pipe.hmget(name, ["death", "last_heartbeat", "state"])
        replies = pipe.execute()
    oldest = datetime.now(UTC) - SILENCE
    return [
        text(state or b"?")
        for death, heartbeat, state in replies
        if death is None and heartbeat is not None and utcparse(text(heartbeat)) >= oldest
    ]


def depths(queues: Sequence[Queue]) -> dict[str, tuple[int, int]]:
    """Return how many jobs wait and how many run, by the name of their queue."""
    with queues[0].connection.pipeline(transaction=False) as pipe:
        for queue in queues:
            pipe.llen(queue.key)
            pipe.zcard(queue.started_job_registry.key)
        counts = pipe.execute()
    names = (queue.name for queue in queues)
    return dict(zip(names, zip(counts[::2], counts[1::2], strict=True), strict=True))
