"""Tenants before one real worker: whose job is next."""

from broker.contracts import JobRecord
from broker.queue import JobQueue
from tests.worker.figures import blob_file
from tests.workers import ended, validation, worker

MANY = 12


def test_many_jobs_of_one_tenant_do_not_keep_another_waiting(queue: JobQueue) -> None:
    blue, red = queue.of("blue"), queue.of("red")
    theirs = [validation(blue, blob_file(2, seed)) for seed in range(MANY)]
    mine = validation(red, blob_file(2, 0))
    assert red.rq.position(record(red, mine)) == 1
    with worker(queue):
        began = {job: ended(blue, job).started for job in theirs} | {mine: ended(red, mine).started}
    order = sorted(began, key=lambda job: str(began[job]))
    assert order == [theirs[0], mine, *theirs[1:]]


def record(queue: JobQueue, job: str) -> JobRecord:
    found = queue.store.jobs.get(job)
    assert found is not None
    return found
