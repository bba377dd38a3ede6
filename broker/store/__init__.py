"""What the service remembers, in Redis and nowhere else: shapes, prototypes, jobs, spectra."""

from dataclasses import dataclass
from typing import Self

from redis import Redis

from broker.store import keys
from broker.store.absence import Absence
from broker.store.connections import (
    CACHE_LULL,
    CACHE_PATIENCE,
    CACHE_SILENCE,
    OnceInAWhile,
    StoreSettings,
    connect,
)
from broker.store.jobs import LISTED_KINDS, Jobs
from broker.store.listings import InvalidCursor, Listing, Page
from broker.store.orders import KeyReused, Orders, TooManyQueued
from broker.store.parts import Offer, Parts, StageCounts, Taken
from broker.store.prototypes import Prototypes
from broker.store.records import NewerRecord
from broker.store.replies import text
from broker.store.shapes import Shapes
from broker.store.spectra import Spectra, SpectrumCounts
from broker.store.tallies import BOUNDS, Counts, Tallies, Times
from broker.store.uploads import Uploads
from broker.store.webhooks import Webhooks

__all__ = [
    "BOUNDS",
    "CACHE_SILENCE",
    "LISTED_KINDS",
    "Absence",
    "Counts",
    "InvalidCursor",
    "Jobs",
    "KeyReused",
    "Listing",
    "NewerRecord",
    "Offer",
    "OnceInAWhile",
    "Orders",
    "Page",
    "Parts",
    "Prototypes",
    "Shapes",
    "Spectra",
    "SpectrumCounts",
    "StageCounts",
    "Store",
    "StoreSettings",
    "Taken",
    "Tallies",
    "Times",
    "TooManyQueued",
    "Uploads",
    "Webhooks",
    "connect",
    "text",
]


@dataclass(frozen=True)
class Store:
    """All that is kept in Redis.

    Parameters
    ----------
    client
        Connection to the Redis of queue and store.
    shapes, prototypes, jobs, orders, parts, spectra, tallies, webhooks
        What is kept there, by subject.
    """

    client: Redis
    shapes: Shapes
    prototypes: Prototypes
    jobs: Jobs
    orders: Orders
    parts: Parts
    spectra: Spectra
    tallies: Tallies
    webhooks: Webhooks

    @classmethod
    def open(
        cls,
        settings: StoreSettings,
        patience: float,
        pause: float = 1.0,
        silence: float | None = None,
    ) -> Self:
        """Connect to the store.

        Parameters
        ----------
        settings
            Where it is; `redis_url` must be set.
        patience, pause
            Seconds for which a command is repeated while Redis is away, and between two attempts.
        silence
            Seconds after which one without an answer has failed; None to repeat it, too.

        Raises
        ------
        ValueError
            No address is set.
        """
        if settings.redis_url is None:
            raise ValueError("ISOMATCH_REDIS_URL is not set")
        client = connect(settings.redis_url, patience, pause, silence)
        return cls.over(client, settings, patience, pause, silence)

    @classmethod
    def over(
        cls,
        client: Redis,
        settings: StoreSettings,
        patience: float,
        pause: float = 1.0,
        silence: float | None = None,
    ) -> Self:
        """Return the store over a connection that there is already; otherwise as :meth:`open`."""
        cache = client
        if settings.cache_url is not None:
            # Nothing is lost with it: rather compute again than wait.
            patience = min(patience, CACHE_PATIENCE)
            cache = connect(settings.cache_url, patience, pause, CACHE_SILENCE, CACHE_LULL)
        return cls(
            client,
            Shapes(client, settings),
            Prototypes(client, settings),
            Jobs(client, settings),
            Orders(client),
            Parts(client, settings),
            Spectra(cache, client, settings),
            Tallies(client),
            Webhooks(client),
        )

    def check(self) -> None:
        """Write something, to see whether the store is there and takes it.

        Raises
        ------
        RedisError
            It is not, or it does not (it is full, or a replica).
        """
        self.client.set(keys.READY, b"", ex=60)

    def close(self) -> None:
        """Close the connections."""
        self.spectra.cache.close()
        self.client.close()
