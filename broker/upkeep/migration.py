"""Migration of the layout before 0.2, which kept all bytes in Redis, to the blob store.

What is migrated is a string under the key of a reference, and becomes a reference, with the same
time to live. Keys that are references already are left alone, so that a migration that was
interrupted is simply repeated. It may run beside API and workers of this version; those of earlier
versions must be stopped.
"""

import re
from dataclasses import dataclass
from typing import Final

from redis.exceptions import WatchError

from broker.store import PREFIX, Store, text
from broker.telemetry import logger

_BYTES: Final = re.compile(
    re.escape(PREFIX)
    + r"(shape:[^:]+:(upload|mesh|geometry)"
    + r"|prototype:[^:]+:(archive|geometry)"
    + r"|attributes:[^:]+:file"
    + r"|candidate:[^:]+:[^:]+:(?!job$)[^:]+"
    + r"|job:[^:]+:(result|arrays)"
    + r"|job:[^:]+:picture(:[^:]+)*(?<!:job))"
)
"""Keys under which the earlier layout had bytes; ``:job`` names the job that makes them."""

_SCANNED: Final = 1000
"""Keys that are looked at in one command, as a hint to Redis."""

log = logger("isomatch.migration")


@dataclass(frozen=True)
class Migrated:
    """Number of values that were moved to the blob store, and their size in bytes."""

    values: int
    bytes: int


def migrate(store: Store) -> Migrated:
    """Move all bytes that earlier versions kept in Redis to the blob store.

    Raises
    ------
    BlobError
        The blob store cannot be used; what was moved stays moved.
    RedisError
        Redis does not answer.
    """
    store.blobs.check()
    values = size = 0
    for name in store.client.scan_iter(f"{PREFIX}*", count=_SCANNED, _type="string"):
        key = text(name)
        if _BYTES.fullmatch(key) is None:
            continue
        moved = _move(store, key)
        if moved is not None:
            values, size = values + 1, size + moved
            if values % _SCANNED == 0:
                log.info("migrating", values=values, bytes=size)
    return Migrated(values, size)


def _move(store: Store, key: str) -> int | None:
    """Replace bytes by a reference; return their size, None if they have expired."""
    with store.client.pipeline() as pipe:
        while True:
            pipe.watch(key)
            if text(store.client.type(key)) != "string":
                return None
            data, left = store.client.get(key), store.client.pttl(key)
            if not isinstance(data, bytes):
                return None
            reference = store.blobs.put(key, data)
            pipe.multi()
            store.blobs.link(key, reference, pipe)
            if left >= 0:
                pipe.pexpire(key, left)
            try:
                pipe.execute()
            except WatchError:
                store.blobs.discard([(key, reference)])
                continue
            return len(data)
