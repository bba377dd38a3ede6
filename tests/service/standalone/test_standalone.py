"""The whole service as a process: starting, stopping, being killed, and starting again."""

import asyncio
import json
import os
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from queue import SimpleQueue
from threading import Thread
from typing import Any

import httpx2
import pytest

from service.standalone import listening
from tests.processes import alive
from tests.stack import PATIENT
from tests.waiting import until
from tests.worker.figures import blob_file

ROOT = Path(__file__).resolve().parents[3]

linux = pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="reads /proc")


class Running:
    """A service in a process of its own, with everything it says."""

    def __init__(self, data: Path, log: Path, **settings: str) -> None:
        environment = {k: v for k, v in os.environ.items() if not k.startswith("ISOMATCH_")}
        environment |= {"ISOMATCH_DATA_DIR": str(data), "ISOMATCH_WORKERS": "1", **settings}
        self.log = log
        with log.open("ab") as stderr:
            self.process = subprocess.Popen(
                [sys.executable, "-m", "service", "--port", "0"],
                cwd=ROOT,
                env=environment,
                stdout=subprocess.PIPE,
                stderr=stderr,
                text=True,
            )
        self.said: SimpleQueue[str] = SimpleQueue()
        Thread(target=self._listen, daemon=True).start()
        line = self.said.get(timeout=540)
        assert line.startswith("isomatch listens on http://127.0.0.1:"), log.read_text()
        self.http = httpx2.Client(base_url=line.split()[-1], timeout=300.0)

    def _listen(self) -> None:
        assert self.process.stdout is not None
        with self.process.stdout as stdout:
            for line in stdout:
                self.said.put(line.strip())
        self.said.put("")

    def family(self) -> set[int]:
        """Ids of all processes that descend from this one."""
        found: set[int] = set()
        generation = {self.process.pid}
        while generation:
            generation = {child for pid in generation for child in children(pid)} - found
            found |= generation
        return found

    def workers(self) -> set[int]:
        """Ids of its workers."""
        return {child for pid in self.forking() for child in children(pid)}

    def forking(self) -> set[int]:
        """Id of the process that forks them."""
        return {pid for pid in children(self.process.pid) if "worker" in command(pid)}

    def end(self, number: signal.Signals = signal.SIGTERM) -> float:
        """Stop the service; how many seconds that took."""
        start = time.monotonic()
        self.process.send_signal(number)
        self.process.wait(120)
        return time.monotonic() - start


def children(pid: int) -> set[int]:
    """Ids of the processes that one has started; none if it has ended."""
    with suppress(OSError):
        return {
            int(child) for child in Path(f"/proc/{pid}/task/{pid}/children").read_text().split()
        }
    return set()


def command(pid: int) -> list[str]:
    """What a process was started as."""
    return Path(f"/proc/{pid}/cmdline").read_text().split("\0")


@contextmanager
def service(data: Path, log: Path, **settings: str) -> Iterator[Running]:
    running = Running(data, log, **settings)
    try:
        yield running
    finally:
        if running.process.poll() is None:
            running.end()
        running.http.close()


LONG = {"points": 256, "coarse_points": 10, "alternatives": 32}


def begun(running: Running) -> str:
    """Begin a match that lasts much longer than a worker is given to end it, and return its path.

    Of 41,000 vertices with themselves: half a minute where 2,600 take three seconds, which a worker
    that stops may have left.
    """
    answer = running.http.post("/v1/shapes", files={"file": ("a.off", blob_file(6))})
    shape = answer.json()["id"]
    body = {"source": shape, "target": shape, **LONG}
    path: str = running.http.post("/v1/matches", json=body).headers["location"]

    def has_begun() -> bool:
        job: dict[str, Any] = running.http.get(path).json()
        assert job["state"] in ("queued", "running"), job
        return bool(job["state"] == "running" and job["progress"]["fraction"] >= 0.1)

    until(has_begun)
    return path


@linux
def test_the_service_starts_serves_and_stops(tmp_path: Path) -> None:
    data = tmp_path / ("a-long-name-" * 10)
    with service(data, tmp_path / "log") as running:
        ready = running.http.get("/health/ready")
        assert ready.json() == {"status": "ok", "workers": 1}
        family = running.family()
        # The store, and a worker with the process that forked it.
        assert len(family) == 3
        second = subprocess.run(
            [sys.executable, "-m", "service", "--port", "0"],
            cwd=ROOT,
            env={**os.environ, "ISOMATCH_DATA_DIR": str(data)},
            capture_output=True,
            text=True,
            check=False,
            timeout=240,
        )
        assert second.returncode == 1
        assert "in use by another isomatch" in second.stderr
        assert str(running.process.pid) in second.stderr
        assert second.stdout == ""
        assert running.end(signal.SIGINT) < 25.0
        assert running.process.returncode == 0
        # One line, and then nothing more.
        assert running.said.get(timeout=120) == ""
        until(lambda: not alive(family), 120.0)
    for line in (tmp_path / "log").read_text().splitlines():
        assert json.loads(line)["event"]


