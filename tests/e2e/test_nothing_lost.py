"""Processes are killed while they work: every accepted job continues within a minute, and ends."""

import itertools
import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from threading import Thread
from typing import Any

import httpx2
import pytest

from bench.machines import Cluster, end, running_cluster
from broker.contracts import MatchResult
from tests.requests import ask, until_begun
from tests.worker.families import family
from tests.worker.figures import blob_file

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="reads /proc")

RECOVERY = 60.0
"""Seconds within which lost jobs have to continue."""

LONG: dict[str, Any] = {"points": 120, "coarse_points": 10, "alternatives": 32}
"""Parameters of a match that takes some seconds, within the memory limit."""

QUICK: dict[str, Any] = {"points": 8, "eigenpairs": 30, "orientation": False}


@pytest.fixture(scope="module")
def cluster(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Cluster]:
    with running_cluster(tmp_path_factory.mktemp("cluster")) as cluster:
        yield cluster


@pytest.fixture(scope="module")
def shape(cluster: Cluster) -> str:
    return cluster.upload(blob_file(4))


def succeeded(cluster: Cluster, job: str) -> None:
    """Assert that a job succeeds, with a result, and was repeated once at most."""
    record = cluster.ended(job)
    assert record["state"] == "succeeded", record
    result = MatchResult.model_validate_json(cluster.http.get(record["links"]["result"]).content)
    assert len(result.correspondences) == result.parameters.points


def learn(http: httpx2.Client, shapes: list[str], **parameters: object) -> str:
    """Have a prototype learned, and return the job's id."""
    answer = http.post("/v1/prototypes", json={"shapes": shapes, **parameters})
    assert answer.status_code == 202, answer.text
    job: str = answer.json()["id"]
    return job


def worker_of(cluster: Cluster, job: str) -> tuple[subprocess.Popen[str], int]:
    """Return the worker that runs a job, and the process it forked for it."""
    (found,) = cluster.horses_of(job)
    return found


def runs_in_another(cluster: Cluster, job: str, horse: int) -> bool:
    """Whether a live process runs a job, not one that has died and is still registered."""
    found = [process for _, process in cluster.horses_of(job)]
    return found != [] and horse not in found


def test_the_process_of_a_job_is_killed(cluster: Cluster, shape: str) -> None:
    job = ask(cluster.http, shape, **LONG)
    until_begun(cluster.http, job)
    _, horse = worker_of(cluster, job)
    os.kill(horse, signal.SIGKILL)
    cluster.until(lambda: runs_in_another(cluster, job, horse), RECOVERY)
    succeeded(cluster, job)


def test_a_worker_is_killed(cluster: Cluster, shape: str) -> None:
    job, waiting = ask(cluster.http, shape, **LONG), ask(cluster.http, shape, **QUICK)
    until_begun(cluster.http, job)
    worker, _ = worker_of(cluster, job)
    worker.kill()
    worker.wait()
    cluster.workers.remove(worker)
    assert cluster.workers_of(job) == []
    cluster.until(lambda: cluster.workers_of(job) != [], RECOVERY)
    succeeded(cluster, job)
    succeeded(cluster, waiting)
    cluster.workers.append(cluster.start_worker())


def test_a_worker_is_killed_while_it_learns_a_prototype(cluster: Cluster) -> None:
    shapes = [cluster.upload(data) for data in family(3, subdivisions=3)]
    job = learn(cluster.http, shapes, name="survivor", points=32, eigenpairs=40)
    until_begun(cluster.http, job)
    worker, _ = worker_of(cluster, job)
    worker.kill()
    worker.wait()
    cluster.workers.remove(worker)
    record = cluster.ended(job)
    assert record["state"] == "succeeded", record
    listed = cluster.http.get("/v1/prototypes", params={"name": "survivor"}).json()["items"]
    result = cluster.http.get(record["links"]["result"]).json()
    assert [(item["id"], item["version"]) for item in listed] == [(result["prototype"]["id"], 1)]
    cluster.workers.append(cluster.start_worker())


def test_the_api_is_killed(cluster: Cluster, shape: str) -> None:
    job = ask(cluster.http, shape, **LONG)
    until_begun(cluster.http, job)
    path = f"/v1/jobs/{job}"
    broken: list[Exception] = []

    def poll() -> None:
        while not broken:
            try:
                cluster.http.get(path, params={"wait": 60})
            except httpx2.TransportError as error:
                broken.append(error)

    thread = Thread(target=poll)
    thread.start()
    cluster.kill_api()
    thread.join()
    assert broken
    cluster.api = cluster.start_api()
    # The worker did not even notice.
    assert cluster.job(job)["state"] in ("running", "succeeded")
    succeeded(cluster, job)


