"""The spectrum cache in Redis: least recently used, bounded in bytes; locks and counters.

Signatures, simplified meshes and the spectra of prototypes' surfaces are cached with the spectra,
under names of their own, which begin with the shape's or prototype's id.

The cache is common to all tenants. What is shown of a job must not depend on whether another tenant
has the same shape, so it is noted which blobs a tenant has used: only of those it learns that they
are cached (:meth:`Spectra.known`).
"""

import time
from collections.abc import Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager, suppress
from dataclasses import dataclass
from typing import Final

from redis import Redis
from redis.exceptions import ConnectionError as RedisConnectionError
from redis.exceptions import OutOfMemoryError, RedisError
from redis.exceptions import TimeoutError as RedisTimeoutError

from broker.circuit_breaker import CircuitBreaker
from broker.contracts import SpectrumKey
from broker.store import scripts
from broker.store.connections import memory
from broker.store.keys import Keys
from broker.store.leases import renewed
from broker.store.replies import blob, text
from broker.store.tenant_data import TenantData
from broker.telemetry import logger

log = logger("isomatch.store")

_LARGEST: Final = 500 * 1024**2
"""Bytes of one value; Redis closes the connection at more than 512 MiB (proto-max-bulk-len)."""

_REST: Final = 6.0
"""Seconds for which a cache that cannot be reached is left alone, for each that was waited for it:
a minute after a timeout, and hardly any time if it refuses connections."""

_CIRCUIT: Final = CircuitBreaker()
"""That of the cache; each job is a process, which would wait anew."""


class _CircuitOpen(Exception):
    """The cache is not used, because it has recently not answered."""


@dataclass(frozen=True)
class SpectrumCounts:
    """Numbers of spectra that were computed, and read from the cache."""

    computed: int
    hits: int


