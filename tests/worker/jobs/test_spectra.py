"""Spectra that several processes need at the same time."""

import time

import pytest

from broker.contracts import SpectrumKey
from broker.store import Spectra, Store
from solver.control import Control
from tests.solver import shapes
from worker.jobs.spectra import spectrum_of

KEY = SpectrumKey("a", 10)


class Contended(Spectra):
    """Spectra whose lock another process always gets first, for a moment."""

    def lock(self, key: SpectrumKey, holder: str, seconds: float) -> bool:
        """Have the other process lock it."""
        super().lock(key, "another", 0.1)
        return super().lock(key, holder, seconds)


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
