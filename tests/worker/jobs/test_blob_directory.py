"""Workers whose blob directory is not there for a while, as that of a server that starts anew."""

import time
from pathlib import Path
from urllib.parse import urlsplit

from broker.contracts import JobState, MatchParameters, MatchPayload, shape_id
from broker.queue import JobQueue
from tests.waiting import until
from tests.worker.figures import blob_file
from tests.workers import ended, validation, worker
from worker.settings import WorkerSettings

QUICK = MatchParameters(points=3, orientation=False)

AWAY = 2.0
"""Seconds in which a running job that does not wait is lost, and begun again, four times."""


def test_a_directory_that_is_away_is_waited_for(queue: JobQueue, settings: WorkerSettings) -> None:
    assert settings.blob_url is not None
    root = Path(urlsplit(settings.blob_url).path)
    data = blob_file(2)
    match = MatchPayload(source=shape_id(data), target=shape_id(data), parameters=QUICK)
    with worker(queue):
        assert ended(queue, validation(queue, data)).state is JobState.SUCCEEDED
        # Marks the directory, as a service does that is asked whether it is ready.
        queue.store.blobs.check_owner()
        elsewhere = root.rename(root.with_name("elsewhere"))
        root.mkdir()  # an empty mount point
        job = queue.submit(match).id
        until(lambda: has_begun(queue, job))
        time.sleep(AWAY)
        root.rmdir()
        elsewhere.rename(root)
        assert ended(queue, job).state is JobState.SUCCEEDED


def has_begun(queue: JobQueue, job_id: str) -> bool:
    record = queue.store.jobs.get(job_id)
    return record is not None and record.state is JobState.RUNNING
