"""What expires, ends or comes again between two looks, and leaves nothing behind for good."""

from dataclasses import replace
from datetime import timedelta

import pytest
from redis.client import Pipeline

from broker.contracts import (
    PAIRS,
    STRUCTURES,
    DissimilaritiesPayload,
    DissimilarityParameters,
    JobRecord,
    JobState,
    MatchParameters,
    MatchPayload,
    PrototypeRecord,
    PrototypeStructures,
    PrototypeValidationPayload,
    ShapeRecord,
    SpectrumKey,
    SpectrumPayload,
    UploadPayload,
    ValidationPayload,
    Webhook,
    shape_id,
)
from broker.queue import JobQueue, QueueSettings, new_job
from broker.store import Listing, Offer, Shapes, Store, keys
from broker.upkeep import LOSSES_WITH_WORKER, Patience, recover
from broker.webhooks import WebhookSettings, dispatch
from tests.worker.figures import blob_file
from tests.worker.records import CREATED, shape_record
from worker.jobs import Runner
from worker.process.settings import WorkerSettings

SHAPE = "a" * 32
RECEIVER = Webhook(url="http://127.0.0.1:9/")


def put_shape(store: Store) -> None:
    payload = ValidationPayload(shape=SHAPE, name="x", file_type="off")
    job = JobQueue(store, QueueSettings()).submit_validation(payload, b"data")
    assert store.shapes.accept(shape_record(SHAPE), b"mesh", b"geometry", job)


def ended_match(queue: JobQueue) -> JobRecord:
    """A match that has ended, whose receiver is still to be told."""
    match = MatchPayload(source=SHAPE, target=SHAPE, parameters=MatchParameters())
    record = new_job(match).model_copy(update={"webhook": RECEIVER})
    queue.submit(record)
    assert queue.store.jobs.cancel(record.id) is JobState.CANCELLED
    return record


def compared(queue: JobQueue) -> JobRecord:
    payload = DissimilaritiesPayload(
        shapes=(SHAPE, "b" * 32), labels=None, parameters=DissimilarityParameters()
    )
    return queue.submit(new_job(payload))


def lasting(store: Store) -> set[str]:
    """Keys of single jobs that stay until somebody deletes them."""
    names = {key.decode() for key in store.client.scan_iter(f"{keys.job('')}*")}
    return {name for name in names if store.client.ttl(name) == -1}


def test_a_shape_that_comes_again_while_it_is_looked_for_stays_listed(store: Store) -> None:
    put_shape(store)
    listing = Listing(store.client, keys.SHAPES, keys.shape)

    def come_again(name: str) -> None:
        store.shapes.delete(name)
        put_shape(store)

    assert listing.page(10, None, come_again).items == ()
    assert [shape.id for shape in store.shapes.page(10, None).items] == [SHAPE]
    store.client.delete(keys.shape(SHAPE))
    assert store.shapes.page(10, None).items == ()
    assert store.client.zscore(keys.SHAPES, SHAPE) is None


@pytest.mark.parametrize("kind", ["spectrum", "turn"])
def test_what_was_found_out_of_a_deleted_shape_does_not_stay(queue: JobQueue, kind: str) -> None:
    store = queue.store
    put_shape(store)
    there, gone = SpectrumKey(SHAPE, 10), SpectrumKey("b" * 32, 10)
    if kind == "turn":
        job = f"{compared(queue).id}-1"
    else:
        payload = SpectrumPayload(shape=gone.shape, eigenpairs=10, largest_component=False)
        job = queue.submit(new_job(payload)).id
    # As if it had been put there after the shape was deleted.
    for key in (there, gone):
        assert store.spectra.put(key, b"spectrum")
    Runner(queue, "runner").run(job)
    assert store.spectra.has(there)
    assert not store.spectra.has(gone)


