"""Jobs that were accepted outlive a Redis that is killed at any moment; workers come back."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import httpx2
import pytest

from bench.kept import killed_while_accepting
from demo.stack import LISTENS, ROOT
from service.standalone import EmbeddedServer
from tests.blobs import blob_url
from tests.waiting import until
from tests.worker.figures import blob_file

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="reads /proc")


@pytest.mark.parametrize("appendfsync", ["always", "everysec"])
def test_no_accepted_job_is_lost_by_kills(tmp_path: Path, appendfsync: str) -> None:
    accepted, lost = killed_while_accepting(tmp_path, 5, appendfsync)
    assert accepted >= 5
    assert lost == []


def test_workers_that_left_while_the_store_was_away_come_back(tmp_path: Path) -> None:
    """One that starts meanwhile leaves after ``ISOMATCH_WORKER_PATIENCE``; others are started."""
    server = EmbeddedServer(tmp_path / "redis")
    server.start()
    settings = {
        "ISOMATCH_REDIS_URL": server.url,
        "ISOMATCH_BLOB_URL": blob_url(tmp_path),
        "ISOMATCH_REDIS_PATIENCE": "1",
        "ISOMATCH_WORKER_PATIENCE": "1",
        "ISOMATCH_VALIDATION_WAIT": "240",
        "ISOMATCH_WORKERS": "1",
    }
    with (tmp_path / "log").open("w") as log:
        process = subprocess.Popen(
            [sys.executable, "-m", "service", "--port", "0"],
            cwd=ROOT,
            env={**os.environ, **settings},
            stdout=subprocess.PIPE,
            stderr=log,
            text=True,
        )
    try:
        assert process.stdout is not None
        listens = LISTENS.search(process.stdout.readline())
        assert listens is not None
        (forking,) = children(process.pid)
        (worker,) = children(forking)
        server.stop()
        os.kill(worker, signal.SIGKILL)
        # The one that replaces it leaves, and with it the process that forked it.
        until(lambda: bool(children(process.pid) - {forking}))
        server.start()
        with httpx2.Client(base_url=listens.group(1), timeout=300.0) as http:
            until(lambda: http.get("/health/ready").status_code == 200)
            answer = http.post("/v1/shapes", files={"file": ("a.off", blob_file(2))})
            assert answer.status_code == 201, answer.text
    finally:
        process.send_signal(signal.SIGTERM)
        process.wait()
        if process.stdout is not None:
            process.stdout.close()
        server.stop()


def children(pid: int) -> set[int]:
    found = Path(f"/proc/{pid}/task/{pid}/children").read_text().split()
    return {int(child) for child in found}
