"""What calls cost Redis: commands and round trips that do not grow with what others keep."""

from broker.contracts import JobState, MatchParameters, MatchPayload
from broker.queue import JobQueue
from broker.store import DEFAULT_KEYS, Store
from tests.broker.store.test_store import accepted, numbered

PARAMETERS = MatchParameters()


def calls(store: Store, command: str) -> int:
    return int(store.client.info("commandstats").get(f"cmdstat_{command}", {"calls": 0})["calls"])


def test_results_are_deleted_in_one_pass_over_what_is_kept(store: Store) -> None:
    entries = {DEFAULT_KEYS.job_picture(f"other{number}"): 1.0 for number in range(5000)}
    jobs = [f"job{number}" for number in range(20)]
    pictures = [DEFAULT_KEYS.job_picture(job, "png") for job in jobs]
    for job, picture in zip(jobs, pictures, strict=True):
        store.blobs.save(DEFAULT_KEYS.job_arrays(job), b"arrays", 1000)
        store.blobs.save(picture, b"picture", 1000)
    store.client.zadd(DEFAULT_KEYS.held, entries)
    before = calls(store, "zscan")
    assert store.results.delete(*jobs)
    assert calls(store, "zscan") - before < len(jobs)
    assert store.client.exists(*pictures) == 0
    assert store.client.zcard(DEFAULT_KEYS.held) == len(entries)
    assert not store.results.delete(*jobs)


def test_a_cancelled_job_reads_only_jobs_of_its_shapes(queue: JobQueue) -> None:
    store = queue.store
    shapes = [accepted(store, numbered(number)).id for number in range(4)]
    mine = MatchPayload(source=shapes[0], target=shapes[1], parameters=PARAMETERS)
    others = MatchPayload(source=shapes[2], target=shapes[3], parameters=PARAMETERS)
    for _ in range(50):
        queue.submit(others)
    kept, cancelled = (queue.submit(mine) for _ in range(2))
    before = calls(store, "hgetall")
    queue.cancel(cancelled.id)
    assert calls(store, "hgetall") - before < 50
    assert store.jobs.state(cancelled.id) is JobState.CANCELLED
    assert queue.spectra_ahead(kept) == 2


def test_shapes_are_used_in_one_round_trip(store: Store) -> None:
    shapes = [accepted(store, numbered(number)).id for number in range(50)]
    before = store.client.info("stats")["total_reads_processed"]
    found = store.shapes.use_all([*shapes, "unknown"])
    assert [None if one is None else one.id for one in found] == [*shapes, None]
    assert store.client.info("stats")["total_reads_processed"] - before < 10
