"""What calls cost Redis: commands and round trips that do not grow with what others keep."""

from broker.contracts import (
    BatchPayload,
    DissimilaritiesPayload,
    DissimilarityParameters,
    JobState,
    MatchParameters,
    MatchPayload,
    PicturePayload,
)
from broker.queue import JobQueue
from broker.store import DEFAULT_KEYS, Store
from broker.upkeep import recover
from tests.broker.store.records import accepted, calls, numbered

PARAMETERS = MatchParameters()


def commands(store: Store) -> int:
    """Number of commands so far, those of scripts too."""
    return sum(one["calls"] for one in store.client.info("commandstats").values())


def test_results_are_deleted_without_a_look_at_what_else_is_kept(store: Store) -> None:
    jobs = [f"job{number}" for number in range(20)]
    pictures = [PicturePayload(job=job, view=view) for job in jobs for view in ("front", "left")]
    for job in jobs:
        store.blobs.save(DEFAULT_KEYS.job_result(job), b"result", 1000)
    for picture in pictures:
        store.results.set_picture(picture, b"picture")
    entries = {DEFAULT_KEYS.job_picture(f"other{number}"): 1.0 for number in range(5000)}
    store.client.zadd(DEFAULT_KEYS.held, entries)
    before = calls(store, "zscan")
    assert store.results.delete(*jobs)
    assert calls(store, "zscan") == before
    assert not store.client.keys(DEFAULT_KEYS.job("job*"))
    assert store.client.zcard(DEFAULT_KEYS.held) == len(entries)
    assert not store.results.delete(*jobs)


def test_a_picture_of_an_earlier_version_is_not_shown_without_its_result(store: Store) -> None:
    picture = PicturePayload(job="job")
    store.blobs.save(DEFAULT_KEYS.job_result("job"), b"result", 1000)
    store.blobs.save(DEFAULT_KEYS.job_picture("job"), b"picture", 1000)
    assert store.results.picture(picture) == b"picture"
    assert store.results.delete("job")
    assert store.results.picture(picture) is None
    assert store.results.open_picture(picture) is None
    assert 0 < store.client.ttl(DEFAULT_KEYS.job_picture("job")) <= 1000


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


def test_what_a_match_of_a_batch_costs_does_not_grow_with_the_batch(queue: JobQueue) -> None:
    store, count = queue.store, 1000
    payload = BatchPayload(
        source="a", targets=("b",) * count, target_names=(None,) * count, parameters=PARAMETERS
    )
    batch = queue.submit(payload)
    for place in range(1, 101):
        match = f"{batch.id}-{place}"
        assert store.jobs.claim(match, "me")
        assert queue.batches.begin(batch.id)
        assert store.jobs.succeed(match, "me", b"{}")
        before = commands(store)
        queue.batches.advance(batch.id)
    # With those that RQ sends for the next match.
    assert commands(store) - before < 100
    before = commands(store)
    recover(queue)
    running = store.jobs.get(batch.id)
    assert running is not None
    assert queue.giving_way([running]) == {batch.id}
    assert commands(store) - before < 100
    assert running.progress.stage == "100 of 1000 matches"
    assert store.jobs.claim(f"{batch.id}-101", "me")
    assert queue.giving_way([running]) == set()


def test_running_comparisons_are_looked_at_together(queue: JobQueue) -> None:
    store, jobs = queue.store, []
    for _ in range(20):
        payload = DissimilaritiesPayload(
            shapes=("a", "b"), labels=("a", "b"), parameters=DissimilarityParameters()
        )
        job = queue.submit(payload)
        assert store.jobs.claim(job.id, job.id)
        for _ in range(4):
            queue.submit_time_slice(job)
        jobs.append(job.model_copy(update={"state": JobState.RUNNING}))
    running = jobs[7].id
    assert store.jobs.claim(f"{running}-3", "me")
    before = store.client.info("stats")["total_reads_processed"]
    assert queue.giving_way(jobs) == {one.id for one in jobs} - {running}
    assert queue.other_jobs_wait(running)
    assert store.client.info("stats")["total_reads_processed"] - before < 10


def test_shapes_are_used_in_one_round_trip(store: Store) -> None:
    shapes = [accepted(store, numbered(number)).id for number in range(50)]
    before = store.client.info("stats")["total_reads_processed"]
    found = store.shapes.use_all([*shapes, "unknown"])
    assert [None if one is None else one.id for one in found] == [*shapes, None]
    assert store.client.info("stats")["total_reads_processed"] - before < 10
