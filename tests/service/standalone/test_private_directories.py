"""Other users of the machine read nothing that the service keeps."""

import os
from collections.abc import Iterator
from pathlib import Path

import pytest

from service.standalone import EmbeddedServer
from service.standalone.private_directories import close_to_others


@pytest.fixture(autouse=True)
def _usual_umask() -> Iterator[None]:
    before = os.umask(0o022)
    yield
    os.umask(before)


def mode(path: Path) -> int:
    return path.stat().st_mode & 0o777


def test_a_directory_of_an_earlier_version_is_closed(tmp_path: Path) -> None:
    (tmp_path / "blobs").mkdir()
    assert mode(tmp_path / "blobs") == 0o755
    close_to_others(tmp_path / "blobs")
    assert mode(tmp_path / "blobs") == 0o700
    # One that is lost must not look like one that is empty.
    close_to_others(tmp_path / "lost")
    assert not (tmp_path / "lost").exists()


def test_the_data_of_the_private_server_are(tmp_path: Path) -> None:
    server = EmbeddedServer(tmp_path / "redis")
    server.start()
    try:
        assert mode(tmp_path / "redis") == 0o700
    finally:
        server.stop()
