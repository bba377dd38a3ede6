"""Blobs in a directory: of this machine, or of a file system that all machines share.

A file is written beside its place, flushed to the disk and renamed, so that a blob is there whole
or not at all, also after a power failure. Written in Python's own ``os``, because the library of
:mod:`broker.blobs.object_storage` neither flushes files nor survives a fork.
"""

import contextlib
import errno
import os
import shutil
from collections.abc import Iterator
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import BinaryIO, Final

from broker.blobs.blob_store import BlobEntry, store_and_delete
from broker.blobs.errors import BlobLost, BlobsAway, BlobsFull, no_space_left

_UNFINISHED: Final = ".part"
"""Suffix of files that are being written."""


@dataclass(frozen=True)
class DirectoryBlobs:
    """Blobs as files of a directory, which is made, for its owner alone, when first written to.

    Parameters
    ----------
    root
        The directory.
    """

    root: Path

    def put(self, path: str, data: bytes | BinaryIO) -> None:
        """Write a file, flush it to the disk, and give it its name."""
        target = self.root / path
        unfinished = target.with_name(f"{target.name}{_UNFINISHED}")
        with _reported():
            try:
                self._make(target.parent)
                with unfinished.open("wb") as file:
                    if isinstance(data, bytes):
                        file.write(data)
                    else:
                        shutil.copyfileobj(data, file)
                    file.flush()
                    os.fsync(file.fileno())
                unfinished.replace(target)
                _flush_directory(target.parent)
            except BaseException:
                with contextlib.suppress(OSError):
                    unfinished.unlink(missing_ok=True)
                raise

    def read(self, path: str) -> bytes:
        """Read a file."""
        with self.open(path) as file, _reported():
            return file.read()

    def open(self, path: str) -> BinaryIO:
        """Open a file."""
        with _reported():
            try:
                return (self.root / path).open("rb")
            except FileNotFoundError as error:
                self._check_present()
                raise BlobLost(path, "missing") from error

    def size(self, path: str) -> int:
        """Ask for the size of a file."""
        with self.open(path) as file, _reported():
            return os.fstat(file.fileno()).st_size

    def delete(self, path: str) -> None:
        """Delete a file."""
        with _reported():
            (self.root / path).unlink(missing_ok=True)

    def list(self, folder: str) -> Iterator[BlobEntry]:
        """Iterate over the files of a folder, unfinished ones of killed processes too."""
        with _reported():
            try:
                entries = os.scandir(self.root / folder)
            except FileNotFoundError:
                return
            with entries:
                for entry in entries:
                    try:
                        found = entry.stat(follow_symlinks=False)
                    except FileNotFoundError:
                        continue  # deleted meanwhile
                    modified = datetime.fromtimestamp(found.st_mtime, UTC)
                    yield BlobEntry(f"{folder}/{entry.name}", found.st_size, modified)

    def check(self) -> None:
        """Write a file and delete it."""
        store_and_delete(self)

    def _make(self, folder: Path) -> None:
        if not folder.is_dir():
            # Other users of the machine are none of the tenants.
            self.root.mkdir(mode=0o700, parents=True, exist_ok=True)
            folder.mkdir(parents=True, exist_ok=True)
            _flush_directory(folder.parent)

    def _check_present(self) -> None:
        """Tell a directory that is not mounted from one that lacks a file."""
        if not self.root.is_dir():
            raise BlobsAway(f"there is no directory {self.root}")


def _flush_directory(folder: Path) -> None:
    # A new name is on the disk only when its directory is.
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    except OSError as error:
        if error.errno != errno.EINVAL:  # some network file systems flush no directories
            raise
    finally:
        os.close(descriptor)


@contextlib.contextmanager
def _reported() -> Iterator[None]:
    try:
        yield
    except OSError as error:
        reason = f"the blob directory cannot be used: {error}"
        raise (BlobsFull if no_space_left(error) else BlobsAway)(reason) from error
