"""Blobs in a directory that is full, not mounted, or whose writer was killed."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from broker.blobs import BlobLost, BlobsAway, BlobsFull
from broker.blobs.directory import DirectoryBlobs

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="uses /dev/full")


def test_a_full_disk_is_told(tmp_path: Path) -> None:
    blobs = DirectoryBlobs(tmp_path)
    (tmp_path / "ab").mkdir()
    unfinished = tmp_path / "ab" / "1.part"
    unfinished.symlink_to("/dev/full")
    with pytest.raises(BlobsFull):
        blobs.put("ab/1", b"content")
    with pytest.raises(BlobLost):
        blobs.open("ab/1")
    assert list(blobs.list("ab")) == []
    blobs.put("ab/1", b"content")


def test_a_directory_that_is_gone_is_away(tmp_path: Path) -> None:
    blobs = DirectoryBlobs(tmp_path / "blobs")
    with pytest.raises(BlobsAway):
        blobs.open("ab/1")
    blobs.put("ab/1", b"content")
    (tmp_path / "blobs").rename(tmp_path / "elsewhere")
    with pytest.raises(BlobsAway):
        blobs.open("ab/1")
    (tmp_path / "blobs").write_text("a file")
    for use in (blobs.check, lambda: blobs.put("ab/1", b"x"), lambda: blobs.delete("ab/1")):
        with pytest.raises(BlobsAway):
            use()


def test_a_killed_writer_leaves_no_part_of_a_blob(tmp_path: Path) -> None:
    """Each blob is there whole or not at all, wherever its writer is killed."""
    program = """
import os, sys
from pathlib import Path
from broker.blobs.directory import DirectoryBlobs
blobs = DirectoryBlobs(Path(sys.argv[1]))
print("ready", flush=True)
number = 0
while True:
    blobs.put(f"ab/{number}", bytes([number % 256]) * 300_000)
    number += 1
"""
    for _ in range(5):
        process = subprocess.Popen(
            [sys.executable, "-c", program, str(tmp_path)], stdout=subprocess.PIPE
        )
        assert process.stdout is not None
        process.stdout.readline()
        while not (tmp_path / "ab" / "2").exists():
            assert process.poll() is None
        os.kill(process.pid, signal.SIGKILL)
        process.wait()
        process.stdout.close()
        for entry in DirectoryBlobs(tmp_path).list("ab"):
            if entry.path.endswith(".part"):
                continue
            data = (tmp_path / entry.path).read_bytes()
            assert data == bytes([int(Path(entry.path).name) % 256]) * 300_000
            (tmp_path / entry.path).unlink()


def test_a_new_directory_is_closed_to_other_users(tmp_path: Path) -> None:
    before = os.umask(0o022)
    try:
        DirectoryBlobs(tmp_path / "data" / "blobs").put("ab/1", b"content")
        (tmp_path / "open").mkdir()
        DirectoryBlobs(tmp_path / "open").put("ab/1", b"content")
    finally:
        os.umask(before)
    assert (tmp_path / "data" / "blobs").stat().st_mode & 0o777 == 0o700
    # The operator's own mode is kept.
    assert (tmp_path / "open").stat().st_mode & 0o777 == 0o755
