"""Records that expire, end or reappear between two steps, and what they leave behind."""

import threading
from collections.abc import Callable, Sequence
from datetime import timedelta
from functools import cached_property

import pytest
from redis.client import Pipeline

from broker.contracts import (
    PAIRS,
    STRUCTURES,
    AttributesValidationPayload,
    DissimilaritiesPayload,
    DissimilarityParameters,
    JobRecord,
    JobState,
    MatchParameters,
    MatchPayload,
    MatchResult,
    PicturePayload,
    PrototypeRecord,
    PrototypeStructures,
    PrototypeValidationPayload,
    RequestOrigin,
    ShapeRecord,
    SpectrumKey,
    SpectrumPayload,
    UploadPayload,
    ValidationPayload,
    Webhook,
    shape_id,
)
from broker.queue import JobQueue, QueueSettings
from broker.store import (
    DEFAULT_KEYS,
    BlobReference,
    Blobs,
    CandidateGone,
    ClaimStatus,
    Listing,
    Shapes,
    Store,
    Uploads,
)
from broker.upkeep import LOSSES_WITH_WORKER, RecoveryTimeouts, recover, store_away
from broker.webhooks import WebhookSettings, dispatch
from solver.errors import Cancelled
from tests.broker.store.records import running
from tests.broker.store.test_attributes import RECORD as ATTRIBUTES
from tests.worker.figures import blob_file
from tests.worker.records import CREATED, shape_record
from tests.workers import validation
from worker.jobs.failures import JobTimedOut
from worker.jobs.runner import Runner
from worker.settings import WorkerSettings

SHAPE = "a" * 32
RECEIVER = Webhook(url="http://127.0.0.1:9/")


def put_shape(store: Store) -> None:
    payload = ValidationPayload(shape=SHAPE, name="x", file_type="off")
    job = JobQueue(store, QueueSettings()).submit_validation(payload, b"data")
    store.shapes.accept(shape_record(SHAPE), b"data", b"mesh", b"geometry", job)


def prototype_record(name: str) -> PrototypeRecord:
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


def ended_match(queue: JobQueue) -> JobRecord:
    """A match that has ended and whose webhook is not delivered."""
    match = MatchPayload(source=SHAPE, target=SHAPE, parameters=MatchParameters())
    record = queue.submit(match, RequestOrigin(webhook=RECEIVER))
    assert queue.store.jobs.cancel(record.id) is JobState.CANCELLED
    return record


def compared(queue: JobQueue) -> JobRecord:
    payload = DissimilaritiesPayload(
        shapes=(SHAPE, "b" * 32), labels=None, parameters=DissimilarityParameters()
    )
    return queue.submit(payload)


def lasting(store: Store) -> set[str]:
    """Keys of single jobs without a time to live."""
    names = {key.decode() for key in store.client.scan_iter(f"{DEFAULT_KEYS.job('')}*")}
    return {name for name in names if store.client.ttl(name) == -1}


def test_a_shape_uploaded_again_during_a_listing_stays_listed(store: Store) -> None:
    put_shape(store)
    listing = Listing(store.client, DEFAULT_KEYS.shapes, DEFAULT_KEYS.shape)

    def come_again(names: Sequence[str]) -> list[None]:
        for name in names:
            store.shapes.delete(name)
            put_shape(store)
        return [None for _ in names]

    assert listing.page(10, None, come_again).items == ()
    assert [shape.id for shape in store.shapes.page(10, None).items] == [SHAPE]
    store.client.delete(DEFAULT_KEYS.shape(SHAPE))
    assert store.shapes.page(10, None).items == ()
    assert store.client.zscore(DEFAULT_KEYS.shapes, SHAPE) is None


@pytest.mark.parametrize("kind", ["spectrum", "turn"])
def test_cached_blobs_of_a_deleted_shape_are_dropped(queue: JobQueue, kind: str) -> None:
    store = queue.store
    put_shape(store)
    there, gone = SpectrumKey(SHAPE, 10), SpectrumKey("b" * 32, 10)
    if kind == "turn":
        job = f"{compared(queue).id}-1"
    else:
        payload = SpectrumPayload(shape=gone.shape, eigenpairs=10, largest_component=False)
        job = queue.submit(payload).id
    # As if it had been put there after the shape was deleted.
    for key in (there, gone):
        assert store.spectra.put(key, b"spectrum")
    Runner(queue, "runner").run(job)
    assert store.spectra.has(there)
    assert not store.spectra.has(gone)


