"""Blobs in S3-compatible object storage.

Credentials, region and endpoint are those of other S3 programs: ``AWS_ACCESS_KEY_ID``,
``AWS_SECRET_ACCESS_KEY``, ``AWS_REGION``, ``AWS_ENDPOINT_URL``.

The library runs threads of its own, which a fork does not copy: a process that has used it must not
fork (see :mod:`broker.blobs.left_to_sweep`).
"""

import os
import re
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from datetime import timedelta
from tempfile import SpooledTemporaryFile
from typing import BinaryIO, Final, TypeVar, cast
from urllib.parse import urlsplit

import obstore
from obstore.exceptions import BaseError
from obstore.store import S3Store

from broker.blobs.blob_store import PROBE, BlobEntry, store_and_delete
from broker.blobs.errors import BlobLost, BlobsAway, BlobsFull, no_space_left

_IN_MEMORY: Final = 1024**2
"""Bytes of a blob up to which it is read into memory; a larger one goes into a temporary file."""

_REQUEST_SECONDS: Final = 60.0
"""Seconds that one request may take; a large blob is sent in parts."""

_PARTS_AT_ONCE: Final = 4
"""Parts of a large object that are sent at a time; each has 5 MiB, and is in memory."""

_CONNECT_SECONDS: Final = 5.0
_LONGEST_PAUSE: Final = 2.0
"""Longest pause between two attempts, in seconds: servers restart within some."""

_MANY_ATTEMPTS: Final = 1000
"""The time limits the attempts, not their number."""

_FULL: Final = re.compile(
    r"status code: 507\b"
    r"|<Code>(StorageFull|QuotaExceeded|InsufficientStorage|EntityTooLarge)</Code>"
)
"""What a server without space answers. Any digits may be in its address and in a path."""

ResultT = TypeVar("ResultT")


class ObjectStorage:
    """Blobs as objects of a bucket.

    Parameters
    ----------
    url
        ``s3://BUCKET`` or ``s3://BUCKET/PREFIX``.
    patience
        Seconds for which a request is repeated while the server does not answer, or answers with
        an error of its own (5xx).
    """

    def __init__(self, url: str, patience: float) -> None:
        parts = urlsplit(url)
        self._address = url
        self._store = S3Store(
            parts.netloc,
            prefix=parts.path.strip("/") or None,
            client_options={
                "allow_http": os.environ.get("AWS_ENDPOINT_URL", "").startswith("http://"),
                "timeout": timedelta(seconds=_REQUEST_SECONDS),
                "connect_timeout": timedelta(seconds=_CONNECT_SECONDS),
            },
            retry_config={
                "max_retries": _MANY_ATTEMPTS if patience else 0,
                "retry_timeout": timedelta(seconds=patience),
                "backoff": {"max_backoff": timedelta(seconds=_LONGEST_PAUSE)},
            },
        )

    def put(self, path: str, data: bytes | BinaryIO) -> None:
        """Store an object; a large one in parts."""
        self._asked(
            path, lambda: obstore.put(self._store, path, data, max_concurrency=_PARTS_AT_ONCE)
        )

    def read(self, path: str) -> bytes:
        """Fetch an object into memory."""
        return self._asked(path, lambda: bytes(obstore.get(self._store, path).bytes()))

    def open(self, path: str) -> BinaryIO:
        """Fetch an object, through a temporary file where it is large."""

        def fetch() -> BinaryIO:
            found = obstore.get(self._store, path)
            with ExitStack() as closing:
                file = closing.enter_context(SpooledTemporaryFile(max_size=_IN_MEMORY))
                for piece in found.stream():
                    file.write(piece)
                file.seek(0)
                closing.pop_all()  # the caller closes it
            return cast(BinaryIO, file)

        return self._asked(path, fetch)

    def size(self, path: str) -> int:
        """Ask for the size of an object."""
        return self._asked(path, lambda: obstore.head(self._store, path)["size"])

    def delete(self, path: str) -> None:
        """Delete an object."""
        try:
            self._asked(path, lambda: obstore.delete(self._store, path))
        except BlobLost:
            return

    def list(self, folder: str) -> Iterator[BlobEntry]:
        """Iterate over the objects of a folder, which the server lists a thousand at a time."""
        listing = obstore.list(self._store, f"{folder}/", chunk_size=1000)
        while True:
            found = self._asked(folder, lambda: next(listing, None))
            if found is None:
                return
            for one in found:
                yield BlobEntry(one["path"], one["size"], one["last_modified"])

    def check(self) -> None:
        """Store an object and delete it."""
        # Some servers make a bucket that is missing, such as a misspelt one, when it is stored to.
        next(self.list(PROBE), None)
        store_and_delete(self)

    def _asked(self, path: str, ask: Callable[[], ResultT]) -> ResultT:
        try:
            return ask()
        except FileNotFoundError as error:
            if "NoSuchBucket" in str(error):
                raise BlobsAway(f"there is no bucket at {self._address}") from error
            raise BlobLost(path, "missing") from error
        except (BaseError, OSError, ValueError) as error:
            if no_space_left(error):
                raise BlobsFull(f"the folder of temporary files is full: {error}") from error
            reason = f"the object storage at {self._address} cannot be used: {_first_line(error)}"
            raise (BlobsFull if _FULL.search(str(error)) else BlobsAway)(reason) from error


def _first_line(error: Exception) -> str:
    return str(error).partition("\n")[0]
