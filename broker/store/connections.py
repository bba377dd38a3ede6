"""Connections to Redis that outlive its restarts, and the settings of the store."""

from typing import Final

from pydantic import Field
from pydantic_settings import BaseSettings
from redis import Redis
from redis.backoff import ConstantBackoff
from redis.exceptions import ConnectionError as RedisConnectionError
from redis.exceptions import TimeoutError as RedisTimeoutError
from redis.retry import Retry

from broker.blobs import BlobUrl
from broker.environment import FROM_ENVIRONMENT, RedisUrl

DAY: Final = 86400
SOCKET_TIMEOUT: Final = 30.0
"""Seconds; more than RQ's workers wait for a job in one command."""

CONNECT_TIMEOUT: Final = 5.0
"""Seconds."""

CACHE_TIMEOUT: Final = 10.0
"""Seconds for a reply of a cache with a Redis of its own; enough for some ten megabytes."""

CACHE_PAUSE: Final = 0.01
"""Seconds after which a command to such a cache is repeated, once: its connection may be that of
before a restart. Computing a spectrum again is better than waiting long."""


class StoreSettings(BaseSettings):
    """Addresses of the store, and times to live; from ``ISOMATCH_*``."""

    model_config = FROM_ENVIRONMENT

    redis_url: RedisUrl | None = Field(
        default=None, description="Redis of queue and store; none: the server starts its own."
    )
    blob_url: BlobUrl | None = Field(
        default=None,
        description="Where meshes, results and files are kept: file:///DIRECTORY or"
        " s3://BUCKET/PREFIX; none: beside the data of the Redis that the server starts.",
    )
    cache_url: RedisUrl | None = Field(
        default=None, description="Redis of the spectrum cache, if it has one of its own."
    )
    cache_bytes: int = Field(
        default=2 * 1024**3,
        ge=0,
        description="Budget of the cache; in the Redis of the queue, if that has a limit, at most"
        " half of the memory that the queue leaves.",
    )
    cache_ttl: int = Field(
        default=30 * DAY, ge=1, description="Seconds after which an unused spectrum is dropped."
    )
    shape_ttl: int = Field(
        default=30 * DAY,
        ge=1,
        description="Seconds a shape, a prototype or an attribute file is kept after it was last"
        " used.",
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
    tenant_shapes: int = Field(
        default=0, ge=0, description="Shapes a tenant may keep; 0 for any number."
    )
    tenant_bytes: int = Field(
        default=0,
        ge=0,
        description="Bytes a tenant may keep, of uploads, meshes and results; 0 for any number.",
    )
    tenant_jobs: int = Field(
        default=0,
        ge=0,
        description="Jobs a tenant may have queued or running at a time, and as many uploads being"
        " validated; 0 for any number.",
    )
    candidate_ttl: int = Field(
        default=3600, ge=1, description="Seconds an upload waits for its validation at most."
    )


def memory(client: Redis) -> tuple[int, int]:
    """Return the bytes that a Redis uses, and those that it may use; 0 for any number."""
    told = client.info("memory")
    return int(told["used_memory"]), int(told.get("maxmemory", 0))


def server_time(client: Redis) -> float:
    """Return the seconds since the epoch by the clock of a Redis, which all processes share."""
    seconds, microseconds = client.time()
    return float(seconds + microseconds / 1e6)


def connect(
    url: str, retry_seconds: float, pause: float = 1.0, timeout: float | None = None
) -> Redis:
    """Return a client that repeats commands that fail while Redis restarts.

    Otherwise the result of a job that ends during the restart would be lost.

    Parameters
    ----------
    url
        ``redis://``, ``rediss://`` or ``unix://``.
    retry_seconds
        Seconds for which a command is repeated before its error is raised.
    pause
        Seconds between two attempts.
    timeout
        Seconds after which a command without a reply has failed, and is not repeated. None to
        repeat it, too.
    """
    errors = [RedisConnectionError] if timeout else [RedisConnectionError, RedisTimeoutError]
    attempts = max(0, round(retry_seconds / pause))
    return Redis.from_url(
        url,
        socket_timeout=timeout or SOCKET_TIMEOUT,
        socket_connect_timeout=min(CONNECT_TIMEOUT, timeout or CONNECT_TIMEOUT),
        # Bytes. Spectra and meshes are megabytes, and take twice the time with the default 32 KiB.
        socket_read_size=1024**2,
        health_check_interval=30,
        retry=Retry(ConstantBackoff(pause), attempts, tuple(errors)),
        retry_on_error=errors,
    )
