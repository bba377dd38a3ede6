"""Locks that expire unless their holder is alive and renews them."""

import threading
from collections.abc import Iterator
from contextlib import contextmanager

from redis import Redis
from redis.exceptions import RedisError

from broker.store import scripts


@contextmanager
def renewed(client: Redis, key: str, holder: str, seconds: float) -> Iterator[threading.Event]:
    """Renew a lock that is held, and release it at the end.

    Parameters
    ----------
    client
        Connection to Redis.
    key
        Key of the lock.
    holder
        Its value.
    seconds
        Time after which it expires when it is not renewed.

    Yields
    ------
    threading.Event
        Is set when the lock was lost, as after a standstill of this process.
    """
    done, lost = threading.Event(), threading.Event()

    def renew() -> None:
        while not done.wait(seconds / 5):
            try:
                kept = scripts.RENEW_LOCK(client, [key], holder, int(seconds * 1000))
            except RedisError:
                continue  # once more, until it has expired
            if not kept:
                lost.set()
                return

    thread = threading.Thread(target=renew, daemon=True)
    thread.start()
    try:
        yield lost
    finally:
        done.set()
        thread.join()
        scripts.RELEASE_LOCK(client, [key], holder)