def test_cached_blobs_of_a_deleted_prototype_are_dropped(queue: JobQueue) -> None:
    spectra, prototype = queue.store.spectra, "p-" + SHAPE
    put_shape(queue.store)
    match = MatchPayload(source=prototype, target=SHAPE, parameters=MatchParameters())
    job = queue.submit(match).id
    for name in (prototype, SHAPE):
        assert spectra.put(f"{name}:surface0", b"spectrum")
    Runner(queue, "runner").run(job)
    assert spectra.get_many([f"{prototype}:surface0", f"{SHAPE}:surface0"]) == [None, b"spectrum"]


def test_a_prototype_stored_again_under_another_name_is_listed_there(
    store: Store,
) -> None:
    prototypes = store.prototypes
    prototypes.add(prototype_record("cat"), b"archive", b"geometry")
    store.client.delete(DEFAULT_KEYS.prototype("p-" + SHAPE))
    prototypes.add(prototype_record("animal"), b"archive", b"geometry")
    assert [one.name for one in prototypes.page(10, None, "animal").items] == ["animal"]
    assert prototypes.page(10, None, "cat").items == ()
    assert [one.name for one in prototypes.page(10, None).items] == ["animal"]


def test_an_upload_that_expires_during_validation_stores_no_partial_shape(queue: JobQueue) -> None:
    payload = ValidationPayload(shape=SHAPE, name="x", file_type="off")
    job = queue.submit_validation(payload, b"data")
    queue.store.client.delete(DEFAULT_KEYS.candidate(SHAPE, "off", job))
    with pytest.raises(CandidateGone):
        queue.store.shapes.accept(shape_record(SHAPE), b"data", b"mesh", b"geometry", job)
    assert queue.store.shapes.get(SHAPE) is None
    assert queue.store.shapes.mesh(SHAPE) is None


@pytest.mark.parametrize("kind", ["shape", "file", "prototype"])
def test_an_upload_that_is_rejected_while_it_is_stored_is_not_kept(
    queue: JobQueue, monkeypatch: pytest.MonkeyPatch, kind: str
) -> None:
    store, link = queue.store, Blobs.link
    payloads: dict[str, UploadPayload] = {
        "shape": ValidationPayload(shape=SHAPE, name="x", file_type="off"),
        "file": AttributesValidationPayload(attributes=ATTRIBUTES.id, name="x", file_type="csv"),
        "prototype": PrototypeValidationPayload(prototype="p-" + SHAPE, name="x"),
    }
    payload, prototype = payloads[kind], prototype_record("x")
    job = queue.submit_validation(payload, b"data")
    store_it: dict[str, Callable[[], object]] = {
        "shape": lambda: store.shapes.accept(shape_record(SHAPE), b"data", b"m", b"g", job),
        "file": lambda: store.attributes.accept(ATTRIBUTES, b"data", job),
        "prototype": lambda: store.prototypes.add(prototype, b"data", b"g", job),
    }

    def rejecting(blobs: Blobs, key: str, reference: BlobReference, pipe: Pipeline) -> None:
        link(blobs, key, reference, pipe)
        store.uploads.reject(payload.upload, payload.file_type, job)

    monkeypatch.setattr(Blobs, "link", rejecting)
    with pytest.raises(CandidateGone):
        store_it[kind]()
    keys = (DEFAULT_KEYS.shape, DEFAULT_KEYS.attributes, DEFAULT_KEYS.prototype)
    assert not store.client.exists(*(key(payload.upload) for key in keys))


def test_a_candidate_outlives_a_process_that_dies_before_it_stores_the_shape(
    queue: JobQueue, monkeypatch: pytest.MonkeyPatch
) -> None:
    payload = ValidationPayload(shape=SHAPE, name="x", file_type="off")
    job, shapes = queue.submit_validation(payload, b"data"), queue.store.shapes

    def die(*_: object) -> None:
        raise SystemExit

    monkeypatch.setattr("broker.store.record_store.delete_candidate", die)
    with pytest.raises(SystemExit):
        shapes.accept(shape_record(SHAPE), b"data", b"m", b"g", job)
    left = queue.store.client.ttl(DEFAULT_KEYS.candidate(SHAPE, "off", job))
    assert shapes.settings.candidate_ttl - 500 <= left <= shapes.settings.candidate_ttl


class StoredTwice(Shapes):
    """Shapes where a run that was given up stores the shape a moment earlier."""

    def accept(
        self, record: ShapeRecord, upload: bytes, mesh: bytes, geometry: bytes, job_id: str
    ) -> None:
        """Store the shape twice."""
        for _ in range(2):
            super().accept(record, upload, mesh, geometry, job_id)


