"""Cost of requests that wait for jobs: ``python -m bench.waiting``.

Clients follow jobs of their own by long polls or by event streams, half of them queued and half
running, of which nothing is done. Then one more client asks for a job again and again. Printed are
the processor time of the API, in cores; Redis's commands and reads, a second; and the median time
of such a request.
"""

import asyncio
import os
import tempfile
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from statistics import median
from typing import Final

import httpx2
import numpy as np

from bench.command_line import command_line, parsed, print_json
from broker.contracts import DissimilaritiesPayload, DissimilarityParameters
from broker.queue import JobQueue
from broker.store import Store
from broker.telemetry import configure_logging
from demo.stack import running_stack
from service.settings import Settings
from service.standalone import EmbeddedServer

KINDS: Final = {"long polls": "?wait=60", "event streams": "/events"}
SETTLING: Final = 2.0
"""Seconds between the last request and the measurement."""


@contextmanager
def waiters(url: str, paths: Sequence[str]) -> Iterator[None]:
    """Requests that wait, each over a connection of its own, while the context lasts."""
    address = httpx2.URL(url)

    async def ask(path: str) -> asyncio.StreamWriter:
        _, writer = await asyncio.open_connection(address.host, address.port)
        writer.write(f"GET {path} HTTP/1.1\r\nHost: {address.host}\r\n\r\n".encode())
        await writer.drain()
        return writer

    async def ask_all() -> list[asyncio.StreamWriter]:
        return [await ask(path) for path in paths]

    with asyncio.Runner() as runner:
        writers = runner.run(ask_all())
        try:
            yield
        finally:
            for writer in writers:
                writer.close()


def cpu_seconds(pid: int) -> float:
    """Return the processor time that a process has taken."""
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def measured(url: str, job: str, pid: int, store: Store, seconds: float) -> dict[str, float]:
    """Ask for a job for a while; return shares of a core, counts a second and milliseconds."""

    def counters() -> tuple[float, ...]:
        stats = store.client.info("stats")
        # Commands within scripts are counted, too; what is read is about one round trip each.
        counts = stats["total_commands_processed"], stats["total_reads_processed"]
        return time.perf_counter(), cpu_seconds(pid), *counts

    with httpx2.Client(base_url=url, timeout=60.0) as http:
        time.sleep(SETTLING)
        before = counters()
        time.sleep(seconds)
        elapsed, cpu, commands, reads = np.subtract(counters(), before)
        latencies = []
        while time.perf_counter() - before[0] < 2 * seconds:
            asked = time.perf_counter()
            http.get(f"/v1/jobs/{job}").raise_for_status()
            latencies.append(time.perf_counter() - asked)
            time.sleep(0.02)
    return {
        "api_cpu": float(cpu / elapsed),
        "redis_commands": float(commands / elapsed),
        "redis_reads": float(reads / elapsed),
        "get_ms": 1000 * median(latencies),
    }


def main() -> None:
    """Measure, print the table."""
    parser = command_line(__doc__)
    parser.add_argument("--waiters", type=int, nargs="+", default=[0, 50, 200])
    parser.add_argument("--seconds", type=float, default=6.0, help="of each measurement")
    arguments = parsed(parser)
    configure_logging("WARNING")
    figures = {}
    with tempfile.TemporaryDirectory(prefix="isomatch-") as directory:
        server = EmbeddedServer(Path(directory))
        server.start()
        blobs = Path(directory, "blobs").as_uri()
        settings = Settings(redis_url=server.url, blob_url=blobs)
        queue = JobQueue(Store.open(settings, retry_seconds=10), settings)
        environment = {
            "ISOMATCH_REDIS_URL": server.url,
            "ISOMATCH_BLOB_URL": blobs,
            "ISOMATCH_WORKERS": "0",
            "ISOMATCH_LOG_LEVEL": "WARNING",
        }
        jobs = []
        for number in range(max(arguments.waiters) + 1):
            parameters = DissimilarityParameters()
            payload = DissimilaritiesPayload(shapes=("a", "b"), labels=None, parameters=parameters)
            job = queue.submit(payload).id
            if number % 2:
                queue.store.jobs.claim(job, job)
            jobs.append(job)
        try:
            with running_stack(environment) as stack:
                print(
                    f"{'':16}{'waiters':>8}{'API CPU':>9}{'commands':>10}{'reads':>8}{'GET ms':>8}"
                )
                for kind, suffix in KINDS.items():
                    for count in arguments.waiters:
                        paths = [f"/v1/jobs/{job}{suffix}" for job in jobs[1 : count + 1]]
                        with waiters(stack.url, paths):
                            pid, seconds = stack.process.pid, arguments.seconds
                            row = measured(stack.url, jobs[0], pid, queue.store, seconds)
                        figures[f"{kind}, {count}"] = row
                        print(
                            f"{kind:16}{count:8}{row['api_cpu']:9.1%}"
                            f"{row['redis_commands']:10.0f}{row['redis_reads']:8.0f}"
                            f"{row['get_ms']:8.1f}",
                            flush=True,
                        )
        finally:
            queue.store.close()
            server.stop()
    print_json(arguments, figures)


if __name__ == "__main__":
    main()
