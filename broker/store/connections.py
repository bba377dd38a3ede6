"""Connections to Redis that outlive its restarts, and the settings of the store."""

import math
import time
from typing import Final, Self

from pydantic import Field
from pydantic_settings import BaseSettings
from redis import Redis
from redis.backoff import AbstractBackoff, ConstantBackoff
from redis.exceptions import ConnectionError as RedisConnectionError
from redis.exceptions import TimeoutError as RedisTimeoutError
from redis.retry import Retry

from broker.environment import FROM_ENVIRONMENT, RedisUrl

DAY: Final = 86400
SOCKET_TIMEOUT: Final = 30.0
"""Seconds; more than RQ's workers wait for a job in one command."""

CACHE_PATIENCE: Final = 1.0
"""Seconds for which a command is repeated while a cache with a Redis of its own is away."""

CACHE_LULL: Final = 10.0
"""Seconds after which it is waited for again: a match looks for six things there."""

CACHE_SILENCE: Final = 10.0
"""Seconds after which such a cache that takes a command and says nothing counts as away; a spectrum
of some ten megabytes has to come through in these."""

CACHE_SILENT_LULL: Final = 60.0
"""Seconds after which one that said nothing is asked again, by any process of a machine."""


class StoreSettings(BaseSettings):
    """Where the store is and how long it keeps what; from ``ISOMATCH_*``."""

    model_config = FROM_ENVIRONMENT

    redis_url: RedisUrl | None = Field(
        default=None, description="Redis of queue and store; none: the server starts its own."
    )
    cache_url: RedisUrl | None = Field(
        default=None, description="Redis of the spectrum cache, if it has one of its own."
    )
    cache_bytes: int = Field(default=2 * 1024**3, ge=0, description="Budget of the cache.")
    cache_ttl: int = Field(
        default=30 * DAY, ge=1, description="Seconds after which an unused spectrum is dropped."
    )
    shape_ttl: int = Field(
        default=30 * DAY,
        ge=1,
        description="Seconds a shape or a prototype is kept after it was last used.",
    )
    result_ttl: int = Field(default=7 * DAY, ge=1, description="Seconds a result is kept.")
    job_ttl: int = Field(
        default=30 * DAY, ge=1, description="Seconds the record of a job that has ended is kept."
    )
    trace_ttl: int = Field(
        default=90 * DAY,
        ge=1,
        description="Seconds for which it is remembered that there was a shape or a job that has"
        " expired.",
    )
    candidate_ttl: int = Field(
        default=3600, ge=1, description="Seconds an upload waits for its validation at most."
    )


class OnceInAWhile(AbstractBackoff):
    """Pauses for a store that is away only once in a while, and otherwise gives it up at once.

    Parameters
    ----------
    pause
        Seconds between two attempts.
    lull
        Seconds after a pause in which there is no other.
    """

    def __init__(self, pause: float, lull: float) -> None:
        self._pause = pause
        self._lull = lull
        self._last = -math.inf

    def __deepcopy__(self, memo: object) -> Self:
        """Return this one itself: what one connection has found out holds for all."""
        return self

    def reset(self) -> None:
        """Remember the last pause from one command to the next."""

    def compute(self, failures: int) -> float:
        """Return how long to wait before the next attempt."""
        now = time.monotonic()
        if now - self._last < self._lull:
            return 0.0
        self._last = now
        return self._pause


def connect(
    url: str,
    patience: float,
    pause: float = 1.0,
    silence: float | None = None,
    lull: float = 0.0,
) -> Redis:
    """Return a client that repeats what fails while Redis restarts.

    Without this a job that ends just then would be lost although it is computed.

    Parameters
    ----------
    url
        ``redis://``, ``rediss://`` or ``unix://``.
    patience
        Seconds for which a command is repeated before its error is raised.
    pause
        Seconds between two attempts.
    silence
        Seconds after which a command without an answer has failed, and is not repeated: for those
        who cannot wait. None for those who can, such as workers.
    lull
        Seconds after a pause in which it is not waited for again.
    """
    errors = [RedisConnectionError] if silence else [RedisConnectionError, RedisTimeoutError]
    attempts = max(0, round(patience / pause))
    backoff = OnceInAWhile(pause, lull) if lull else ConstantBackoff(pause)
    return Redis.from_url(
        url,
        socket_timeout=silence or SOCKET_TIMEOUT,
        socket_connect_timeout=5.0,
        # Spectra and meshes are megabytes; the default of 32 KiB takes twice the time for them.
        socket_read_size=1024**2,
        health_check_interval=30,
        retry=Retry(backoff, attempts, tuple(errors)),
        retry_on_error=errors,
    )
