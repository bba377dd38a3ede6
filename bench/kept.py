"""Accepted jobs that a killed Redis loses, and the cost of losing none: ``python -m bench.kept``.

An API without workers accepts matches from several clients at a time while its Redis is killed
(SIGKILL) and started again, at random moments. Every job whose request was answered with 202 must
be known afterwards. Then the time of a request is measured, with a Redis that writes its file to
the disk before it answers (``appendfsync always``) and with one that does so every second.
"""

import os
import random
import signal
import statistics
import tempfile
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from uuid import uuid4

import httpx2
from redis import Redis

from bench.command_line import command_line, parsed, print_json
from broker.contracts import ShapeRecord
from broker.store import DEFAULT_KEYS, connect
from demo.stack import running_stack
from service.standalone import EmbeddedServer

CLIENTS = 4
"""Clients that send requests at the same time."""

_SHAPE = "a" * 32


@dataclass
class Accepting:
    """Clients that send requests one after the other.

    Parameters
    ----------
    url
        Address of the API.

    Attributes
    ----------
    accepted
        Ids of the jobs whose requests were answered with 202.
    """

    url: str
    accepted: list[str] = field(default_factory=list)
    _stop: threading.Event = field(default_factory=threading.Event)

    def send(self) -> None:
        """Send requests until told to stop; what is not answered is sent again."""
        with httpx2.Client(base_url=self.url, timeout=60.0) as http:
            while not self._stop.is_set():
                body = {"source": _SHAPE, "target": _SHAPE, "points": 8}
                headers = {"Idempotency-Key": uuid4().hex}
                answer = http.post("/v1/matches", json=body, headers=headers)
                while answer.status_code == 503 and not self._stop.is_set():
                    answer = http.post("/v1/matches", json=body, headers=headers)
                if answer.status_code == 202:
                    self.accepted.append(answer.json()["id"])

    @contextmanager
    def running(self, clients: int) -> Iterator[None]:
        """Send requests for as long as a block of code lasts."""
        threads = [threading.Thread(target=self.send) for _ in range(clients)]
        for thread in threads:
            thread.start()
        try:
            yield
        finally:
            self._stop.set()
            for thread in threads:
                thread.join()


@contextmanager
def api(folder: Path, server: EmbeddedServer) -> Iterator[str]:
    """Run an API without workers."""
    with connect(server.url, retry_seconds=10) as client:
        shape = ShapeRecord.model_construct(
            id=_SHAPE, name="x", file_type="off", bytes=1, vertices=30, faces=56, area=1.0,
            components=1, closed=True, has_colors=False, warnings=(), created=datetime.now(UTC),
        )  # fmt: skip
        client.set(DEFAULT_KEYS.shape(_SHAPE), shape.model_dump_json(warnings=False))
    settings = {
        "ISOMATCH_REDIS_URL": server.url,
        "ISOMATCH_BLOB_URL": (folder / "blobs").as_uri(),
        "ISOMATCH_WORKERS": "0",
        "ISOMATCH_MAX_QUEUED_JOBS": "0",
        "ISOMATCH_LOG_LEVEL": "CRITICAL",
    }
    with running_stack(settings) as stack:
        yield stack.url


def killed_while_accepting(
    folder: Path, kills: int, appendfsync: str = "always"
) -> tuple[int, list[str]]:
    """Kill Redis so many times; return the number of jobs accepted, and those that were lost."""
    server, moments = EmbeddedServer(folder / "redis"), random.Random(0)
    server.start()
    try:
        with api(folder, server) as url:
            clients = Accepting(url)
            with clients.running(CLIENTS):
                for _ in range(kills):
                    with Redis.from_url(server.url) as client:
                        client.config_set("appendfsync", appendfsync)
                    seen = len(clients.accepted)
                    while len(clients.accepted) <= seen:
                        time.sleep(0.005)
                    time.sleep(moments.uniform(0.0, 0.2))
                    assert server.pid is not None
                    os.kill(server.pid, signal.SIGKILL)
                    while server.alive():
                        time.sleep(0.001)
                    server.start()
            with connect(server.url, retry_seconds=10) as client:
                lost = [job for job in clients.accepted if not client.exists(DEFAULT_KEYS.job(job))]
            return len(clients.accepted), lost
    finally:
        server.stop()


def milliseconds(folder: Path, appendfsync: str, requests: int) -> float:
    """Return the median time of a request for a job, one at a time."""
    server = EmbeddedServer(folder / "redis")
    server.start()
    try:
        with api(folder, server) as url, httpx2.Client(base_url=url, timeout=60.0) as http:
            with Redis.from_url(server.url) as client:
                client.config_set("appendfsync", appendfsync)
            taken = []
            for _ in range(requests):
                start = time.perf_counter()
                body = {"source": _SHAPE, "target": _SHAPE, "points": 8}
                assert http.post("/v1/matches", json=body).status_code == 202
                taken.append(time.perf_counter() - start)
            return 1000 * statistics.median(taken)
    finally:
        server.stop()


def main() -> None:
    """Measure, print the table."""
    parser = command_line(__doc__)
    parser.add_argument("--kills", type=int, default=200, help="times that Redis is killed")
    parser.add_argument("--requests", type=int, default=200, help="requests that are timed")
    arguments = parsed(parser)
    figures: dict[str, float] = {}
    for policy in ("always", "everysec"):
        with tempfile.TemporaryDirectory(prefix="isomatch-") as folder:
            accepted, lost = killed_while_accepting(Path(folder), arguments.kills, policy)
        print(f"{policy:10}{arguments.kills} kills: {accepted} jobs accepted, {len(lost)} lost")
        with tempfile.TemporaryDirectory(prefix="isomatch-") as folder:
            median = milliseconds(Path(folder), policy, arguments.requests)
        print(f"{'':10}a request takes {median:.1f} ms")
        figures |= {
            f"{policy}_accepted": accepted,
            f"{policy}_lost": len(lost),
            f"{policy}_milliseconds": median,
        }
    print_json(arguments, figures)


if __name__ == "__main__":
    main()
