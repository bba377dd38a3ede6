"""The store: shapes, prototypes, jobs, results, spectra; records in Redis, large bytes as blobs."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Self

from redis import Redis
from redis.client import Pipeline

from broker.blobs import open_blobs
from broker.contracts import DEFAULT_TENANT
from broker.store.admission import Admission, KeyReused, TooManyQueued
from broker.store.api_keys import ApiKeys, NameTaken, NoSuchKey, StoredKey
from broker.store.attributes import Attributes
from broker.store.blobs import FOLDERS, BlobReference, Blobs, pieces, size_of
from broker.store.chunks import Chunks, ClaimedChunk, ClaimStatus, QueuedMatches, StageCounts
from broker.store.connections import (
    CACHE_PAUSE,
    CACHE_TIMEOUT,
    CONNECT_TIMEOUT,
    StoreSettings,
    connect,
    memory,
    server_time,
)
from broker.store.counters import BUCKET_BOUNDS, Counters, CounterValues, Histogram
from broker.store.durability import (
    LEAST_WAIT,
    Durability,
    EvictsRecords,
    NotOnDisk,
    RecordLost,
    check_eviction,
    possible_losses,
)
from broker.store.jobs import ActiveJob, Jobs
from broker.store.keys import DEFAULT_KEYS, PREFIX, Keys
from broker.store.leases import renewed
from broker.store.listings import InvalidCursor, Listing, Page, sweep
from broker.store.prototypes import Prototypes
from broker.store.quotas import Quota, QuotaExceeded, Quotas
from broker.store.record_store import RecordStore
from broker.store.records import NewerRecord
from broker.store.replies import text
from broker.store.results import Results
from broker.store.shapes import Shapes
from broker.store.spectra import Spectra, SpectrumCounts
from broker.store.tenant_data import TenantData
from broker.store.transactions import transact
from broker.store.uploads import CandidateGone, Uploads
from broker.store.watching import are_running, have_ended, signs
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
    "EvictsRecords",
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
    "QueuedMatches",
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
    "are_running",
    "check_eviction",
    "connect",
    "have_ended",
    "memory",
    "pieces",
    "possible_losses",
    "renewed",
    "server_time",
    "signs",
    "size_of",
    "sweep",
    "text",
    "transact",
]


@dataclass(frozen=True)
class Store(TenantData):
    """Everything that is kept of a tenant, by subject; spectra and counters are common to all."""

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
        return cls(client, cache, blobs, settings, DEFAULT_KEYS, durability)

    @cached_property
    def shapes(self) -> Shapes:
        """The shapes."""
        return self._part(Shapes)

    @cached_property
    def prototypes(self) -> Prototypes:
        """The prototypes."""
        return self._part(Prototypes)

    @cached_property
    def attributes(self) -> Attributes:
        """The attribute files."""
        return self._part(Attributes)

    @cached_property
    def uploads(self) -> Uploads:
        """The uploads that are being validated."""
        return self._part(Uploads)

    @cached_property
    def jobs(self) -> Jobs:
        """The jobs."""
        return self._part(Jobs)

    @cached_property
    def results(self) -> Results:
        """The results of jobs."""
        return self._part(Results)

    @cached_property
    def admission(self) -> Admission:
        """Idempotency records and limits of jobs."""
        return self._part(Admission)

    @cached_property
    def chunks(self) -> Chunks:
        """The chunks of jobs that are done in time slices."""
        return self._part(Chunks)

    @cached_property
    def webhooks(self) -> Webhooks:
        """The webhooks that are not delivered yet."""
        return self._part(Webhooks)

    @cached_property
    def quotas(self) -> Quotas:
        """The tenant's quota."""
        return self._part(Quotas)

    @cached_property
    def spectra(self) -> Spectra:
        """The cached spectra, common to all tenants."""
        return self._part(Spectra)

    @cached_property
    def counters(self) -> Counters:
        """The counters of all tenants."""
        return Counters(self.client)

    @cached_property
    def api_keys(self) -> ApiKeys:
        """The API keys of all tenants."""
        return ApiKeys(self.client)

    def of(self, tenant: str) -> Self:
        """Return the store of a tenant, over the same connections."""
        keys = Keys(tenant)
        return self if keys == self.keys else replace(self, keys=keys)

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
        """Check that Redis and the blob store answer and accept writes, and keep them.

        Raises
        ------
        RedisError
            Redis does not answer, is full, or is a replica.
        EvictsRecords
            Redis deletes records when it is full.
        BlobError
            The blob store does not answer, is full, or is that of another Redis.
        """
        self.client.set(Keys.READY, b"", ex=60)
        check_eviction(self.client)
        self.blobs.check()

    def close(self) -> None:
        """Close the connections."""
        self.cache.close()
        self.client.close()