def test_the_api_is_killed_while_jobs_come_in(cluster: Cluster, shape: str) -> None:
    before = jobs(cluster)
    answers: dict[str, str | None] = {}

    def submit(who: int) -> None:
        """Submit one job after the other until there is no response."""
        for number in itertools.count():
            key = f"killed-{who}-{number}"
            answers[key] = None
            try:
                answers[key] = ask(cluster.http, shape, key=key, **QUICK)
            except httpx2.TransportError:
                return

    with ThreadPoolExecutor(8) as threads:
        asking = [threads.submit(submit, who) for who in range(8)]
        cluster.until(lambda: sum(job is not None for job in [*answers.values()]) >= 4, 60)
        cluster.kill_api()
        for future in asking:
            future.result()
    cluster.api = cluster.start_api()
    # Who got no answer asks again, and so does who got one: there is one job of each key.
    again = {key: ask(cluster.http, shape, key=key, **QUICK) for key in answers}
    assert all(answers[key] in (None, job) for key, job in again.items())
    assert jobs(cluster) - before == set(again.values())
    assert len(set(again.values())) == len(again)
    for job in again.values():
        succeeded(cluster, job)


def jobs(cluster: Cluster) -> set[str]:
    """Ids of all submitted jobs."""
    found: set[str] = set()
    after: dict[str, str] = {}
    while True:
        page = cluster.http.get("/v1/jobs", params={"limit": "200", **after}).json()
        found |= {job["id"] for job in page["items"]}
        if page["next_cursor"] is None:
            return found
        after = {"cursor": page["next_cursor"]}


def test_the_store_is_killed(cluster: Cluster, shape: str) -> None:
    running, waiting = ask(cluster.http, shape, **LONG), ask(cluster.http, shape, **LONG)
    others = [ask(cluster.http, shape, **QUICK) for _ in range(5)]
    until_begun(cluster.http, running)
    cluster.restart_store()
    cluster.until(lambda: cluster.http.get("/health/live").status_code == 200, 60)
    for job in (running, waiting, *others):
        cluster.until(lambda job=job: cluster.job(job)["state"] != "queued", RECOVERY)
        succeeded(cluster, job)
    assert cluster.http.get(f"/v1/shapes/{shape}").status_code == 200


def failed(cluster: Cluster, job: str, slug: str) -> None:
    record = cluster.ended(job)
    assert record["state"] == "failed", record
    assert record["error"]["type"] == f"urn:isomatch:problem:{slug}"


def asked_of_the_impatient(cluster: Cluster, shape: str) -> str:
    """Submit a long match through an API with a job timeout of a second."""
    api = cluster.start_api("0", ISOMATCH_JOB_TIMEOUT="1")
    body = {"source": shape, "target": shape, "points": 256, "alternatives": 32}
    answer = httpx2.post(f"{cluster.listens}/v1/matches", json=body, timeout=60.0)
    end(api)
    job: str = answer.json()["id"]
    return job


def test_a_poisonous_input_fails_its_own_job_only(cluster: Cluster, shape: str) -> None:
    workers = [worker.pid for worker in cluster.workers]
    # More than the memory one job may take, and more than the time.
    bomb = ask(cluster.http, cluster.upload(blob_file(6)), eigenpairs=300)
    endless = asked_of_the_impatient(cluster, shape)
    others = [ask(cluster.http, shape, **QUICK) for _ in range(3)]
    failed(cluster, bomb, "out-of-memory")
    for job in others:
        succeeded(cluster, job)
    failed(cluster, endless, "timed-out")
    assert [worker.pid for worker in cluster.workers if worker.poll() is None] == workers
    succeeded(cluster, ask(cluster.http, shape, **QUICK))


def test_a_job_that_crashes_its_process_fails(cluster: Cluster, shape: str) -> None:
    job, horse = ask(cluster.http, shape, **LONG), 0
    for _ in range(2):
        cluster.until(partial(runs_in_another, cluster, job, horse), RECOVERY)
        until_begun(cluster.http, job)
        _, horse = worker_of(cluster, job)
        os.kill(horse, signal.SIGSEGV)
    failed(cluster, job, "worker-lost")
    succeeded(cluster, ask(cluster.http, shape, **QUICK))