def test_what_was_found_out_of_a_deleted_prototype_does_not_stay(queue: JobQueue) -> None:
    spectra, prototype = queue.store.spectra, "p-" + SHAPE
    put_shape(queue.store)
    match = MatchPayload(source=prototype, target=SHAPE, parameters=MatchParameters())
    job = queue.submit(new_job(match)).id
    for name in (prototype, SHAPE):
        assert spectra.put(f"{name}:surface0", b"spectrum")
    Runner(queue, "runner").run(job)
    assert spectra.signatures([f"{prototype}:surface0", f"{SHAPE}:surface0"]) == [None, b"spectrum"]


def test_a_prototype_that_comes_again_under_another_name_is_listed_under_that(
    store: Store,
) -> None:
    def named(name: str) -> PrototypeRecord:
        return PrototypeRecord(
            id="p-" + SHAPE,
            name=name,
            version=1,
            bytes=1,
            points=3,
            components=1,
            examples=1,
            parameters=PrototypeStructures(),
            learned_from=None,
            reference=None,
            warnings=(),
            created=CREATED + timedelta(seconds=len(name)),
        )

    prototypes = store.prototypes
    prototypes.add(named("cat"), b"archive", b"geometry")
    store.client.delete(keys.prototype("p-" + SHAPE))
    prototypes.add(named("animal"), b"archive", b"geometry")
    assert [one.name for one in prototypes.page(10, None, "animal").items] == ["animal"]
    assert prototypes.page(10, None, "cat").items == ()
    assert [one.name for one in prototypes.page(10, None).items] == ["animal"]


def test_an_upload_that_expires_while_it_is_read_makes_no_half_of_a_shape(queue: JobQueue) -> None:
    payload = ValidationPayload(shape=SHAPE, name="x", file_type="off")
    job = queue.submit_validation(payload, b"data")
    queue.store.client.delete(keys.candidate(SHAPE, "off", job))
    assert not queue.store.shapes.accept(shape_record(SHAPE), b"mesh", b"geometry", job)
    assert queue.store.shapes.get(SHAPE) is None
    assert queue.store.shapes.mesh(SHAPE) is None


class Dying(Shapes):
    """Shapes of a process that ends just before it stores one."""

    def release(self, upload_id: str, file_type: str, job_id: str, pipe: Pipeline) -> None:
        """End instead."""
        raise SystemExit


def test_an_upload_is_still_there_for_who_comes_after_one_that_died(queue: JobQueue) -> None:
    payload = ValidationPayload(shape=SHAPE, name="x", file_type="off")
    job, shapes = queue.submit_validation(payload, b"data"), queue.store.shapes
    with pytest.raises(SystemExit):
        Dying(shapes.client, shapes.settings).accept(shape_record(SHAPE), b"m", b"g", job)
    left = queue.store.client.ttl(keys.candidate(SHAPE, "off", job))
    assert shapes.settings.candidate_ttl - 500 <= left <= shapes.settings.candidate_ttl


class ComingBack(Shapes):
    """Shapes where one that was given up and came back is a moment earlier."""

    def accept(self, record: ShapeRecord, mesh: bytes, geometry: bytes, job_id: str) -> bool:
        """Make the shape for the other, and then for this one."""
        assert super().accept(record, mesh, geometry, job_id)
        return super().accept(record, mesh, geometry, job_id)


def test_an_upload_that_two_have_read_is_a_shape(store: Store) -> None:
    shapes = ComingBack(store.client, store.shapes.settings)
    queue = JobQueue(replace(store, shapes=shapes), QueueSettings())
    data = blob_file(1)
    payload = ValidationPayload(shape=shape_id(data), name="x", file_type="off")
    job = queue.submit_validation(payload, data)
    Runner(queue, "runner").run(job)
    assert store.jobs.state(job) is JobState.SUCCEEDED
    assert store.shapes.upload(shape_id(data)) == data


