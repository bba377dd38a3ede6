"""Failures of the blob store.

::

    BlobError
    ├── BlobsAway      it does not answer, or refuses access
    ├── BlobsFull      it has no space left
    ├── BlobLost       it does not have the bytes that a record names, or they are damaged
    └── NotMigrated    the bytes are still in Redis, where versions before 0.2 kept them
"""

import errno
from typing import TypeGuard


class BlobError(Exception):
    """Root of the failures of the blob store; the message is for the operator."""


class BlobsAway(BlobError):
    """The blob store does not answer, or refuses access."""


class BlobsFull(BlobError):
    """The blob store has no space left."""


class BlobLost(BlobError):
    """The bytes that a record names are missing or damaged.

    Parameters
    ----------
    path
        Path of the blob.
    reason
        What is wrong with it: "missing", or what differs.
    """

    def __init__(self, path: str, reason: str) -> None:
        super().__init__(f"blob {path} is {reason}")
        self.reason = reason


class NotMigrated(BlobError):
    """The bytes are still in Redis; ``python -m broker.migrate`` moves them.

    Parameters
    ----------
    key
        Key of the bytes in Redis.
    """

    def __init__(self, key: str) -> None:
        super().__init__(
            f"{key} was stored by an earlier version, in Redis; `python -m broker.migrate` moves"
            " such data to the blob store"
        )


def no_space_left(error: object) -> TypeGuard[OSError]:
    """Return whether an error says that a file system is full, or a quota of it used up."""
    return isinstance(error, OSError) and error.errno in (errno.ENOSPC, errno.EDQUOT)
