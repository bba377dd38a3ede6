"""Workers whose meshes and results are in object storage, which may be away."""

from collections.abc import Iterator
from contextlib import contextmanager
from uuid import uuid4

from broker.contracts import JobState, MatchParameters, MatchPayload, shape_id
from broker.queue import JobQueue
from broker.store import Store
from tests.object_storage import BUCKET, ObjectServer, environment
from tests.waiting import until
from tests.worker.figures import blob_file
from tests.workers import ended, validation, worker
from worker.settings import WorkerSettings

QUICK = MatchParameters(points=3, orientation=False)


@contextmanager
def queue_of(server: ObjectServer, settings: WorkerSettings, patience: float) -> Iterator[JobQueue]:
    """An empty queue, with meshes and results in the server's bucket."""
    stores = {"blob_url": f"s3://{BUCKET}/{uuid4().hex}"}
    with environment(server.environment):
        opened = Store.open(settings.model_copy(update=stores), retry_seconds=patience)
        opened.client.flushdb()
        yield JobQueue(opened, settings)
        opened.close()


def test_a_match_in_object_storage(object_server: ObjectServer, settings: WorkerSettings) -> None:
    data = blob_file(4)
    with queue_of(object_server, settings, 60.0) as queue, worker(queue):
        assert ended(queue, validation(queue, data)).state is JobState.SUCCEEDED
        match = MatchPayload(source=shape_id(data), target=shape_id(data), parameters=QUICK)
        found = ended(queue, queue.submit(match).id)
        assert found.state is JobState.SUCCEEDED, found.error
        assert queue.store.results.document(found.id)
        assert queue.store.results.arrays(found.id)
        assert queue.store.shapes.upload(shape_id(data)) == data
        # A job that begins while the server is away ends when it has come back.
        object_server.kill()
        job = queue.submit(match).id
        until_running(queue, job)
        object_server.start()
        assert ended(queue, job).state is JobState.SUCCEEDED


def until_running(queue: JobQueue, job: str) -> None:
    until(lambda: queue.store.jobs.state(job) is JobState.RUNNING)


def test_a_job_says_that_object_storage_was_away(
    object_server: ObjectServer, settings: WorkerSettings
) -> None:
    data = blob_file(4)
    with (
        queue_of(object_server, settings, 20.0) as queue,
        worker(queue, ISOMATCH_WORKER_PATIENCE="0.1"),
    ):
        ended(queue, validation(queue, data))
        match = MatchPayload(source=shape_id(data), target=shape_id(data), parameters=QUICK)
        object_server.kill()
        try:
            record = ended(queue, queue.submit(match).id)
        finally:
            object_server.start()
        assert record.state is JobState.FAILED
        assert record.error is not None
        assert (record.error.slug, record.error.status) == ("store-away", 503)
        # The worker lives, and what is asked for again is done.
        again = ended(queue, queue.submit(match).id)
        assert again.state is JobState.SUCCEEDED
