"""What every blob store does: bytes go in and come out, whole or not at all."""

import io
from collections.abc import Iterator
from pathlib import Path
from random import Random
from uuid import uuid4

import pytest

from broker.blobs import BlobLost, BlobsAway, BlobStore, open_blobs
from broker.blobs.directory import DirectoryBlobs
from broker.blobs.left_to_sweep import LeftToSweep
from tests.object_storage import ObjectServer, environment, object_storage

SIZES = (0, 1, 5 * 1024**2, 9 * 1024**2 + 1)
"""None, some, one request and several, in memory and in a file."""


@pytest.fixture(params=["directory", "object storage"])
def blobs(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[BlobStore]:
    """An empty blob store."""
    if request.param == "directory":
        yield DirectoryBlobs(tmp_path / "blobs")
        return
    server: ObjectServer = request.getfixturevalue("object_server")
    yield object_storage(server, 20.0, uuid4().hex)


class InPieces(io.BytesIO):
    """A file of which some bytes are read at a time, never all."""

    def read(self, size: int | None = -1, /) -> bytes:
        """Return some bytes."""
        assert size is not None
        assert 0 <= size <= 5 * 1024**2
        return super().read(size)


def content(blobs: BlobStore, path: str) -> bytes:
    with blobs.open(path) as file:
        return file.read()


@pytest.mark.parametrize("size", SIZES)
def test_bytes_come_back(blobs: BlobStore, size: int) -> None:
    data = Random(size).randbytes(size)
    blobs.put("ab/job!1-x!mesh!0", data)
    assert content(blobs, "ab/job!1-x!mesh!0") == data
    assert blobs.read("ab/job!1-x!mesh!0") == data
    assert blobs.size("ab/job!1-x!mesh!0") == size
    (entry,) = blobs.list("ab")
    assert (entry.path, entry.size) == ("ab/job!1-x!mesh!0", size)


@pytest.mark.parametrize("size", SIZES)
def test_files_are_stored_in_pieces(blobs: BlobStore, size: int) -> None:
    data = Random(size).randbytes(size)
    blobs.put("ab/1", InPieces(data))
    assert content(blobs, "ab/1") == data


def test_a_folder_lists_its_own(blobs: BlobStore) -> None:
    blobs.put("owner/id", b"x")
    assert list(blobs.list("ab")) == []
    for path in ("ab/1", "ab/2", "abc/3", "b/4"):
        blobs.put(path, b"x")
    assert {entry.path for entry in blobs.list("ab")} == {"ab/1", "ab/2"}


def test_what_is_deleted_is_lost(blobs: BlobStore) -> None:
    blobs.put("ab/1", b"x")
    blobs.put("ab/2", b"y")
    blobs.delete("ab/1")
    blobs.delete("ab/1")
    for use in (blobs.open, blobs.read, blobs.size):
        with pytest.raises(BlobLost):
            use("ab/1")
    assert content(blobs, "ab/2") == b"y"


def test_an_open_file_outlives_its_blob(blobs: BlobStore) -> None:
    blobs.put("ab/1", b"content")
    with blobs.open("ab/1") as file:
        blobs.delete("ab/1")
        assert file.read() == b"content"


def test_a_check_leaves_nothing(blobs: BlobStore) -> None:
    blobs.check()
    assert list(blobs.list("probe")) == []


def test_addresses(tmp_path: Path, object_server: ObjectServer) -> None:
    here = open_blobs((tmp_path / "with space").as_uri(), 0.0)
    here.put("ab/1", b"x")
    assert (tmp_path / "with space" / "ab" / "1").read_bytes() == b"x"
    with environment(object_server.environment):
        there = open_blobs(f"s3://isomatch/{uuid4().hex}", 20.0)
        there.put("ab/1", b"y")
        assert content(there, "ab/1") == b"y"
        forking = open_blobs("s3://isomatch/elsewhere", 20.0, forks=True)
    # Its threads would be missing in what the process forks.
    assert isinstance(forking, LeftToSweep)
    forking.delete("ab/1")
    with pytest.raises(BlobsAway):
        forking.open("ab/1")
