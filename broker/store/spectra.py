"""The spectrum cache in Redis: bounded in bytes, and who computes which spectrum.

Signatures, which are made of spectra, the simplified meshes that spectra are of, and spectra of the
surfaces of prototypes are kept with them, under names of their own.
"""

import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Final

from redis import Redis
from redis.exceptions import RedisError
from redis.exceptions import TimeoutError as RedisTimeoutError

from broker.contracts import SpectrumKey
from broker.store import keys, scripts
from broker.store.absence import Absence
from broker.store.connections import CACHE_SILENT_LULL, StoreSettings
from broker.store.replies import blob, text
from broker.telemetry import logger

log = logger("isomatch.store")

_LARGEST: Final = 500 * 1024**2
"""Bytes of one value; Redis hangs up on whoever sends more than 512 MiB."""


class _StillAway(Exception):  # noqa: N818 - said of the cache
    """The cache is not asked, for it was away a moment ago."""


@dataclass(frozen=True)
class SpectrumCounts:
    """How often a spectrum was computed, and how often one was taken from the cache."""

    computed: int
    hits: int


@dataclass(frozen=True)
class Spectra:
    """The cached spectra, as bytes.

    The cache may live in a Redis of its own, with its own policy of eviction; locks and counters
    stay with the queue, where nothing is evicted. One of its own may be away, or lose what it has:
    what is not found there is computed again.

    Parameters
    ----------
    cache
        Connection to the Redis of the cache.
    client
        Connection to the Redis of the queue.
    settings
        Budget and time to live.
    """

    cache: Redis
    client: Redis
    settings: StoreSettings
    absence: Absence = field(init=False)

    def __post_init__(self) -> None:
        """Look whether the cache is away where all processes of this machine do."""
        object.__setattr__(self, "absence", Absence(self.client))

    @property
    def apart(self) -> bool:
        """Whether the cache has a Redis of its own."""
        return self.cache is not self.client

    def has(self, key: SpectrumKey) -> bool:
        """Whether a spectrum is cached."""
        with self._spared():
            return bool(self._asked().exists(keys.cached_spectrum(key)))
        return False

    def get(self, key: SpectrumKey | str) -> bytes | None:
        """Return a cached spectrum, npz, or what is cached by a name; note that it was used."""
        (found,) = self.signatures([str(key)])
        return found

    def signatures(self, names: Sequence[str]) -> list[bytes | None]:
        """Return the cached signatures of these names, None for others, and note their use."""
        found: list[bytes | None] = [None] * len(names)
        with self._spared():
            if names:
                replies = self._asked().mget([*map(keys.cached_spectrum, names)])
                found = [blob(reply) for reply in replies]
            now = time.time()
            used = {name: now for name, data in zip(names, found, strict=True) if data is not None}
            if used:
                self.cache.zadd(keys.CACHED_SPECTRA, used, xx=True)
        return found

    def put(self, key: SpectrumKey | str, spectrum: bytes) -> bool:
        """Cache a spectrum, or something else by its name; False if it cannot be."""
        if len(spectrum) > _LARGEST:
            return False
        now = time.time()
        with self._spared():
            stored = self._asked().eval(
                scripts.CACHE_PUT,
                3,
                keys.CACHED_SPECTRA,
                keys.CACHED_SIZES,
                keys.cached_spectrum(key),
                str(key),
                keys.cached_spectrum(""),
                now,
                now - self.settings.cache_ttl,
                self.settings.cache_bytes,
                spectrum,
            )
            return bool(stored)
        return False

    def forget(self, shape_id: str) -> None:
        """Take all spectra of a shape out of the cache."""
        with self._spared():
            cache = self._asked()
            for name in self._names(shape_id):
                cache.eval(
                    scripts.CACHE_DROP,
                    2,
                    keys.CACHED_SPECTRA,
                    keys.CACHED_SIZES,
                    name,
                    keys.cached_spectrum(""),
                )

    def _names(self, shape_id: str) -> Iterator[str]:
        if not self.apart:
            for name, _ in self.cache.zscan_iter(keys.CACHED_SPECTRA, match=f"{shape_id}:*"):
                yield text(name)
            return
        # The list of what is cached may itself have been evicted; what is listed has its key.
        prefix = keys.cached_spectrum("")
        for key in self.cache.scan_iter(f"{prefix}{shape_id}:*", count=1000):
            yield text(key).removeprefix(prefix)

    @contextmanager
    def _spared(self) -> Iterator[None]:
        """Do without a cache of its own that is away, or that is full and evicts nothing."""
        try:
            yield
        except _StillAway:
            return
        except RedisError as error:
            if not self.apart:
                raise
            log.warning("the cache cannot be used", error=str(error))
            if isinstance(error, RedisTimeoutError):
                self.absence.begin(CACHE_SILENT_LULL)
        else:
            self.absence.end()

    def _asked(self) -> Redis:
        """Return the cache, to be asked.

        Raises
        ------
        _StillAway
            It was away a moment ago, and would only cost the time of whoever waits for it.
        """
        if self.apart and self.absence.lasts():
            raise _StillAway
        return self.cache

    def lock(self, key: SpectrumKey, holder: str, seconds: float) -> bool:
        """Become the one who computes a spectrum, for some seconds; False if somebody else is."""
        milliseconds = int(seconds * 1000)
        return bool(self.client.set(keys.spectrum_lock(key), holder, nx=True, px=milliseconds))

    def renew(self, key: SpectrumKey, holder: str, seconds: float) -> bool:
        """Stay the one who computes a spectrum; False if that was lost."""
        milliseconds = int(seconds * 1000)
        return bool(
            self.client.eval(scripts.RENEW, 1, keys.spectrum_lock(key), holder, milliseconds)
        )

    def release(self, key: SpectrumKey, holder: str) -> None:
        """Let others compute a spectrum."""
        self.client.eval(scripts.RELEASE, 1, keys.spectrum_lock(key), holder)

    def locked(self, key: SpectrumKey) -> bool:
        """Whether somebody alive computes a spectrum."""
        return bool(self.client.exists(keys.spectrum_lock(key)))

    def order(self, key: SpectrumKey, job_id: str, seconds: int) -> bool:
        """Note that a job was queued to compute a spectrum; False if one already is."""
        return bool(self.client.set(keys.spectrum_job(key), job_id, nx=True, ex=seconds))

    def settle(self, key: SpectrumKey) -> None:
        """Note that no job is queued to compute a spectrum any more."""
        self.client.delete(keys.spectrum_job(key))

    def count_computed(self) -> None:
        """Count one more spectrum that was computed."""
        self.client.hincrby(keys.SPECTRUM_COUNTERS, "computed", 1)

    def count_hit(self) -> None:
        """Count one more spectrum that was taken from the cache."""
        self.client.hincrby(keys.SPECTRUM_COUNTERS, "hits", 1)

    def cached_bytes(self) -> int:
        """Return the size of all cached spectra, as far as it is known."""
        with self._spared():
            return int(self._asked().hget(keys.CACHED_SIZES, "total") or 0)
        return 0

    def counts(self) -> SpectrumCounts:
        """Return the counters."""
        computed, hits = self.client.hmget(keys.SPECTRUM_COUNTERS, ["computed", "hits"])
        return SpectrumCounts(int(computed or 0), int(hits or 0))
