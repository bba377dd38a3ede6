"""What is kept no longer goes by itself, for its keys expire; here the listings follow."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

from broker.contracts import JobState, is_prototype
from broker.store import Listing, Store, keys


def forget_deleted(store: Store, named: Sequence[str]) -> None:
    """Take out of the cache what a job has put there of what was deleted meanwhile.

    Parameters
    ----------
    store
        Where it is.
    named
        Ids of the shapes and the prototype that the job was of.
    """
    with store.client.pipeline(transaction=False) as pipe:
        for one in named:
            pipe.exists(keys.prototype(one) if is_prototype(one) else keys.shape(one))
        there = pipe.execute()
    for one, exists in zip(named, there, strict=True):
        if not exists:
            store.spectra.forget(one)


@dataclass
class Sweep:
    """Goes round the listings, a part at a time, and takes out what has expired.

    Parameters
    ----------
    store
        Where they are.
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
