"""Object storage whose server dies, comes back, or is overloaded for a while."""

import socket
import tempfile
import threading
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path
from uuid import uuid4

import pytest

from broker.blobs import BlobLost, BlobsAway, BlobsFull
from broker.blobs.object_storage import ObjectStorage
from tests.object_storage import (
    ACCESS,
    READER,
    ObjectServer,
    environment,
    free_ports,
    object_storage,
)

OVERLOADED = "503 Slow Down"
FULL = "507 Insufficient Storage"


def test_a_server_that_comes_back_is_waited_for(object_server: ObjectServer) -> None:
    folder = uuid4().hex
    object_storage(object_server, 20.0, folder).put("ab/1", b"before")
    object_server.kill()
    brief = object_storage(object_server, 0.2, folder)
    for use in (brief.check, lambda: brief.open("ab/1"), lambda: brief.put("ab/2", b"lost")):
        with pytest.raises(BlobsAway, match="cannot be used"):
            use()
    patient = object_storage(object_server, 60.0, folder)
    with ThreadPoolExecutor(1) as thread:
        waiting = thread.submit(patient.put, "ab/3", b"after")
        time.sleep(1.0)
        assert not waiting.done()
        # The server dies with the thread that starts it: not with the other one.
        object_server.start()
        waiting.result()
    for path, data in (("ab/1", b"before"), ("ab/3", b"after")):
        with patient.open(path) as file:
            assert file.read() == data
    assert {entry.path for entry in patient.list("ab")} >= {"ab/1", "ab/3"}


@contextmanager
def in_front_of(server: ObjectServer, refusal: str, times: int) -> Iterator[str]:
    """A gateway that refuses so many requests, and hands the further ones to the server."""
    left = [times]

    def forward(source: socket.socket, target: socket.socket) -> None:
        while data := source.recv(65536):
            target.sendall(data)
        target.shutdown(socket.SHUT_WR)

    def answer(client: socket.socket) -> None:
        with client:
            if left[0] > 0:
                left[0] -= 1
                client.recv(65536)
                client.sendall(
                    f"HTTP/1.1 {refusal}\r\nContent-Length: 0\r\nConnection: close\r\n\r\n".encode()
                )
                return
            with socket.create_connection(("127.0.0.1", server.port)) as behind:
                back = threading.Thread(target=forward, args=(behind, client), daemon=True)
                back.start()
                forward(client, behind)
                back.join()

    def serve(listening: socket.socket) -> None:
        while True:
            try:
                client, _ = listening.accept()
            except OSError:
                return
            threading.Thread(target=answer, args=(client,), daemon=True).start()

    with socket.create_server(("127.0.0.1", 0)) as listening:
        threading.Thread(target=serve, args=(listening,), daemon=True).start()
        yield f"http://127.0.0.1:{listening.getsockname()[1]}"
        listening.shutdown(socket.SHUT_RDWR)


def behind(endpoint: str, patience: float) -> ObjectStorage:
    with environment({**ACCESS, "AWS_ENDPOINT_URL": endpoint}):
        return ObjectStorage(f"s3://isomatch/{uuid4().hex}", patience)


def test_an_overloaded_server_is_asked_again(object_server: ObjectServer) -> None:
    with in_front_of(object_server, OVERLOADED, times=4) as endpoint:
        blobs = behind(endpoint, 60.0)
        blobs.put("ab/1", b"content")
        with blobs.open("ab/1") as file:
            assert file.read() == b"content"


def test_a_server_that_stays_overloaded_is_away(object_server: ObjectServer) -> None:
    with in_front_of(object_server, OVERLOADED, times=10**6) as endpoint:
        blobs = behind(endpoint, 0.5)
        for use in (blobs.check, lambda: blobs.put("ab/1", b"x"), lambda: blobs.open("ab/1")):
            with pytest.raises(BlobsAway, match="503"):
                use()


def test_a_full_server_is_full(object_server: ObjectServer) -> None:
    with (
        in_front_of(object_server, FULL, times=10**6) as endpoint,
        pytest.raises(BlobsFull),
    ):
        behind(endpoint, 0.5).put("ab/1", b"x")


def test_a_full_disk_of_temporary_files_is_full(
    object_server: ObjectServer, small_disk: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    blobs = object_storage(object_server, 20.0, uuid4().hex)
    blobs.put("ab/1", bytes(4 * 1024**2))
    monkeypatch.setattr(tempfile, "tempdir", str(small_disk))
    with pytest.raises(BlobsFull, match="temporary files"):
        blobs.open("ab/1")


def test_a_check_notices_that_nothing_can_be_stored(object_server: ObjectServer) -> None:
    with environment({**object_server.environment, **READER}):
        reader = ObjectStorage("s3://isomatch", 0.0)
        assert reader.read("first/object") == b""
        with pytest.raises(BlobsAway, match="403"):
            reader.check()


def test_refused_credentials_and_missing_buckets_are_not_lost_blobs(
    object_server: ObjectServer,
) -> None:
    with (
        environment({**object_server.environment, "AWS_SECRET_ACCESS_KEY": "another"}),
        pytest.raises(BlobsAway),
    ):
        ObjectStorage("s3://isomatch", 0.0).open("ab/1")
    with environment(object_server.environment):
        elsewhere = ObjectStorage("s3://nowhere", 0.0)
        with pytest.raises(BlobsAway, match="bucket"):
            elsewhere.open("ab/1")
        with pytest.raises(BlobsAway):
            elsewhere.check()
        with pytest.raises(BlobLost):
            ObjectStorage("s3://isomatch", 0.0).open("ab/1")
    (nobody,) = free_ports(1)
    with pytest.raises(BlobsAway):
        behind(f"http://127.0.0.1:{nobody}", 0.0).put("ab/507", b"x")
