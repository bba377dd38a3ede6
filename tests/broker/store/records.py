"""Jobs and shapes in a store, and what it was asked."""

from datetime import timedelta

from broker.contracts import JobRecord, MatchParameters, MatchPayload, ShapeRecord
from broker.queue import new_job
from broker.store import Jobs, Store
from tests.worker.records import CREATED, shape_record


def match_job() -> JobRecord:
    return new_job(MatchPayload(source="a", target="b", parameters=MatchParameters()))


def stored(jobs: Jobs, record: JobRecord | None = None) -> str:
    record = record or match_job()
    with jobs.client.pipeline() as pipe:
        jobs.create(record, pipe)
        pipe.execute()
    return record.id


def running(jobs: Jobs, runner: str = "r") -> str:
    job = stored(jobs)
    assert jobs.claim(job, runner)
    return job


def calls(store: Store, command: str) -> int:
    return int(store.client.info("commandstats").get(f"cmdstat_{command}", {"calls": 0})["calls"])


def numbered(number: int, **after: float) -> ShapeRecord:
    """A shape, made some time after the first."""
    return shape_record(f"{number:032x}", created=CREATED + timedelta(**after))


def accepted(store: Store, record: ShapeRecord) -> ShapeRecord:
    stored = store.uploads.put_candidate(record.id, "off", b"data", "job")
    with store.client.pipeline() as pipe:
        store.uploads.add_candidate(record.id, "off", stored, "job", pipe)
        pipe.execute()
    store.shapes.accept(record, b"data", b"mesh", b"geometry", "job")
    return record
