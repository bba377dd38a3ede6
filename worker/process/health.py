"""``python -m worker.process.health``: whether the worker of this machine or container works.

It does if it gave a sign of life not long ago. A worker that waits for Redis to come back is not
ill, and starting it again would help nobody: where Redis does not answer, nothing is said of it.
"""

import socket
import sys
from datetime import UTC, datetime

from pydantic import ValidationError
from redis import Redis
from redis.exceptions import RedisError
from rq import Worker
from rq.utils import utcparse

from broker.environment import complaints
from broker.queue import SILENCE
from broker.store import StoreSettings, connect, text


def main() -> int:
    """Return 0 if the worker works, or if that cannot be known; 1 if it does not."""
    try:
        settings = StoreSettings()
    except ValidationError as error:
        print("\n".join(complaints(error)), file=sys.stderr)
        return 2
    if settings.redis_url is None:
        print("ISOMATCH_REDIS_URL is not set", file=sys.stderr)
        return 2
    with connect(settings.redis_url, patience=0) as client:
        try:
            works = works_on(client, socket.gethostname())
        except RedisError as error:
            print(f"Redis does not answer, and says nothing of the worker: {error}")
            return 0
    print("it works" if works else "no sign of life")
    return 0 if works else 1


def works_on(client: Redis, host: str) -> bool:
    """Whether a worker of a host gave a sign of life not long ago.

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
    oldest = datetime.now(UTC) - SILENCE
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
