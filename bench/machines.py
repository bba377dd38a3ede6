"""The service as on several machines: store, API and workers, each a process to be killed."""

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import httpx2
from redis import Redis
from rq import Worker

from demo.stack import LISTENS, ROOT
from service.standalone import EmbeddedServer, listening

SETTINGS = {
    "ISOMATCH_HEARTBEAT": "2",
    "ISOMATCH_JOB_MEMORY_MB": "450",
    "ISOMATCH_VALIDATION_WAIT": "240",
}
"""A quick heart, so that what is lost is found soon, a limit that a bomb runs into, and uploads
that are answered when they are read, however busy the machine."""


class Cluster:
    """A running cluster.

    Parameters
    ----------
    folder
        Where the store and the logs are.
    root
        Where the code of what is started is; it may be changed, to that of another version.
    workers
        Number of workers.
    """

    def __init__(self, folder: Path, root: Path = ROOT, workers: int = 2) -> None:
        self._folder = folder
        self.root = root
        self.blobs = (folder / "blobs").as_uri()
        self._environment = {
            name: value for name, value in os.environ.items() if not name.startswith("ISOMATCH_")
        }
        self.store = EmbeddedServer(folder / "redis")
        self.store.start()
        with listening("127.0.0.1", 0) as free:
            self._port = str(free.getsockname()[1])
        self.api = self.start_api()
        self.workers = [self.start_worker() for _ in range(workers)]
        self.http = httpx2.Client(base_url=f"http://127.0.0.1:{self._port}", timeout=300.0)

    def start_api(self, port: str | None = None, **settings: str) -> subprocess.Popen[str]:
        """Start an API on the same port, and wait until it listens."""
        command = ["service", "--port", port or self._port]
        settings |= {"ISOMATCH_WORKERS": "0"}
        process = self._start(command, settings, "api.log", subprocess.PIPE)
        assert process.stdout is not None
        line = process.stdout.readline()
        listens = LISTENS.search(line)
        assert listens, line
        self.listens = listens.group(1)
        return process

    def ready(self) -> int:
        """Return the number of workers."""
        workers: int = self.http.get("/health/ready").json().get("workers", 0)
        return workers

    def start_worker(self) -> subprocess.Popen[str]:
        """Start a worker."""
        return self._start(["worker", "--parent", str(os.getpid())], {}, "worker.log", None)

    def restart_store(self) -> None:
        """Kill the store, and start it again with its data."""
        assert self.store.pid is not None
        os.kill(self.store.pid, signal.SIGKILL)
        self.until(lambda: not self.store.alive(), 60)
        self.store.start()

    def horses_of(self, job: str) -> list[tuple[subprocess.Popen[str], int]]:
        """Return the workers that run a job, each with the process it forked for it."""
        return [
            (worker, int(horse))
            for worker in self.workers_of(job)
            for horse in Path(f"/proc/{worker.pid}/task/{worker.pid}/children").read_text().split()
        ]

    def workers_of(self, job: str) -> list[subprocess.Popen[str]]:
        """Return the live workers that are registered as running a job."""
        with Redis.from_url(self.store.url) as client:
            busy = {it.pid for it in Worker.all(client) if it.get_current_job_id() == job}
        return [worker for worker in self.workers if worker.pid in busy and worker.poll() is None]

    def kill_api(self) -> None:
        """Kill the API."""
        end(self.api)

    def upload(self, data: bytes, http: httpx2.Client | None = None) -> str:
        """Upload a mesh and return its id."""
        answer = (http or self.http).post("/v1/shapes", files={"file": ("a.off", data)})
        assert answer.status_code in (200, 201), answer.text
        shape: str = answer.json()["id"]
        return shape

    def job(self, job: str, wait: float = 0.0) -> dict[str, Any]:
        """Return a job, after it has ended or some seconds."""
        answer = self.http.get(f"/v1/jobs/{job}", params={"wait": wait})
        assert answer.status_code == 200, answer.text
        record: dict[str, Any] = answer.json()
        return record

    def ended(self, job: str) -> dict[str, Any]:
        """Return a job when it has ended."""
        deadline = time.monotonic() + 300
        while (record := self.job(job, wait=60))["state"] in ("queued", "running"):
            assert time.monotonic() < deadline, record
        return record

    def until(self, true: Any, seconds: float) -> None:
        """Wait until a condition holds."""
        deadline = time.monotonic() + seconds
        while not true():
            assert time.monotonic() < deadline, "it took too long"
            time.sleep(0.02)

    def stop(self) -> None:
        """End everything."""
        self.http.close()
        for process in (self.api, *self.workers):
            end(process)
        self.store.stop()

    def _start(
        self, command: list[str], settings: dict[str, str], log: str, stdout: int | None
    ) -> subprocess.Popen[str]:
        stores = {
            "ISOMATCH_REDIS_URL": self.store.url,
            "ISOMATCH_BLOB_URL": self.blobs,
        }
        environment = {**stores, **SETTINGS, **settings}
        with (self._folder / log).open("a") as stderr:
            return subprocess.Popen(
                [sys.executable, "-m", *command],
                cwd=self.root,
                env={**self._environment, **environment},
                stdin=subprocess.DEVNULL,
                stdout=stdout,
                stderr=stderr,
                text=True,
            )


def end(process: subprocess.Popen[str]) -> None:
    """Kill a process."""
    process.kill()
    process.wait()
    if process.stdout is not None:
        process.stdout.close()


@contextmanager
def running_cluster(folder: Path, root: Path = ROOT, workers: int = 2) -> Iterator[Cluster]:
    """Run a cluster for as long as a block of code lasts."""
    cluster = Cluster(folder, root, workers)
    try:
        cluster.until(lambda: cluster.ready() == workers, 540)
        yield cluster
    finally:
        cluster.stop()
