"""What all parts of a tenant's store share: connections, settings, and the tenant's keys."""

from dataclasses import dataclass
from typing import TypeVar

from redis import Redis

from broker.store.blobs import Blobs
from broker.store.connections import StoreSettings
from broker.store.durability import Durability
from broker.store.keys import Keys

PartT = TypeVar("PartT", bound="TenantData")


@dataclass(frozen=True)
class TenantData:
    """Data that are kept of a tenant.

    Parameters
    ----------
    client
        Connection to the Redis of queue and store.
    cache
        Connection to the Redis of the cached spectra, which may be the same.
    blobs
        The large bytes, in the blob store.
    settings
        Times to live, limits, and the quota of tenants that have none of their own.
    keys
        The tenant's keys.
    durability
        Waiting until what was written is on the disk.
    """

    client: Redis
    cache: Redis
    blobs: Blobs
    settings: StoreSettings
    keys: Keys
    durability: Durability

    def _part(self, kind: type[PartT]) -> PartT:
        """Return other data of the same tenant, over the same connections."""
        shared = self.client, self.cache, self.blobs, self.settings, self.keys, self.durability
        return kind(*shared)
