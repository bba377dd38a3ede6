"""``python -m worker.process.health``: health check of the worker of this machine or container.

A worker is healthy if its last heartbeat is recent. If Redis does not answer, the check succeeds:
the worker waits for Redis, and a restart would not help.
"""

import socket
import sys
from datetime import UTC, datetime

from pydantic import ValidationError
from redis import Redis
from redis.exceptions import RedisError
from rq import Worker
from rq.utils import utcparse

from broker.environment import setting_errors
from broker.queue import WORKER_TIMEOUT
from broker.store import CONNECT_TIMEOUT, StoreSettings, connect, text


def main() -> int:
    """Return 0 if the worker is healthy or Redis does not answer, 1 if it is not healthy."""
    try:
        settings = StoreSettings()
    except ValidationError as error:
        print("\n".join(setting_errors(error)), file=sys.stderr)
        return 2
    if settings.redis_url is None:
        print("ISOMATCH_REDIS_URL is not set", file=sys.stderr)
        return 2
    # Sooner than Docker and Kubernetes give the check up, and so find the worker unhealthy.
    with connect(settings.redis_url, retry_seconds=0, timeout=CONNECT_TIMEOUT) as client:
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
    with client.pipeline(transaction=False) as pipe:
        for name in Worker.all_keys(connection=client):
            pipe.hmget(name, ["hostname", "death", "last_heartbeat"])
        replies = pipe.execute()
    oldest = datetime.now(UTC) - WORKER_TIMEOUT
    return any(
        hostname is not None
        and text(hostname) == host
        and death is None
        and heartbeat is not None
        and utcparse(text(heartbeat)) >= oldest
        for hostname, death, heartbeat in replies
    )


if __name__ == "__main__":
    sys.exit(main())
