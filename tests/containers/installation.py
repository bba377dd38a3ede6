"""The service as compose runs it, and what an operator does to it."""

import json
import time
from pathlib import Path

import httpx2

from tests.containers.engine import Engine
from tests.containers.manifests import COMPOSE, DOCKER, Json
from tests.requests import job_of, until_begun
from tests.waiting import until

PASSWORD = "a-password-of-the-checks"
PROJECT = "checks"
PORT = 18000

SETTINGS = {
    "ISOMATCH_REDIS_PASSWORD": PASSWORD,
    "ISOMATCH_LISTEN": f"127.0.0.1:{PORT}",
    "ISOMATCH_HEARTBEAT": "1",
    "ISOMATCH_PRIVATE_ADDRESS": "127.0.0.1",
}


class Installation:
    """A running installation.

    Parameters
    ----------
    engine
        What runs it.
    """

    def __init__(self, engine: Engine) -> None:
        self.engine = engine
        self.http = httpx2.Client(base_url=f"http://127.0.0.1:{PORT}", timeout=90.0)

    def compose(self, *arguments: str, seconds: float = 300, remote: bool = False) -> str:
        """Run compose on the file of the repository."""
        command = [*self.engine.composer(), "--project-name", PROJECT, "--file", str(COMPOSE)]
        if remote:
            command += ["--file", str(DOCKER / "compose.remote.yaml")]
        return self.engine.run([*command, *arguments], seconds, SETTINGS)

    def shell(self, statement: str, folder: Path) -> None:
        """Run a statement of the operations guide in a folder, against this installation."""
        ours = " ".join([*self.engine.composer(), "--project-name", PROJECT, "-f", str(COMPOSE)])
        command = statement.replace("docker compose -f docker/compose.yaml", ours)
        self.engine.run(["sh", "-c", f"cd '{folder}' && {command}"], 300, SETTINGS)

    def up(self, remote: bool = False) -> None:
        """Start what does not run, and wait until it is ready."""
        self.compose("up", "--detach", "--no-build", remote=remote)
        until(lambda: self.ready() == 2, 120, pause=0.1)

    def ready(self) -> int:
        """Return the number of workers that are ready."""
        try:
            workers: int = self.http.get("/health/ready").json().get("workers", 0)
        except httpx2.HTTPError:
            return 0
        return workers

    def containers(self, service: str) -> list[str]:
        """Ids of the running containers of a service."""
        labels = {"project": PROJECT, "service": service}
        chosen = [f"label=com.docker.compose.{name}={value}" for name, value in labels.items()]
        filters = [part for each in chosen for part in ("--filter", each)]
        return self.engine.docker("ps", "--quiet", *filters).split()

    def inspect(self, container: str) -> Json:
        """What the engine knows of a container."""
        found: Json = json.loads(self.engine.docker("inspect", container))[0]
        return found

    def healthy(self, container: str) -> bool:
        """Whether the health check of a container succeeds."""
        status: str = self.inspect(container)["State"]["Health"]["Status"]
        return status == "healthy"

    def began(self, job: str) -> list[str]:
        """Ids of the running workers that have begun a job."""
        return [each for each in self.containers("worker") if ("begun", job) in self.said(each)]

    def said(self, container: str) -> list[tuple[str, str]]:
        """What a worker has logged: events, and the jobs they are about."""
        lines = self.engine.docker("logs", container).splitlines()
        entries = [json.loads(line) for line in lines if line.startswith("{")]
        return [(entry.get("event", ""), entry.get("job_id", "")) for entry in entries]

    def result(self, job: str, seconds: float = 120) -> Json:
        """Wait for the end of a job, and return its result."""
        deadline = time.monotonic() + seconds
        while (record := job_of(self.http, job, wait=10))["state"] in ("queued", "running"):
            assert time.monotonic() < deadline, record
        assert record["state"] == "succeeded", record
        result: Json = self.http.get(record["links"]["result"]).json()
        return result

    def until_begun(self, job: str) -> str:
        """Wait until a job is in the middle of its matching, and return its worker's container."""
        until_begun(self.http, job)
        (container,) = self.began(job)
        return container

    def spectra_computed(self) -> float:
        """How many spectra were not in the cache, by the metrics."""
        for line in self.http.get("/metrics").text.splitlines():
            if line.startswith('isomatch_spectra_total{cache="miss"}'):
                return float(line.split()[-1])
        return 0.0
