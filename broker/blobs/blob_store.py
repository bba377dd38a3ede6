"""What a blob store does, whatever keeps its bytes."""

from collections.abc import Iterator
from dataclasses import dataclass
from datetime import datetime
from typing import BinaryIO, Final, Protocol
from uuid import uuid4

PROBE: Final = "probe"
"""Folder of blobs that check whether any can be stored."""


@dataclass(frozen=True)
class BlobEntry:
    """A blob in a listing.

    Parameters
    ----------
    path
        Its path.
    size
        Number of bytes.
    modified
        When it was written, by the clock of the store.
    """

    path: str
    size: int
    modified: datetime


class BlobStore(Protocol):
    """Bytes under paths; each is written once, whole or not at all.

    A path consists of a folder and a name, ``FOLDER/NAME``. Every method may raise
    :class:`~broker.blobs.BlobsAway`.
    """

    def put(self, path: str, data: bytes | BinaryIO) -> None:
        """Store bytes, or a file, of which a few pieces at a time are in memory.

        They are on the disk, or with the server, when this returns.

        Raises
        ------
        BlobsFull
            There is no space left.
        """

    def read(self, path: str) -> bytes:
        """Return the bytes of a blob.

        Raises
        ------
        BlobLost
            There is no such blob.
        """

    def open(self, path: str) -> BinaryIO:
        """Return the bytes of a blob as a file, which stays readable if the blob is deleted.

        Raises
        ------
        BlobLost
            There is no such blob.
        BlobsFull
            There is no space for a temporary file.
        """

    def size(self, path: str) -> int:
        """Return the number of bytes of a blob.

        Raises
        ------
        BlobLost
            There is no such blob.
        """

    def delete(self, path: str) -> None:
        """Delete a blob, if there is one."""

    def list(self, folder: str) -> Iterator[BlobEntry]:
        """Iterate over the blobs of a folder, in any order."""

    def check(self) -> None:
        """Check that blobs can be stored.

        Raises
        ------
        BlobsFull
            There is no space left.
        """


def store_and_delete(blobs: BlobStore) -> None:
    """Check a blob store by a blob that is stored and deleted.

    Parameters
    ----------
    blobs
        The blob store.

    Raises
    ------
    BlobsAway, BlobsFull
        It cannot be used.
    """
    path = f"{PROBE}/{uuid4().hex}"
    blobs.put(path, b"probe")
    blobs.delete(path)
