"""Records of newer versions: defaults are not stored, unknown records are left alone."""

import json
from dataclasses import replace
from datetime import timedelta

import pytest
from rq.job import Job
from rq.serializers import JSONSerializer

from broker.contracts import (
    ConsistentMapsPayload,
    DissimilaritiesPayload,
    DissimilarityParameters,
    JobKind,
    JobState,
    MatchParameters,
    MatchPayload,
    Payload,
    PicturePayload,
    PrototypeParameters,
    PrototypePayload,
    RegistrationPayload,
    TimeSlicePayload,
)
from broker.queue import JobQueue
from broker.store import BUCKET_BOUNDS, DEFAULT_KEYS, Keys, NewerRecord
from broker.upkeep import LOSSES_WITH_WORKER, RecoveryTimeouts, handle_lost_process, recover
from broker.webhooks import WebhookSettings, dispatch
from worker.jobs.runner import Runner

SHAPES = ("a" * 32, "b" * 32)


def match(**parameters: object) -> MatchPayload:
    given = MatchParameters.model_validate(parameters)
    return MatchPayload(source=SHAPES[0], target=SHAPES[1], parameters=given)


def kept(queue: JobQueue, job: str) -> dict[str, object]:
    """The parameters in the record of a job."""
    found = queue.store.client.hget(DEFAULT_KEYS.job(job), "record")
    assert found is not None
    parameters: dict[str, object] = json.loads(found)["payload"]["parameters"]
    return parameters


def of_a_newer_version(queue: JobQueue, payload: Payload) -> str:
    """Queue a job with an unknown parameter."""
    job = queue.submit(payload).id
    found = queue.store.client.hget(DEFAULT_KEYS.job(job), "record")
    assert found is not None
    document = json.loads(found)
    document["payload"]["parameters"]["novel"] = 1
    queue.store.client.hset(DEFAULT_KEYS.job(job), "record", json.dumps(document))
    return job


COMPARED = DissimilaritiesPayload(
    shapes=SHAPES, labels=None, parameters=DissimilarityParameters(points=4)
)
LEARNED = PrototypePayload(
    shapes=SHAPES, reference=1, correspondences=None, name="x", parameters=PrototypeParameters()
)


@pytest.mark.parametrize(
    ("payload", "given"),
    [
        (match(), set()),
        (match(points=9, metric={"name": "diffusion", "time": 0.25}), {"points", "metric"}),
        (match(descriptor="none", landmarks=[[1, 2]]), {"descriptor", "landmarks"}),
        (match(points=32, dense=True), {"dense"}),
        (COMPARED, {"points"}),
        (LEARNED, set()),
    ],
    ids=["match", "metric", "landmarks", "dense", "collection", "prototype"],
)
def test_defaults_are_not_stored_and_are_read_back(
    queue: JobQueue, payload: Payload, given: set[str]
) -> None:
    job = queue.submit(payload).id
    record = queue.store.jobs.get(job)
    assert record is not None
    assert record.payload == payload
    assert set(kept(queue, job)) == given


@pytest.mark.parametrize(
    "payload",
    [
        COMPARED,
        ConsistentMapsPayload(shapes=SHAPES, parameters=MatchParameters()),
        RegistrationPayload(
            template=SHAPES[0], shapes=SHAPES[1:], scale=False, parameters=MatchParameters()
        ),
    ],
    ids=["dissimilarities", "consistent maps", "registration"],
)
def test_records_from_before_names_are_read(queue: JobQueue, payload: Payload) -> None:
    key = DEFAULT_KEYS.job(queue.submit(payload).id)
    found = queue.store.client.hget(key, "record")
    assert found is not None
    document = json.loads(found)
    for name in ("names", "template_name"):
        document["payload"].pop(name, None)
    queue.store.client.hset(key, "record", json.dumps(document))
    record = queue.store.jobs.get(document["id"])
    assert record is not None
    assert record.payload == payload


def test_an_unreadable_job_fails_with_the_reason(queue: JobQueue) -> None:
    job = of_a_newer_version(queue, match())
    with pytest.raises(NewerRecord, match="newer version"):
        queue.store.jobs.get(job)
    Runner(queue, "runner").run(job)
    assert queue.store.jobs.state(job) is JobState.FAILED
    error = queue.store.client.hget(DEFAULT_KEYS.job(job), "error")
    assert error is not None
    assert json.loads(error)["type"] == "urn:isomatch:problem:newer-version"


