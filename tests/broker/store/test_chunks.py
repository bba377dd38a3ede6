"""The progress of jobs that are done in turns, part by part, in a real Redis."""

import itertools

import numpy as np

from broker.contracts import PAIRS, RESULT, STRUCTURES, SpectrumPayload
from broker.queue import new_job
from broker.store import ClaimStatus, Store


def running(store: Store) -> str:
    """A running job that has parts; what else it is does not matter here."""
    record = new_job(SpectrumPayload(shape="a", eigenpairs=30, largest_component=False))
    with store.client.pipeline() as pipe:
        store.jobs.create(record, pipe)
        store.chunks.create(record.id, pipe)
        pipe.execute()
    assert store.jobs.claim(record.id, "runner")
    return record.id


def fractions(store: Store, job: str, shares: list[float], parts: list[int]) -> list[float]:
    """The job's progress after each stage that is opened, and each part that is done."""
    told: list[float] = []

    def look() -> None:
        record = store.jobs.get(job)
        assert record is not None
        told.append(record.progress.fraction)

    stages = ["", STRUCTURES, PAIRS, RESULT]
    for (before, stage), share, count in zip(
        itertools.pairwise(stages), shares, parts, strict=True
    ):
        assert store.chunks.open_stage(job, before, stage, count, share)
        look()
        while (taken := store.chunks.claim(job, "turn", "runner")).status is ClaimStatus.CLAIMED:
            assert store.chunks.complete(job, taken, b"done", 0.0)
            look()
    return told


def test_progress_runs_neither_back_nor_beyond_its_end(store: Store) -> None:
    rng = np.random.default_rng(1)
    for _ in range(40):
        first, last = rng.uniform(0.0, 0.3), rng.uniform(0.0, 0.1)
        # The sum of the three need not be one once they are rounded.
        shares = [first, 1.0 - last - first, last]
        told = fractions(store, running(store), shares, [int(n) for n in rng.integers(1, 8, 3)])
        assert told == sorted(told)
        assert told[0] >= 0.0
        assert told[-1] <= 1.0
        assert abs(told[-1] - 1.0) < 1e-15
