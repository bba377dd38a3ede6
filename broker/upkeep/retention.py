"""Retention: keys expire by themselves; here listings and cache follow."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

from broker.contracts import JobState, is_prototype
from broker.store import Keys, Listing, Store


def evict_deleted(store: Store, ids: Sequence[str]) -> None:
    """Drop cached blobs of shapes and prototypes that no tenant has (any more).

    A job may have used one while it was deleted, and another tenant may have the same.

    Parameters
    ----------
    store
        The store of the tenant that deleted them, maybe while a job used them.
    ids
        Ids of the shapes and prototypes.
    """
    left = _not_in([store.keys], ids, store)
    store.spectra.forget(left)
    if left:
        left = _not_in([Keys(tenant) for tenant in store.tenants()], left, store)
    for one in left:
        store.spectra.drop(one)


def _not_in(tenants: Sequence[Keys], ids: Sequence[str], store: Store) -> list[str]:
    """Return the shapes and prototypes that none of these tenants has."""
    with store.client.pipeline(transaction=False) as pipe:
        for one in ids:
            record = Keys.prototype if is_prototype(one) else Keys.shape
            pipe.exists(*(record(keys, one) for keys in tenants))
        found = pipe.execute()
    return [one for one, exists in zip(ids, found, strict=True) if not exists]


@dataclass
class Sweep:
    """Removal of expired entries from the listings of all tenants, a part at a time.

    Parameters
    ----------
    store
        The store.
    """

    store: Store
    _cursors: dict[str, int] = field(default_factory=dict)

    def step(self) -> None:
        """Sweep the next part of each listing."""
        for tenant in self.store.tenants():
            keys = Keys(tenant)
            jobs = [keys.jobs, *(keys.jobs_in(state) for state in JobState)]
            records: dict[str, Callable[[str], str]] = dict.fromkeys(jobs, keys.job)
            records |= {keys.shapes: keys.shape, keys.prototypes: keys.prototype}
            records[keys.held] = str
            for key, record in records.items():
                listing = Listing(self.store.client, key, record)
                self._cursors[key] = listing.sweep(self._cursors.get(key, 0))
