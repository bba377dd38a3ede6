"""The store: shapes, prototypes, jobs, results, spectra; records in Redis, large bytes as blobs."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Self

from redis import Redis
from redis.client import Pipeline

from broker.blobs import open_blobs
from broker.contracts import DEFAULT_TENANT
from broker.store.admission import Admission, KeyReused, TooManyQueued
from broker.store.api_keys import ApiKeys, NameTaken, NoSuchKey, StoredKey
from broker.store.attributes import Attributes
from broker.store.blobs import FOLDERS, BlobReference, Blobs, pieces, size_of
from broker.store.chunks import Chunks, ClaimedChunk, ClaimStatus, StageCounts
from broker.store.connections import (
    CACHE_PAUSE,
    CACHE_TIMEOUT,
    CONNECT_TIMEOUT,
    StoreSettings,
    connect,
    memory,
)
from broker.store.counters import BUCKET_BOUNDS, Counters, CounterValues, Histogram
from broker.store.durability import LEAST_WAIT, Durability, NotOnDisk, RecordLost
from broker.store.jobs import ActiveJob, Jobs
from broker.store.keys import DEFAULT_KEYS, PREFIX, Keys
from broker.store.leases import renewed
from broker.store.listings import InvalidCursor, Listing, Page
from broker.store.prototypes import Prototypes
from broker.store.quotas import Quota, QuotaExceeded, Quotas
from broker.store.record_store import RecordStore
from broker.store.records import NewerRecord
from broker.store.replies import text
from broker.store.results import Results
from broker.store.shapes import Shapes
from broker.store.spectra import Spectra, SpectrumCounts
from broker.store.transactions import transact
from broker.store.uploads import CandidateGone, Uploads
from broker.store.watching import any_running, have_ended, signs
from broker.store.webhooks import Webhooks

__all__ = [
    "BUCKET_BOUNDS",
    "CONNECT_TIMEOUT",
    "DEFAULT_KEYS",
    "FOLDERS",
    "PREFIX",
    "ActiveJob",
    "Admission",
    "ApiKeys",
    "Attributes",
    "BlobReference",
    "Blobs",
    "CandidateGone",
    "Chunks",
    "ClaimStatus",
    "ClaimedChunk",
    "CounterValues",
    "Counters",
    "Durability",
    "Histogram",
    "InvalidCursor",
    "Jobs",
    "KeyReused",
    "Keys",
    "Listing",
    "NameTaken",
    "NewerRecord",
    "NoSuchKey",
    "NotOnDisk",
    "Page",
    "Prototypes",
    "Quota",
    "QuotaExceeded",
    "Quotas",
    "RecordLost",
    "RecordStore",
    "Results",
    "Shapes",
    "Spectra",
    "SpectrumCounts",
    "StageCounts",
    "Store",
    "StoreSettings",
    "StoredKey",
    "TooManyQueued",
    "Uploads",
    "Webhooks",
    "any_running",
    "connect",
    "have_ended",
    "memory",
    "pieces",
    "renewed",
    "signs",
    "size_of",
    "text",
    "transact",
]


@dataclass(frozen=True)
class Store:
    """Everything that is kept of a tenant, by subject; spectra and counters are common to all.

    Parameters
    ----------
    client
        Connection to the Redis of queue and store.
    blobs
        The large bytes, in the blob store.
    shapes, prototypes, attributes, uploads, jobs, results, admission, chunks, spectra, counters
    webhooks
        Its subjects.
    durability
        Waiting until they are on the disk.
    api_keys
        The API keys of all tenants.
    quotas
        The tenant's quota.
    keys
        The tenant's keys.
    """

    client: Redis
    blobs: Blobs
    shapes: Shapes
    prototypes: Prototypes
    attributes: Attributes
    uploads: Uploads
    jobs: Jobs
    results: Results
    admission: Admission
    chunks: Chunks
    spectra: Spectra
    counters: Counters
    webhooks: Webhooks
    durability: Durability
    api_keys: ApiKeys
    quotas: Quotas
    keys: Keys

    @classmethod
    def open(
        cls,
        settings: StoreSettings,
        retry_seconds: float,
        pause: float = 1.0,
        timeout: float | None = None,
        forks: bool = False,
    ) -> Self:
        """Connect to the store.

        Parameters
        ----------
        settings
            Its addresses are `redis_url` and `blob_url`.
        retry_seconds, pause
            Seconds for which a command is repeated while Redis does not answer, and between two
            attempts.
        timeout
            Seconds after which a command without a reply has failed; None to repeat it, too.
        forks
            Whether this process forks others that open the store themselves.

        Raises
        ------
        ValueError
            An address is not set.
        """
        if settings.redis_url is None:
            raise ValueError("ISOMATCH_REDIS_URL is not set")
        client = connect(settings.redis_url, retry_seconds, pause, timeout)
        return cls.over(client, settings, retry_seconds, pause, forks)

    @classmethod
    def over(
        cls,
        client: Redis,
        settings: StoreSettings,
        retry_seconds: float,
        pause: float = 1.0,
        forks: bool = False,
    ) -> Self:
        """Return the store over an existing connection; parameters as for :meth:`open`."""
        if settings.blob_url is None:
            raise ValueError("ISOMATCH_BLOB_URL is not set")
        blobs = Blobs(client, open_blobs(settings.blob_url, retry_seconds, forks))
        cache = client
        if settings.cache_url is not None:
            cache = connect(settings.cache_url, CACHE_PAUSE, CACHE_PAUSE, CACHE_TIMEOUT)
        durability = Durability(client, max(retry_seconds, LEAST_WAIT))
        return cls._assemble(client, cache, settings, blobs, durability, DEFAULT_KEYS)

    @classmethod
    def _assemble(
        cls,
        client: Redis,
        cache: Redis,
        settings: StoreSettings,
        blobs: Blobs,
        durability: Durability,
        keys: Keys,
    ) -> Self:
        return cls(
            client,
            blobs,
            Shapes(client, settings, blobs, keys),
            Prototypes(client, settings, blobs, keys),
            Attributes(client, settings, blobs, keys),
            Uploads(client, settings, blobs, keys),
            Jobs(client, settings, blobs, keys),
            Results(client, settings, blobs, keys),
            Admission(client, keys),
            Chunks(client, settings, keys),
            Spectra(cache, client, settings, keys),
            Counters(client),
            Webhooks(client, keys),
            durability,
            ApiKeys(client),
            Quotas(client, settings, keys),
            keys,
        )

    def of(self, tenant: str) -> Self:
        """Return the store of a tenant, over the same connections."""
        keys = Keys(tenant)
        if keys == self.keys:
            return self
        cache, settings = self.spectra.cache, self.spectra.settings
        return self._assemble(self.client, cache, settings, self.blobs, self.durability, keys)

    def tenants(self) -> list[str]:
        """Return the names of all tenants that have had jobs, and of the default one."""
        return [DEFAULT_TENANT, *sorted(map(text, self.client.smembers(Keys.TENANTS)))]

    def of_each(self, ask: Callable[[Pipeline, Keys], object]) -> dict[str, Any]:
        """Return the reply to one command for each tenant, by its name, in one round trip.

        Parameters
        ----------
        ask
            Adds the command to a pipeline, given the tenant's keys.
        """
        tenants = self.tenants()
        with self.client.pipeline(transaction=False) as pipe:
            for tenant in tenants:
                ask(pipe, Keys(tenant))
            return dict(zip(tenants, pipe.execute(), strict=True))

    def check(self) -> None:
        """Check that Redis and the blob store answer and accept writes.

        Raises
        ------
        RedisError
            Redis does not answer, is full, or is a replica.
        BlobError
            The blob store does not answer, is full, or is that of another Redis.
        """
        self.client.set(Keys.READY, b"", ex=60)
        self.blobs.check()

    def close(self) -> None:
        """Close the connections."""
        self.spectra.cache.close()
        self.client.close()