@pytest.mark.parametrize("damaged", [False, True])
def test_an_unreadable_comparison_fails_with_the_reason(queue: JobQueue, damaged: bool) -> None:
    job = of_a_newer_version(queue, COMPARED)
    if damaged:
        queue.store.client.hset(DEFAULT_KEYS.job(job), "record", "{")
    turn = queue.submit(TimeSlicePayload(job=job)).id
    Runner(queue, "runner").run(turn)
    assert queue.store.jobs.state(job) is JobState.FAILED
    assert queue.store.jobs.state(turn) is JobState.SUCCEEDED


def test_a_damaged_job_fails(queue: JobQueue) -> None:
    job = queue.submit(match()).id
    queue.store.client.hset(DEFAULT_KEYS.job(job), "record", "{")
    Runner(queue, "runner").run(job)
    assert queue.store.jobs.state(job) is JobState.FAILED


@pytest.mark.parametrize(
    ("field", "value"),
    [("state", "paused"), ("delivery", '{"state": "paused"}'), ("error", '{"type": "novel"}')],
)
def test_an_unreadable_job_does_not_hide_others(queue: JobQueue, field: str, value: str) -> None:
    unread, other = (queue.submit(match()).id for _ in range(2))
    queue.store.client.hset(DEFAULT_KEYS.job(unread), field, value)
    with pytest.raises(NewerRecord):
        queue.store.jobs.get(unread)
    assert [record.id for record in queue.store.jobs.page(10, None).items] == [other]
    active = {unread, other} if field != "state" else {other}
    assert {job.id for job in queue.store.jobs.active()} == active


def test_unknown_counters_are_ignored(queue: JobQueue) -> None:
    counters = queue.store.counters
    counters.observe(JobKind.MATCH, {"total": 2.0})
    before = counters.read()
    for novel in (f"class|match|total|{len(BUCKET_BOUNDS) + 1}", "novel|match", "novel"):
        queue.store.client.hset(Keys.COUNTERS, novel, "1")
    assert counters.read() == before


def test_upkeep_skips_unreadable_records(queue: JobQueue) -> None:
    unread, other = of_a_newer_version(queue, match()), queue.submit(match()).id
    queue.store.client.delete(queue.rq.current.key)
    for _ in range(2):
        recover(queue, replace(RecoveryTimeouts.of(5), unknown=timedelta(0)))
    assert queue.rq.current.get_job_ids() == [other]
    assert [record.id for record in queue.store.jobs.page(10, None).items] == [other]
    # It stays in the listings, for those who can read it.
    assert queue.store.client.zscore(DEFAULT_KEYS.jobs, unread) is not None
    assert queue.store.client.zscore(DEFAULT_KEYS.active_jobs, unread) is not None
    queue.store.client.zadd(DEFAULT_KEYS.webhooks, {unread: 0.0})
    dispatch(queue, WebhookSettings())
    assert queue.store.client.zscore(DEFAULT_KEYS.webhooks, unread) is not None


def test_a_lost_process_of_an_unreadable_job_does_not_stop_the_worker(queue: JobQueue) -> None:
    job = of_a_newer_version(queue, match())
    assert queue.store.jobs.claim(job, "runner")
    lost = Job.fetch(job, connection=queue.store.client, serializer=JSONSerializer)
    handle_lost_process(queue.store, lost, "killed", LOSSES_WITH_WORKER, "runner")
    assert queue.store.jobs.state(job) is JobState.QUEUED
    assert lost.retries_left == 1


def test_an_unreadable_shape_fails_its_job(queue: JobQueue) -> None:
    drawn = of_a_newer_version(queue, match())
    queue.store.blobs.save(DEFAULT_KEYS.job_result(drawn), b"", 1000)
    job = queue.submit(PicturePayload(job=drawn)).id
    Runner(queue, "runner").run(job)
    record = queue.store.jobs.get(job)
    assert record is not None
    assert record.error is not None
    assert record.error.slug == "newer-version"
