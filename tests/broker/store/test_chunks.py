"""Jobs that are done in time slices, chunk by chunk, in a real Redis."""

import itertools

import numpy as np

from broker.contracts import PAIRS, RESULT, STRUCTURES, SpectrumPayload
from broker.queue import new_job
from broker.store import ClaimStatus, Store


def running(store: Store) -> str:
    """A running job with chunks, of any kind."""
    record = new_job(SpectrumPayload(shape="a", eigenpairs=30, largest_component=False))
    with store.client.pipeline() as pipe:
        store.jobs.create(record, pipe)
        store.chunks.create(record.id, pipe)
        pipe.execute()
    assert store.jobs.claim(record.id, "runner")
    return record.id


def fractions(store: Store, job: str, shares: list[float], chunks: list[int]) -> list[float]:
    """The job's progress after each opened stage and each completed chunk."""
    progress: list[float] = []

    def look() -> None:
        record = store.jobs.get(job)
        assert record is not None
        progress.append(record.progress.fraction)

    stages = ["", STRUCTURES, PAIRS, RESULT]
    for (before, stage), share, count in zip(
        itertools.pairwise(stages), shares, chunks, strict=True
    ):
        assert store.chunks.open_stage(job, before, stage, count, share)
        look()
        while (chunk := store.chunks.claim(job, "slice", "runner")).status is ClaimStatus.CLAIMED:
            assert store.chunks.complete(job, chunk, b"done", 0.0)
            look()
    return progress


def test_progress_never_decreases_nor_exceeds_one(store: Store) -> None:
    rng = np.random.default_rng(1)
    for _ in range(40):
        first, last = rng.uniform(0.0, 0.3), rng.uniform(0.0, 0.1)
        # The sum of the three need not be one once they are rounded.
        shares = [first, 1.0 - last - first, last]
        progress = fractions(store, running(store), shares, [int(n) for n in rng.integers(1, 8, 3)])
        assert progress == sorted(progress)
        assert progress[0] >= 0.0
        assert progress[-1] <= 1.0
        assert abs(progress[-1] - 1.0) < 1e-15


def test_a_late_time_slice_changes_nothing_of_a_stage_that_is_open(store: Store) -> None:
    """It was given up as lost, and another had opened the stage since."""
    job = running(store)
    assert store.chunks.open_stage(job, "", STRUCTURES, 3, 0.5, known={2: b"known"})
    first = store.chunks.claim(job, "slice", "runner")
    late = {0: b"late", 1: b"late"}
    assert not store.chunks.open_stage(job, "", STRUCTURES, 3, 0.5, known=late)
    assert store.chunks.results(job, STRUCTURES) == {2: b"known"}
    assert store.chunks.complete(job, first, b"first", 0.0)
    second = store.chunks.claim(job, "slice", "runner")
    assert {first.number, second.number} == {0, 1}
    assert store.chunks.complete(job, second, b"second", 0.0)
    assert store.chunks.claim(job, "slice", "runner").status is ClaimStatus.DONE
