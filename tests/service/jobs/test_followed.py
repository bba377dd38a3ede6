"""The states of followed jobs, read together from a real store."""

import json
from collections.abc import Iterator

import pytest
from rq.utils import now, utcformat

from broker.contracts import (
    BatchPayload,
    DissimilaritiesPayload,
    DissimilarityParameters,
    MatchParameters,
    MatchPayload,
    Problem,
    ProblemType,
    Progress,
)
from broker.queue import JobQueue
from broker.store import have_ended
from service.jobs import FollowedJobs
from service.settings import Settings
from service.standalone import EmbeddedServer
from tests.service.conftest import idle_api


@pytest.fixture
def queue(server: EmbeddedServer) -> Iterator[JobQueue]:
    with idle_api(server) as api:
        yield JobQueue(api.store, Settings())


def match(queue: JobQueue, source: str = "a") -> str:
    payload = MatchPayload(source=source, target="b", parameters=MatchParameters())
    return queue.submit(payload).id


def batch_of(count: int) -> BatchPayload:
    targets = tuple("bcdefg"[:count])
    names = (None,) * count
    return BatchPayload(
        source="a", targets=targets, target_names=names, parameters=MatchParameters()
    )


def employ(queue: JobQueue) -> None:
    """Register a worker, which takes no job."""
    queue.store.client.hset("rq:worker:one", "last_heartbeat", utcformat(now()))
    queue.store.client.sadd("rq:workers", "rq:worker:one")


def test_jobs_of_several_tenants_are_read_together(queue: JobQueue) -> None:
    tenants = {tenant: queue.of(tenant) for tenant in ("default", "acme")}
    names = [(tenant, match(of)) for tenant, of in tenants.items() for _ in range(2)]
    tenants["acme"].store.jobs.claim(names[3][1], "me")
    found = FollowedJobs(queue)(names)
    shown = [json.loads(event.data) for event in found if event is not None]
    assert [one["id"] for one in shown] == [job for _, job in names]
    assert [one["state"] for one in shown] == ["queued"] * 3 + ["running"]
    # The tenant of a job is part of its name.
    assert FollowedJobs(queue)([("acme", names[0][1])]) == [None]


def test_records_that_have_not_changed_are_not_read_again(queue: JobQueue) -> None:
    def read() -> int:
        return int(queue.store.client.info("commandstats")["cmdstat_hgetall"]["calls"])

    names = [("default", match(queue)) for _ in range(3)]
    follow = FollowedJobs(queue)
    before = follow(names)
    reads = read()
    assert follow(names) == before
    assert read() == reads
    queue.store.jobs.claim(names[1][1], "me")
    after = follow(names)
    assert read() == reads + 1
    assert [one == other for one, other in zip(before, after, strict=True)] == [True, False, True]


def test_each_change_shows(queue: JobQueue) -> None:
    job, jobs, follow = match(queue), queue.store.jobs, FollowedJobs(queue)

    def shown() -> str:
        (event,) = follow([("default", job)])
        assert event is not None
        return event.id

    seen = [shown()]
    jobs.claim(job, "me")
    seen.append(shown())
    jobs.report(job, "me", Progress(stage="half", fraction=0.5))
    seen.append(shown())
    jobs.report(job, "me", Progress(stage="half", fraction=0.6))
    seen.append(shown())
    jobs.succeed(job, "me", b"{}")
    seen.append(shown())
    assert len(set(seen)) == len(seen)


def test_the_place_in_the_queue_shows(queue: JobQueue) -> None:
    first, second = match(queue), match(queue)
    follow = FollowedJobs(queue)
    (before,) = follow([("default", second)])
    queue.cancel(first)
    (after,) = follow([("default", second)])
    assert before is not None
    assert after is not None
    assert json.loads(before.data)["position"] == 1 + json.loads(after.data)["position"]


def test_a_match_that_its_batch_has_not_queued_yet_is_shown(queue: JobQueue) -> None:
    batch = queue.submit(batch_of(6)).id
    waiting = f"{batch}-5"
    (event,) = FollowedJobs(queue)([("default", waiting)])
    assert event is not None
    assert json.loads(event.data)["state"] == "queued"
    client, asked = queue.store.client, [("default", waiting, batch), ("default", waiting, None)]
    assert have_ended(client, asked) == [False, True]
    queue.cancel(batch)
    assert have_ended(client, asked) == [True, True]


@pytest.mark.parametrize("kind", ["comparison", "batch"])
def test_a_running_job_without_a_running_part_waits(queue: JobQueue, kind: str) -> None:
    jobs, follow = queue.store.jobs, FollowedJobs(queue)
    if kind == "batch":
        job = queue.submit(batch_of(2)).id
        part = f"{job}-1"
    else:
        comparison = DissimilaritiesPayload(
            shapes=("a", "b"), labels=None, parameters=DissimilarityParameters()
        )
        job = queue.submit(comparison).id
        (part,) = queue.store.chunks.time_slices(job)

    def waits_for() -> str | None:
        (event,) = follow([("default", job)])
        assert event is not None
        found: str | None = json.loads(event.data)["waiting_for"]
        return found

    jobs.claim(job, job)
    assert waits_for() == "worker"
    employ(queue)
    assert waits_for() == "turn"
    jobs.claim(part, "me")
    assert waits_for() is None
    jobs.fail(part, "me", Problem.of(ProblemType.WORKER_LOST, "It failed."))
    assert waits_for() == "turn"
    queue.cancel(job)
    assert waits_for() is None


def test_a_shape_that_cannot_be_read_concerns_its_jobs_alone(queue: JobQueue) -> None:
    store = queue.store
    employ(queue)
    names = [("default", match(queue)), ("default", match(queue, "c")), ("default", "gone")]
    store.client.set(store.keys.shape("a"), '{"from": "the future"}')
    unreadable, readable, gone = FollowedJobs(queue)(names)
    assert unreadable is None
    assert readable is not None
    assert gone is None
