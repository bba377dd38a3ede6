"""``python -m worker.process.health``: health check of the worker of this machine or container.

A worker is healthy if its last heartbeat is recent. If Redis does not answer, the check succeeds:
the worker waits for Redis, and a restart would not help.

It reads RQ's records with nothing but the client of Redis: it is started all the time, and to load
RQ and our contracts takes a second of the core that the worker's job needs.
"""

import os
import socket
import sys
from datetime import UTC, datetime, timedelta
from typing import Any, Final

from redis import Redis
from redis.exceptions import RedisError

_GIVEN_UP: Final = 5.0
"""Seconds after which Redis does not answer: fewer than those after which Docker and Kubernetes
give the check up, and so find the worker unhealthy."""

_SILENT: Final = timedelta(seconds=30)
"""A worker without a heartbeat for so long is dead, as for :mod:`broker.queue.workers`."""

_WORKERS: Final = "rq:workers"
"""Set of the keys of RQ's workers, each of a hash."""


def main() -> int:
    """Return 0 if the worker is healthy or Redis does not answer, 1 if it is not healthy."""
    url = os.environ.get("ISOMATCH_REDIS_URL")
    if not url:
        print("ISOMATCH_REDIS_URL is not set", file=sys.stderr)
        return 2
    try:
        client = Redis.from_url(
            url, socket_timeout=_GIVEN_UP, socket_connect_timeout=_GIVEN_UP, retry=None
        )
    except ValueError:
        # The error may quote a part of the password.
        print("ISOMATCH_REDIS_URL: not an address of a Redis", file=sys.stderr)
        return 2
    with client:
        try:
            healthy = has_live_worker(client, socket.gethostname())
        except RedisError as error:
            print(f"Redis does not answer, so the state of the worker is unknown: {error}")
            return 0
    print("healthy" if healthy else "no recent heartbeat")
    return 0 if healthy else 1


def has_live_worker(client: Redis, host: str) -> bool:
    """Return whether a worker of a host has sent a heartbeat recently.

    Parameters
    ----------
    client
        Connection to the Redis of the queue.
    host
        Name of the machine or container.
    """
    names: Any = client.smembers(_WORKERS)
    with client.pipeline(transaction=False) as pipe:
        for name in names:
            pipe.hmget(name, ["hostname", "death", "last_heartbeat"])
        replies = pipe.execute()
    oldest = datetime.now(UTC) - _SILENT
    return any(
        hostname == host.encode()
        and death is None
        and heartbeat is not None
        and datetime.fromisoformat(heartbeat.decode()) >= oldest
        for hostname, death, heartbeat in replies
    )


if __name__ == "__main__":
    sys.exit(main())