class StoringTwice(Store):
    """A store of such shapes."""

    @cached_property
    def shapes(self) -> StoredTwice:
        """Those shapes."""
        return self._part(StoredTwice)


def test_an_upload_validated_by_two_runs_is_a_shape(store: Store) -> None:
    twice = StoringTwice.over(store.client, store.settings, retry_seconds=1)
    queue = JobQueue(twice, QueueSettings())
    data = blob_file(1)
    payload = ValidationPayload(shape=shape_id(data), name="x", file_type="off")
    job = queue.submit_validation(payload, data)
    Runner(queue, "runner").run(job)
    assert store.jobs.state(job) is JobState.SUCCEEDED
    assert store.shapes.upload(shape_id(data)) == data


def test_no_picture_outlives_a_deleted_result(store: Store) -> None:
    results, jobs = store.results, store.jobs
    for _ in range(10):
        drawn, over = running(jobs), threading.Event()
        assert jobs.succeed(drawn, "r", b"{}")
        picture = PicturePayload(job=drawn)

        def draw(picture: PicturePayload = picture, over: threading.Event = over) -> None:
            while not over.is_set():
                results.set_picture(picture, b"picture")

        drawing = threading.Thread(target=draw)
        drawing.start()
        while results.picture(picture) is None:
            pass
        assert results.delete(drawn)
        over.set()
        drawing.join()
        assert results.picture(picture) is None


@pytest.mark.parametrize("error", [JobTimedOut, Cancelled])
def test_a_run_that_was_given_up_leaves_the_upload(
    queue: JobQueue, monkeypatch: pytest.MonkeyPatch, error: type[BaseException]
) -> None:
    jobs, job = queue.store.jobs, validation(queue, blob_file(1))

    def stand_still(*_: object) -> None:
        assert jobs.lose(job, LOSSES_WITH_WORKER, store_away(), "first") is JobState.QUEUED
        raise error

    with monkeypatch.context() as patched:
        patched.setattr("worker.jobs.validation.read_mesh", stand_still)
        Runner(queue, "first").run(job)
    Runner(queue, "second").run(job)
    assert jobs.state(job) is JobState.SUCCEEDED


@pytest.mark.parametrize(
    ("error", "end"), [(JobTimedOut, JobState.FAILED), (Cancelled, JobState.CANCELLED)]
)
def test_an_upload_is_rejected_when_no_other_run_can_need_it(
    queue: JobQueue,
    monkeypatch: pytest.MonkeyPatch,
    error: type[BaseException],
    end: JobState,
) -> None:
    jobs, job, reject = queue.store.jobs, validation(queue, blob_file(1)), Uploads.reject
    states = []

    def stop(*_: object) -> None:
        raise error

    def rejecting(uploads: Uploads, upload: str, file_type: str, of: str) -> None:
        # Given up now, it would be run again.
        states.append(jobs.lose(of, LOSSES_WITH_WORKER, store_away(), "first"))
        reject(uploads, upload, file_type, of)

    monkeypatch.setattr("worker.jobs.validation.read_mesh", stop)
    monkeypatch.setattr(Uploads, "reject", rejecting)
    Runner(queue, "first").run(job)
    assert states == [end]
    assert not queue.store.client.keys("*candidate*")


def test_arrays_and_document_are_of_one_run(
    queue: JobQueue, monkeypatch: pytest.MonkeyPatch
) -> None:
    jobs, data = queue.store.jobs, blob_file(1)
    Runner(queue, "first").run(validation(queue, data))
    parameters = MatchParameters(points=8, eigenpairs=10, orientation=False)
    match = MatchPayload(source=shape_id(data), target=shape_id(data), parameters=parameters)
    job, others = queue.submit(match).id, ["second"]

    def stand_still(result: MatchResult) -> bytes:
        """Let another run be first."""
        if others:
            assert jobs.lose(job, LOSSES_WITH_WORKER, store_away(), "first") is JobState.QUEUED
            Runner(queue, others.pop()).run(job)
            return b"of the first run"
        return b"of the second run"

    monkeypatch.setattr("worker.jobs.matches.arrays_of", stand_still)
    Runner(queue, "first").run(job)
    assert jobs.state(job) is JobState.SUCCEEDED
    assert queue.store.results.arrays(job) == b"of the second run"


