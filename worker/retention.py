"""What is kept no longer goes by itself, for its keys expire; here the listings follow."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

from worker.contracts import JobState
from worker.store import Store, keys
from worker.store.listings import Listing


def forget_deleted(store: Store, shapes: Sequence[str]) -> None:
    """Take out of the cache what a job has put there of shapes that were deleted meanwhile.

    Parameters
    ----------
    store
        Where they are.
    shapes
        What the job was of.
    """
    with store.client.pipeline(transaction=False) as pipe:
        for shape in shapes:
            pipe.exists(keys.shape(shape))
        there = pipe.execute()
    for shape, exists in zip(shapes, there, strict=True):
        if not exists:
            store.spectra.forget(shape)


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
