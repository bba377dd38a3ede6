"""The blob store of a process that forks others, and so must not use object storage itself."""

from collections.abc import Iterator
from typing import BinaryIO

from broker.blobs.blob_store import BlobEntry
from broker.blobs.errors import BlobsAway


class LeftToSweep:
    """Leaves blobs that are to be deleted to the sweep of orphans; does nothing else.

    The main process of a worker deletes records of lost jobs, and forks a process for each job. A
    fork has none of the threads that the library of object storage runs.
    """

    def put(self, path: str, data: bytes | BinaryIO) -> None:
        """Refuse."""
        raise BlobsAway("this process stores no blobs: it forks others that do")

    def read(self, path: str) -> bytes:
        """Refuse."""
        raise BlobsAway("this process reads no blobs: it forks others that do")

    def open(self, path: str) -> BinaryIO:
        """Refuse."""
        raise BlobsAway("this process reads no blobs: it forks others that do")

    def size(self, path: str) -> int:
        """Refuse."""
        raise BlobsAway("this process reads no blobs: it forks others that do")

    def delete(self, path: str) -> None:
        """Leave the blob to the sweep."""

    def list(self, folder: str) -> Iterator[BlobEntry]:
        """Return nothing."""
        return iter(())

    def check(self) -> None:
        """Check nothing."""
