"""Retention: keys expire by themselves; here listings and cache follow."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final

from broker.contracts import JobState, is_prototype
from broker.store import Keys, Listing, Store, sweep, text

_LISTINGS: Final = 1000
"""Listings that are swept at a time, at most; few of them have many entries."""


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


@dataclass(frozen=True)
class Sweep:
    """Removal of expired entries from the listings, one after the other, by all API processes.

    Parameters
    ----------
    store
        The store.
    """

    store: Store

    def step(self) -> None:
        """Sweep the next entries of the listings, which are of one or more of them."""
        client = self.store.client
        place, start = map(int, text(client.get(Keys.LISTING_SWEEP) or b"0 0").split())
        keys = [Keys(tenant) for tenant in self.store.tenants()]
        every = [Listing(client, *one) for own in keys for one in _listings(own).items()]
        place %= len(every)
        done, start = sweep(client, every[place : place + _LISTINGS], start)
        client.set(Keys.LISTING_SWEEP, f"{place + done} {start}")


def _listings(keys: Keys) -> dict[str, Callable[[str], str]]:
    """Return the listings of a tenant, and what returns the key of an entry's record."""
    jobs = [keys.jobs, *(keys.jobs_in(state) for state in JobState)]
    return {
        **dict.fromkeys(jobs, keys.job),
        keys.shapes: keys.shape,
        keys.prototypes: keys.prototype,
        keys.held: str,
    }