@dataclass(frozen=True)
class Spectra(TenantData):
    """The cached spectra, as bytes.

    The cache may have a Redis of its own, which may evict; locks and counters stay in the Redis of
    the queue, which evicts nothing. Such a cache may also fail: a spectrum that cannot be read is
    computed again. A cache in the Redis of the queue leaves the queue its memory.
    """

    circuit: CircuitBreaker = _CIRCUIT

    @property
    def is_separate(self) -> bool:
        """Whether the cache has a Redis of its own."""
        return self.cache is not self.client

    def has(self, key: SpectrumKey) -> bool:
        """Whether a spectrum is cached."""
        with self._tolerating_failure():
            return bool(self._available_cache().exists(Keys.cached_spectrum(key)))
        return False

    def known(self, names: Sequence[SpectrumKey | str]) -> list[bool]:
        """Whether this tenant has used these blobs of its shapes, which may still be cached."""
        with self.client.pipeline(transaction=False) as pipe:
            for name in map(str, names):
                pipe.sismember(self.keys.cached_of(_subject(name)), name)
            return [bool(reply) for reply in pipe.execute()]

    def forget(self, names: Sequence[str]) -> None:
        """Forget which blobs of deleted shapes and prototypes this tenant has used."""
        if names:
            self.client.delete(*map(self.keys.cached_of, names))

    def _note(self, names: Sequence[str]) -> None:
        if not names:
            return
        # A full Redis fails no job for this.
        with suppress(OutOfMemoryError), self.client.pipeline(transaction=False) as pipe:
            for name in names:
                key = self.keys.cached_of(_subject(name))
                pipe.sadd(key, name)
                pipe.expire(key, self.settings.cache_ttl)
            pipe.execute()

    def get(self, key: SpectrumKey | str) -> bytes | None:
        """Return a cached spectrum, npz, or another cached blob by its name, and record the use."""
        (found,) = self.get_many([str(key)])
        return found

    def get_many(self, names: Sequence[str]) -> list[bytes | None]:
        """Return the cached blobs of these names, None for the others, and record the use."""
        if not names:
            return []
        found: list[bytes | None] = [None] * len(names)
        with self._tolerating_failure():
            replies = self._available_cache().mget([*map(Keys.cached_spectrum, names)])
            found = [blob(reply) for reply in replies]
            now = time.time()
            used = {name: now for name, data in zip(names, found, strict=True) if data is not None}
            if used:
                self.cache.zadd(Keys.CACHED_SPECTRA, used, xx=True)
        self._note([name for name, data in zip(names, found, strict=True) if data is not None])
        return found

    def put(self, key: SpectrumKey | str, spectrum: bytes) -> bool:
        """Cache a spectrum, or another blob by its name; False if it cannot be cached."""
        if len(spectrum) > _LARGEST:
            return False
        now, stored = time.time(), False
        with self._tolerating_failure():
            stored = scripts.CACHE_PUT(
                self._available_cache(),
                [Keys.CACHED_SPECTRA, Keys.CACHED_SIZES, Keys.cached_spectrum(key)],
                str(key),
                Keys.cached_spectrum(""),
                now,
                now - self.settings.cache_ttl,
                self.budget(),
                spectrum,
            )
        if stored:
            self._note([str(key)])
        return bool(stored)

    def budget(self) -> int:
        """Return the bytes that the cache may take, now: with the queue, half of what that leaves.

        The script that caches is not refused by a full Redis, which evicts nothing, so that cached
        spectra would stay, and no job could be queued.
        """
        if self.is_separate:
            return self.settings.cache_bytes
        used, limit = memory(self.client)
        if limit == 0:
            return self.settings.cache_bytes
        left = limit - used + self.cached_bytes()
        return max(0, min(self.settings.cache_bytes, left // 2))

    def drop(self, shape_id: str) -> None:
        """Remove all blobs of a shape or prototype from the cache."""
        with self._tolerating_failure():
            cache = self._available_cache()
            for name in self._names(shape_id):
                scripts.CACHE_DROP(
                    cache,
                    [Keys.CACHED_SPECTRA, Keys.CACHED_SIZES],
                    name,
                    Keys.cached_spectrum(""),
                )

    def _names(self, shape_id: str) -> Iterator[str]:
        if not self.is_separate:
            for name, _ in self.cache.zscan_iter(Keys.CACHED_SPECTRA, match=f"{shape_id}:*"):
                yield text(name)
            return
        # The list of cached names may itself have been evicted.
        prefix = Keys.cached_spectrum("")
        for key in self.cache.scan_iter(f"{prefix}{shape_id}:*", count=1000):
            yield text(key).removeprefix(prefix)

    @contextmanager
    def _tolerating_failure(self) -> Iterator[None]:
        """Ignore failures of a separate cache, and of a full Redis; it does not evict."""
        start = time.monotonic()
        try:
            yield
        except _CircuitOpen:
            return
        except RedisError as error:
            if not (self.is_separate or isinstance(error, OutOfMemoryError)):
                raise
            log.warning("the cache cannot be used", error=str(error))
            if isinstance(error, RedisConnectionError | RedisTimeoutError):
                self.circuit.open(_REST * (time.monotonic() - start))
        else:
            self.circuit.close()

    def _available_cache(self) -> Redis:
        """Return the connection to the cache.

        Raises
        ------
        _CircuitOpen
            The circuit breaker is open.
        """
        if self.is_separate and self.circuit.is_open():
            raise _CircuitOpen
        return self.cache

    def lock(self, key: SpectrumKey, holder: str, seconds: float) -> bool:
        """Lock the computation of a spectrum for some seconds; False if another process has."""
        milliseconds = int(seconds * 1000)
        return bool(self.client.set(Keys.spectrum_lock(key), holder, nx=True, px=milliseconds))

    def renewed(
        self, key: SpectrumKey, holder: str, seconds: float
    ) -> AbstractContextManager[object]:
        """Renew the lock of a spectrum, and release it at the end."""
        return renewed(self.client, Keys.spectrum_lock(key), holder, seconds)

    def locked(self, key: SpectrumKey) -> bool:
        """Whether a live process computes a spectrum."""
        return bool(self.client.exists(Keys.spectrum_lock(key)))

    def unmark_queued(self, key: SpectrumKey, job_id: str) -> None:
        """Record that a job is not queued to compute a spectrum any more; another one may be."""
        scripts.RELEASE_LOCK(self.client, [self.keys.spectrum_job(key)], job_id)

    def count_computed(self) -> None:
        """Count a computed spectrum."""
        self.client.hincrby(Keys.SPECTRUM_COUNTERS, "computed", 1)

    def count_hit(self) -> None:
        """Count a spectrum read from the cache."""
        self.client.hincrby(Keys.SPECTRUM_COUNTERS, "hits", 1)

    def cached_bytes(self) -> int:
        """Return the size of all cached blobs, as far as it is known."""
        with self._tolerating_failure():
            return int(self._available_cache().hget(Keys.CACHED_SIZES, "total") or 0)
        return 0

    def counts(self) -> SpectrumCounts:
        """Return the counters."""
        computed, hits = self.client.hmget(Keys.SPECTRUM_COUNTERS, ["computed", "hits"])
        return SpectrumCounts(int(computed or 0), int(hits or 0))


def _subject(name: str) -> str:
    """Return the id of the shape or prototype that a cached blob is of."""
    return name.partition(":")[0]