@linux
def test_stopped_or_killed_in_the_middle_of_a_job_it_goes_on_after_the_next_start(
    tmp_path: Path,
) -> None:
    with service(tmp_path / "data", tmp_path / "log", **PATIENT) as running:
        path = begun(running)
        family = running.family()
        # The same, and the process of the job.
        assert len(family) == 4
        events: list[str] = []

        def follow() -> None:
            with running.http.stream("GET", f"{path}/events") as stream:
                events.extend(stream.iter_lines())

        waiting = [
            Thread(target=lambda: running.http.get(path, params={"wait": 60})),
            Thread(target=follow),
        ]
        for thread in waiting:
            thread.start()
        # Both, and who asks.
        until(lambda: "requests_open 3.0" in running.http.get("/metrics").text and events != [])
        assert running.end() < 25.0
        assert running.process.returncode == 0
        until(lambda: not alive(family), 120.0)
        for thread in waiting:
            thread.join(60.0)
            assert not thread.is_alive()
        # It was told how the job was, and was not broken off in the middle of an event.
        assert events[0] == "event: job"
        assert events[-1] == ""
    with service(tmp_path / "data", tmp_path / "log") as running:
        until(lambda: running.http.get(path).json()["state"] == "running")
        until(lambda: len(running.family()) == 4)
        family = running.family()
        running.end(signal.SIGKILL)
        until(lambda: not alive(family), 120.0)
    with service(tmp_path / "data", tmp_path / "log") as running:
        (worker,) = running.workers()
        # It may still be said to run where it did before.
        until(lambda: children(worker) != set())
        (horse,) = children(worker)
        assert running.http.get(path).json()["state"] in ("queued", "running")
        assert running.http.delete(path).json()["state"] in ("queued", "running", "cancelled")
        # It leaves by itself, or has no time to.
        with suppress(ProcessLookupError):
            os.kill(horse, signal.SIGKILL)
        assert running.http.get(path, params={"wait": 60}).json()["state"] == "cancelled"


@linux
def test_an_upload_in_transit_is_told_when_the_service_stops(tmp_path: Path) -> None:
    settings = {"ISOMATCH_WORKERS": "0", "ISOMATCH_DRAIN_SECONDS": "1"}
    with service(tmp_path / "data", tmp_path / "log", **settings) as running:
        url = running.http.base_url
        with socket.create_connection((url.host, url.port or 80), timeout=60) as upload:
            upload.sendall(
                b"POST /v1/shapes HTTP/1.1\r\nHost: localhost\r\nContent-Length: 9999\r\n"
                b"Content-Type: multipart/form-data; boundary=x\r\n\r\n--x\r\n"
            )
            until(lambda: "requests_open 2.0" in running.http.get("/metrics").text)
            running.process.terminate()
            answer = b"".join(iter(lambda: upload.recv(65536), b""))
    head, _, document = answer.partition(b"\r\n\r\n")
    assert head.startswith(b"HTTP/1.1 503 ")
    assert b"retry-after: 5" in head.lower()
    assert json.loads(document)["type"] == "urn:isomatch:problem:not-ready"


def test_workers_and_a_store_that_die_are_replaced(tmp_path: Path) -> None:
    # A process that forks workers takes as long to start as the first did.
    settings = {**PATIENT, "ISOMATCH_REDIS_PATIENCE": "60"}
    with service(tmp_path / "data", tmp_path / "log", **settings) as running:
        (worker,), (forking,) = running.workers(), running.forking()
        (store,) = running.family() - {worker, forking}
        os.kill(worker, signal.SIGKILL)
        until(lambda: len(running.workers() - {worker}) == 1)
        assert running.forking() == {forking}
        family = running.family() - {store}
        os.kill(forking, signal.SIGKILL)
        until(lambda: not alive(family), 120.0)
        data = blob_file(2)
        answer = running.http.post("/v1/shapes", files={"file": ("a.off", data)})
        assert answer.status_code == 201
        os.kill(store, signal.SIGKILL)
        assert running.http.get(answer.headers["location"]).json() == answer.json()
        answer = running.http.post("/v1/shapes", files={"file": ("a.off", blob_file(1))})
        assert answer.status_code == 201


def test_answers_are_sent_at_once() -> None:
    async def without_delay() -> int:
        accepted = asyncio.get_running_loop().create_future()

        async def accept(_: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
            accepted.set_result(writer)

        with listening("127.0.0.1", 0) as listener:
            async with await asyncio.start_server(accept, sock=listener):
                _, caller = await asyncio.open_connection(*listener.getsockname())
                writer = await accepted
                immediate: int = writer.get_extra_info("socket").getsockopt(
                    socket.IPPROTO_TCP, socket.TCP_NODELAY
                )
                for end in (caller, writer):
                    end.close()
                    await end.wait_closed()
                return immediate

    assert asyncio.run(without_delay())


def test_a_port_that_is_taken(tmp_path: Path) -> None:
    with listening("127.0.0.1", 0) as taken:
        taken.listen()
        port = str(taken.getsockname()[1])
        second = subprocess.run(
            [sys.executable, "-m", "service", "--port", port],
            cwd=ROOT,
            env={**os.environ, "ISOMATCH_DATA_DIR": str(tmp_path / "other")},
            capture_output=True,
            text=True,
            check=False,
            timeout=240,
        )
    assert second.returncode == 1
    assert f"port {port}" in second.stderr
