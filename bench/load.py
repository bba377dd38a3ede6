"""Callers of a service under faults: each asks again with the same key until it is answered."""

import itertools
import threading
import time
from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass, field
from random import Random
from typing import Any, Final

import httpx2

TIMEOUT: Final = 15.0
"""Seconds after which a request without an answer is repeated."""

MOST_OPEN: Final = 8
"""Jobs of one caller that have not ended."""

QUICK: Final[Mapping[str, Any]] = {"points": 8, "eigenpairs": 30}
LONGER: Final[Mapping[str, Any]] = {"points": 96, "eigenpairs": 60, "alternatives": 16}

Request = tuple[str, dict[str, Any]]


@dataclass
class Account:
    """What callers were promised.

    Attributes
    ----------
    jobs
        Ids of the jobs that were answered to each idempotency key.
    refusals
        Refusals other than those that ask to come again, with their number.
    repeated
        Requests that had no answer, or were to come again.
    """

    jobs: dict[str, set[str]] = field(default_factory=lambda: defaultdict(set))
    refusals: dict[str, int] = field(default_factory=lambda: defaultdict(int))
    repeated: int = 0
    lock: threading.Lock = field(default_factory=threading.Lock)

    @property
    def accepted(self) -> set[str]:
        """Ids of all jobs that were promised."""
        return set().union(*self.jobs.values())


class Callers:
    """Threads that submit jobs to a service, and cancel some, until they are told to stop.

    Parameters
    ----------
    service
        A client of the service, with its address and its key.
    shapes
        Uploaded shapes.
    seed
        Of what they ask for.
    count
        Number of callers.
    most_open
        Jobs of one caller that have not ended.
    """

    def __init__(
        self,
        service: httpx2.Client,
        shapes: list[str],
        seed: int,
        count: int,
        most_open: int = MOST_OPEN,
    ) -> None:
        self.account = Account()
        self._most_open = most_open
        self.service, self._shapes = service, shapes
        self._stopping = threading.Event()
        self._threads = [
            threading.Thread(target=self._call, args=(name, Random(f"{seed}-{name}")))
            for name in range(count)
        ]

    def start(self) -> None:
        """Start to ask."""
        for thread in self._threads:
            thread.start()

    def stop(self) -> None:
        """Stop, when every request has been answered."""
        self._stopping.set()
        for thread in self._threads:
            thread.join()

    def _call(self, name: int, random: Random) -> None:
        url, headers = self.service.base_url, self.service.headers
        with httpx2.Client(base_url=url, headers=headers, timeout=TIMEOUT) as http:
            waiting: list[str] = []
            for number in itertools.count():
                if self._stopping.is_set():
                    return
                job = self._submit(http, f"{name}-{number}", _request(random, self._shapes))
                if job is None:
                    continue
                waiting.append(job)
                if random.random() < 0.05:
                    self._persistently(http, "DELETE", f"/v1/jobs/{job}")
                while len(waiting) >= self._most_open and not self._stopping.is_set():
                    try:
                        waiting = [one for one in waiting if not self._has_ended(http, one)]
                    except httpx2.TransportError:
                        break  # requests for jobs are to meet faults, too
                    time.sleep(0.1)

    def _submit(self, http: httpx2.Client, key: str, request: Request) -> str | None:
        """Submit a job, once or more often, and note what is promised."""
        path, body = request
        headers = {"Idempotency-Key": key}
        answer = self._persistently(http, "POST", path, json=body, headers=headers)
        with self.account.lock:
            if answer.status_code != 202:
                self.account.refusals[f"{answer.status_code} {answer.json().get('type')}"] += 1
                return None
            job: str = answer.json()["id"]
            self.account.jobs[key].add(job)
        return job

    def _has_ended(self, http: httpx2.Client, job: str) -> bool:
        answer = http.get(f"/v1/jobs/{job}")
        return answer.status_code != 200 or answer.json()["state"] not in ("queued", "running")

    def _persistently(
        self, http: httpx2.Client, method: str, path: str, **arguments: Any
    ) -> httpx2.Response:
        while True:
            try:
                answer = http.request(method, path, **arguments)
                if answer.status_code not in (429, 500, 502, 503, 504):
                    return answer
                if answer.status_code == 500:
                    with self.account.lock:
                        self.account.refusals[f"500 at {method} {path.split('/')[2]}"] += 1
            except httpx2.TransportError:
                pass
            with self.account.lock:
                self.account.repeated += 1
            time.sleep(0.2)


def _request(random: Random, shapes: list[str]) -> Request:
    """Return a request for a job, mostly a short match."""
    source, target = random.choice(shapes), random.choice(shapes)
    chance = random.random()
    if chance < 0.65:
        return "/v1/matches", {"source": source, "target": target, **QUICK}
    if chance < 0.8:
        return "/v1/matches", {"source": source, "target": target, **LONGER}
    if chance < 0.9:
        return "/v1/batches", {"source": source, "targets": shapes, **QUICK}
    return "/v1/dissimilarities", {"shapes": shapes, "points": 5}
