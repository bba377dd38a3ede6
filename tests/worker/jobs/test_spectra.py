"""Spectra that several processes need at the same time."""

import time

import pytest

from broker.blobs import BlobsAway
from broker.blobs.directory import DirectoryBlobs
from broker.contracts import JobKind, JobState, MatchParameters, MatchPayload, SpectrumKey
from broker.queue import JobQueue
from broker.store import Spectra, Store
from broker.upkeep import store_away
from solver.control import Control
from tests.broker.store.records import accepted, numbered
from tests.solver import shapes
from worker.jobs.runner import Runner
from worker.jobs.spectra import spectrum_of

KEY = SpectrumKey("a", 10)


class Contended(Spectra):
    """Spectra whose lock another process always gets first, for a moment."""

    def lock(self, key: SpectrumKey, holder: str, seconds: float) -> bool:
        """Have the other process lock it."""
        super().lock(key, "another", 0.1)
        return super().lock(key, holder, seconds)


def test_a_spectrum_whose_store_failed_is_queued_once(queue: JobQueue) -> None:
    store = queue.store
    store.check()
    one, other = (accepted(store, numbered(number)).id for number in range(2))
    match = MatchPayload(source=one, target=other, parameters=MatchParameters())
    queue.submit(match)
    spectrum = next(job for job in store.jobs.active() if job.kind is JobKind.SPECTRUM)
    assert isinstance(store.blobs.store, DirectoryBlobs)
    root = store.blobs.store.root
    volume = root.rename(root.with_name("volume"))
    with pytest.raises(BlobsAway):
        Runner(queue, "me", blob_patience=0.0).run(spectrum.id)
    volume.rename(root)
    assert store.jobs.lose(spectrum.id, 3, store_away()) is JobState.QUEUED
    queue.submit(match)
    assert sum(job.kind is JobKind.SPECTRUM for job in store.jobs.active()) == 2


@pytest.mark.parametrize(("cache_bytes", "kept"), [(0, False), (2**30, True)])
def test_what_cannot_be_cached_is_waited_for_once(
    store: Store, cache_bytes: int, kept: bool
) -> None:
    settings = store.settings.model_copy(update={"cache_bytes": cache_bytes})
    spectra = Contended(
        store.client, store.cache, store.blobs, settings, store.keys, store.durability
    )
    deadline = time.monotonic() + 20.0
    waiting = Control(is_cancelled=lambda: time.monotonic() > deadline)
    mesh = shapes.icosphere(1)
    for _ in range(2):
        assert len(spectrum_of(KEY, mesh, spectra, "me", waiting).mass) == mesh.n_vertices
    assert not spectra.locked(KEY)
    assert store.spectra.counts().computed == (1 if kept else 2)
