"""Meshes and results outlive killed processes, and a backup of a running service is whole."""

import subprocess
import sys
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import httpx2
import pytest
from redis import Redis

from bench.machines import Cluster, running_cluster
from tests.requests import ask
from tests.worker.figures import blob_file

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="reads /proc")

QUICK: dict[str, Any] = {"points": 6, "eigenpairs": 30, "orientation": False}
KILLS = 4


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("cluster")


@pytest.fixture(scope="module")
def cluster(folder: Path) -> Iterator[Cluster]:
    with running_cluster(folder, workers=1) as cluster:
        yield cluster


class Uploads:
    """Uploads one after the other in a thread, whatever becomes of the service."""

    def __init__(self, cluster: Cluster, first: int) -> None:
        self._cluster, self._seed = cluster, first
        self._done = threading.Event()
        self._thread = threading.Thread(target=self._send)
        self.accepted = 0

    def __enter__(self) -> "Uploads":
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._done.set()
        self._thread.join()

    def _send(self) -> None:
        address = str(self._cluster.http.base_url)
        with httpx2.Client(base_url=address, timeout=300.0) as http:
            while not self._done.is_set():
                self._seed += 1
                data = blob_file(2, seed=self._seed)
                try:
                    answer = http.post("/v1/shapes", files={"file": ("a.off", data)})
                except httpx2.TransportError:
                    self._done.wait(0.05)
                    continue
                self.accepted += answer.status_code == 201


def whole(cluster: Cluster) -> int:
    """Assert that everything that is listed can be read, and return the number of shapes."""
    shapes = cluster.http.get("/v1/shapes", params={"limit": 200}).json()["items"]
    for shape in shapes:
        mesh = cluster.http.get(f"/v1/shapes/{shape['id']}/mesh")
        assert mesh.status_code == 200, mesh.text
        assert len(mesh.content) == shape["bytes"]
        assert cluster.http.get(f"/v1/shapes/{shape['id']}/geometry").status_code == 200
    for job in cluster.http.get("/v1/jobs", params={"state": "succeeded"}).json()["items"]:
        for name in ("result", "result.npz"):
            assert cluster.http.get(f"/v1/jobs/{job['id']}/{name}").status_code == 200
    return len(shapes)


def test_no_record_is_without_its_bytes_after_kills(cluster: Cluster) -> None:
    with Uploads(cluster, 1000) as uploads:
        for kill in range(KILLS):
            seen = uploads.accepted
            cluster.until(lambda seen=seen: uploads.accepted >= seen + 2, 120)
            if kill % 2:
                cluster.kill_api()
                cluster.api = cluster.start_api()
            else:
                cluster.restart_store()
    assert whole(cluster) >= 2 * KILLS


def test_a_backup_of_a_running_service_is_restored(
    cluster: Cluster, folder: Path, tmp_path: Path
) -> None:
    """The commands of docs/operations.md, while uploads come in: Redis first, then the blobs."""
    shape = cluster.upload(blob_file(4))
    before = cluster.ended(ask(cluster.http, shape, **QUICK))
    assert before["state"] == "succeeded"
    result = cluster.http.get(before["links"]["result"]).json()
    with Uploads(cluster, 2000) as uploads, Redis.from_url(cluster.store.url) as client:
        cluster.until(lambda: uploads.accepted >= 1, 120)
        client.config_set("auto-aof-rewrite-percentage", 0)
        copied(folder / "redis", tmp_path / "redis", "appendonlydir")
        cluster.until(lambda: uploads.accepted >= 3, 120)
        copied(folder / "blobs", tmp_path / "blobs", ".")
        client.config_set("auto-aof-rewrite-percentage", 100)
    with running_cluster(tmp_path, workers=1) as restored:
        assert restored.http.get("/health/ready").status_code == 200
        assert 1 <= whole(restored) <= whole(cluster)
        assert restored.http.get(before["links"]["result"]).json() == result
        # What was restored can be used.
        assert restored.ended(ask(restored.http, shape, points=7))["state"] == "succeeded"


def copied(source: Path, target: Path, what: str) -> None:
    target.mkdir()
    archive = target.with_suffix(".tar")
    made = subprocess.run(["tar", "-C", str(source), "-cf", str(archive), what], check=False)
    assert made.returncode in (0, 1), "1: a file was written meanwhile"
    subprocess.run(["tar", "-C", str(target), "-xf", str(archive)], check=True)
