"""Retention: keys expire by themselves; here listings and cache follow."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

from broker.contracts import JobState, is_prototype
from broker.store import Listing, Store, keys


def evict_deleted(store: Store, ids: Sequence[str]) -> None:
    """Drop cached blobs of shapes and prototypes that were deleted while a job used them.

    Parameters
    ----------
    store
        The store.
    ids
        Ids of the job's shapes and prototype.
    """
    with store.client.pipeline(transaction=False) as pipe:
        for one in ids:
            pipe.exists(keys.prototype(one) if is_prototype(one) else keys.shape(one))
        found = pipe.execute()
    for one, exists in zip(ids, found, strict=True):
        if not exists:
            store.spectra.drop(one)


@dataclass
class Sweep:
    """Removal of expired entries from the listings, a part at a time.

    Parameters
    ----------
    store
        The store.
    """

    store: Store
    _cursors: dict[str, int] = field(default_factory=dict)

    def step(self) -> None:
        """Sweep the next part of each listing."""
        jobs = [keys.JOBS, *(keys.jobs_in(state) for state in JobState)]
        records: dict[str, Callable[[str], str]] = dict.fromkeys(jobs, keys.job)
        records |= {keys.SHAPES: keys.shape, keys.PROTOTYPES: keys.prototype}
        for key, record in records.items():
            listing = Listing(self.store.client, key, record)
            self._cursors[key] = listing.sweep(self._cursors.get(key, 0))
