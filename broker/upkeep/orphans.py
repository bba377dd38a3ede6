"""Deletion of orphans: blobs that no reference names.

References expire in Redis, and a process may be killed between a blob and its reference. The
folders of the blob store are looked at one after the other, by all API processes together.
"""

import time
from dataclasses import dataclass
from itertools import islice
from typing import Final

from broker.store import FOLDERS, Keys, Store
from broker.telemetry import logger

SAFE_AGE: Final = 3600.0
"""Seconds from which on a blob without a reference is an orphan.

A blob is written before its reference, which follows within seconds; a transaction that is sent
again while Redis restarts, within ``redis_patience`` or ``worker_patience``. The clocks of this
machine and of the blob store may differ by some minutes.
"""

MOST_DELETED: Final = 1000
"""Blobs that one step deletes at most."""

_BATCH: Final = 500
"""Blobs whose references are looked up at a time."""

_SWEPT: Final = (*FOLDERS, "probe")
"""Folders that are swept; files of checks that were killed are in the last."""

log = logger("isomatch.upkeep")


@dataclass(frozen=True)
class OrphanSweep:
    """The deletion of orphans, a folder at a time.

    Parameters
    ----------
    store
        The store.
    safe_age
        Seconds from which on a blob without a reference is deleted.
    """

    store: Store
    safe_age: float = SAFE_AGE

    def step(self) -> int:
        """Delete the orphans of the next folder, and return their number.

        Raises
        ------
        BlobsAway
            The blob store cannot be reached, or is that of another Redis, whose blobs stay.
        """
        blobs = self.store.blobs
        blobs.check_owner()
        folder = _SWEPT[int(self.store.client.incr(Keys.BLOB_SWEEP)) % len(_SWEPT)]
        latest = time.time() - self.safe_age
        deleted = 0
        old = (one for one in blobs.store.list(folder) if one.modified.timestamp() <= latest)
        while entries := list(islice(old, _BATCH)):
            for orphan in blobs.orphans(entries):
                blobs.store.delete(orphan.path)
                deleted += 1
                if deleted >= MOST_DELETED:
                    return deleted
        if deleted:
            log.info("orphaned blobs deleted", folder=folder, count=deleted)
        return deleted