@pytest.mark.parametrize("kind", ["shape", "prototype"])
def test_an_upload_that_expires_before_validation_is_reported(queue: JobQueue, kind: str) -> None:
    payload: UploadPayload = ValidationPayload(shape=SHAPE, name="x", file_type="off")
    if kind == "prototype":
        payload = PrototypeValidationPayload(prototype="p-" + SHAPE, name="x")
    job = queue.submit_validation(payload, b"data")
    queue.store.client.delete(DEFAULT_KEYS.candidate(payload.upload, payload.file_type, job))
    Runner(queue, "runner").run(job)
    record = queue.store.jobs.get(job)
    assert record is not None
    assert record.error is not None
    assert (record.error.slug, record.error.status) == ("upload-expired", 410)
    assert "send it again" in record.error.detail


def test_a_webhook_of_an_expired_job_leaves_nothing(queue: JobQueue) -> None:
    webhooks, client = queue.store.webhooks, queue.store.client
    record = ended_match(queue)

    def begin(attempt: int) -> None:
        with client.pipeline() as pipe:
            webhooks.begin(record.id, attempt, pipe)
            pipe.execute()

    begin(1)
    assert webhooks.attempts(record.id) == 1
    client.delete(DEFAULT_KEYS.job(record.id))
    begin(2)
    assert not client.exists(DEFAULT_KEYS.job(record.id))
    client.zadd(DEFAULT_KEYS.webhooks, {record.id: 1.0})
    dispatch(queue, WebhookSettings())
    assert client.zcard(DEFAULT_KEYS.webhooks) == 0
    begin(3)
    assert client.zcard(DEFAULT_KEYS.webhooks) == 0


def test_an_ended_job_gets_no_further_time_slices(queue: JobQueue) -> None:
    record, store = compared(queue), queue.store
    store.jobs.claim(record.id, record.id)
    queue.submit_time_slice(record)
    assert len(store.chunks.time_slices(record.id)) == 2
    store.jobs.cancel(record.id)
    store.chunks.delete(record.id)
    queue.submit_time_slice(record)
    assert store.chunks.time_slices(record.id) == {}
    for number in (1, 2):
        Runner(queue, "runner").run(f"{record.id}-{number}")
    assert lasting(store) == set()
    assert not store.client.exists(
        DEFAULT_KEYS.job_chunks(record.id), DEFAULT_KEYS.time_slices(record.id)
    )


def test_a_comparison_lost_too_often_leaves_nothing(queue: JobQueue) -> None:
    record, store = compared(queue), queue.store
    now = RecoveryTimeouts(unknown=timedelta(0), heartbeat=timedelta(0))
    for _ in range(LOSSES_WITH_WORKER + 1):
        assert store.jobs.claim(record.id, record.id)
        store.chunks.open_stage(record.id, "", STRUCTURES, 2, 0.5)
        assert store.chunks.claim(record.id, "slice", "runner").status is ClaimStatus.CLAIMED
        for time_slice in store.chunks.time_slices(record.id):
            queue.rq.withdraw(time_slice)
            store.client.delete(DEFAULT_KEYS.job(time_slice))
        # Noticed in the first pass, lost in the second.
        recover(queue, now)
        recover(queue, now)
    assert store.jobs.state(record.id) is JobState.FAILED
    assert lasting(store) == set()
    assert store.chunks.counts(record.id).stage == ""


@pytest.fixture
def brief(store: Store, settings: WorkerSettings) -> JobQueue:
    """A queue whose records expire a second after the jobs' ends."""
    changed = settings.model_copy(update={"job_ttl": 1})
    return JobQueue(Store.over(store.client, changed, retry_seconds=1), settings)


def test_a_comparison_may_take_longer_than_job_ttl(brief: JobQueue) -> None:
    store, record = brief.store, compared(brief)
    store.chunks.set_input(record.id, PAIRS, b"collection")
    long = 86400
    assert store.client.ttl(DEFAULT_KEYS.stage_input(record.id, PAIRS)) > long
    assert store.client.ttl(DEFAULT_KEYS.time_slices(record.id)) > long
    assert store.jobs.claim(record.id, record.id)
    known = {0: b"signature"}
    assert store.chunks.open_stage(record.id, "", STRUCTURES, 2, 0.5, known=known)
    assert store.client.ttl(DEFAULT_KEYS.chunk_results(record.id, STRUCTURES)) > long
    chunk = store.chunks.claim(record.id, "slice", "runner")
    assert (chunk.status, chunk.number) == (ClaimStatus.CLAIMED, 1)
    assert store.chunks.complete(record.id, chunk, b"signature", 0.1)
    assert store.client.ttl(DEFAULT_KEYS.job_chunks(record.id)) > long
    assert store.client.ttl(DEFAULT_KEYS.chunk_results(record.id, STRUCTURES)) > long