@pytest.mark.parametrize("kind", ["shape", "prototype"])
def test_an_upload_that_waits_for_too_long_is_told_as_such(queue: JobQueue, kind: str) -> None:
    payload: UploadPayload = ValidationPayload(shape=SHAPE, name="x", file_type="off")
    if kind == "prototype":
        payload = PrototypeValidationPayload(prototype="p-" + SHAPE, name="x")
    job = queue.submit_validation(payload, b"data")
    queue.store.client.delete(keys.candidate(payload.upload, payload.file_type, job))
    Runner(queue, "runner").run(job)
    record = queue.store.jobs.get(job)
    assert record is not None
    assert record.error is not None
    assert (record.error.slug, record.error.status) == ("upload-expired", 410)
    assert "send it again" in record.error.detail


def test_a_webhook_of_a_job_that_expires_meanwhile_leaves_nothing(queue: JobQueue) -> None:
    webhooks, client = queue.store.webhooks, queue.store.client
    record = ended_match(queue)
    assert webhooks.begin(record.id, "delivery", 1)
    assert (webhooks.delivery_job(record.id), webhooks.attempts(record.id)) == ("delivery", 1)
    client.delete(keys.job(record.id))
    assert not webhooks.begin(record.id, "delivery", 2)
    assert not client.exists(keys.job(record.id))
    dispatch(queue, WebhookSettings())
    assert webhooks.pending() == 0


def test_a_job_that_is_over_gets_no_further_turns(queue: JobQueue) -> None:
    record, store = compared(queue), queue.store
    store.jobs.claim(record.id, record.id)
    queue.submit_turn(record)
    assert len(store.parts.turns(record.id)) == 2
    store.jobs.cancel(record.id)
    store.parts.forget(record.id)
    queue.submit_turn(record)
    assert store.parts.turns(record.id) == {}
    for number in (1, 2):
        Runner(queue, "runner").run(f"{record.id}-{number}")
    assert lasting(store) == set()
    assert not store.client.exists(keys.job_parts(record.id), keys.job_turns(record.id))


def test_a_comparison_that_is_lost_for_good_leaves_nothing(queue: JobQueue) -> None:
    record, store = compared(queue), queue.store
    now = Patience(unseen=timedelta(0), silence=timedelta(0))
    for _ in range(LOSSES_WITH_WORKER + 1):
        assert store.jobs.claim(record.id, record.id)
        store.parts.open(record.id, "", STRUCTURES, 2, 0.5)
        assert store.parts.take(record.id, "turn", "runner").offer is Offer.PART
        for turn in store.parts.turns(record.id):
            queue.withdraw(turn)
            store.client.delete(keys.job(turn))
        # It is seen to be lost, and the next time that it still is.
        recover(store, queue, now)
        recover(store, queue, now)
    assert store.jobs.state(record.id) is JobState.FAILED
    assert lasting(store) == set()
    assert store.parts.counts(record.id).stage == ""


@pytest.fixture
def brief(store: Store, settings: WorkerSettings) -> JobQueue:
    """A queue whose records are kept for a second after their jobs' ends."""
    changed = settings.model_copy(update={"job_ttl": 1})
    return JobQueue(Store.over(store.client, changed, patience=1), settings)


def test_a_comparison_may_take_longer_than_records_are_kept(brief: JobQueue) -> None:
    store, record = brief.store, compared(brief)
    store.parts.set_input(record.id, PAIRS, b"collection")
    store.parts.supply(record.id, STRUCTURES, {0: b"signature"})
    long = 86400
    assert store.client.ttl(keys.job_input(record.id, PAIRS)) > long
    assert store.client.ttl(keys.job_done(record.id, STRUCTURES)) > long
    assert store.client.ttl(keys.job_turns(record.id)) > long
    assert store.jobs.claim(record.id, record.id)
    assert store.parts.open(record.id, "", STRUCTURES, 2, 0.5)
    taken = store.parts.take(record.id, "turn", "runner")
    assert (taken.offer, taken.part) == (Offer.PART, 1)
    assert store.parts.complete(record.id, taken, b"signature", 0.1)
    assert store.client.ttl(keys.job_parts(record.id)) > long
    assert store.client.ttl(keys.job_done(record.id, STRUCTURES)) > long
