"""Blob stores of tests: directories, also on a disk that is soon full."""

import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest


def blob_url(folder: Path) -> str:
    """Address of the blob store in a folder of a test."""
    return (folder / "blobs").as_uri()


@pytest.fixture
def small_disk(tmp_path: Path) -> Iterator[Path]:
    """A file system of 3 MiB, which takes root on Linux."""
    folder = tmp_path / "small"
    folder.mkdir()
    command = ["mount", "-t", "tmpfs", "-o", "size=3m", "tmpfs", str(folder)]
    if sys.platform != "linux" or subprocess.run(command, check=False).returncode:
        pytest.skip("no file system can be mounted here")
    yield folder
    subprocess.run(["umount", "--lazy", str(folder)], check=True)
