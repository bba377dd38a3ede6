"""Prototypes in contracts and stores: what the solver says, and versions that are never reused."""

from datetime import UTC, datetime

import numpy as np

from broker.contracts import PrototypeRecord, PrototypeStructures
from broker.store import DEFAULT_KEYS, Keys, Store, text
from solver.mesh import triangle_mesh
from solver.prototype import ExampleSurface
from solver.shape.laplacian import Spectrum, laplace_beltrami_spectrum
from tests.broker.upkeep.test_retention import TRACE, TTL
from tests.worker.figures import blob
from worker.jobs.spectra import surface_spectra
from worker.settings import WorkerSettings


def record(name: str, label: str) -> PrototypeRecord:
    return PrototypeRecord(
        id=f"p-{label}",
        name=name,
        version=1,
        bytes=1,
        points=3,
        components=1,
        examples=2,
        parameters=PrototypeStructures(),
        learned_from=None,
        reference=None,
        warnings=(),
        created=datetime.now(UTC),
    )


def test_versions_are_counted_by_name_and_never_reused(store: Store) -> None:
    prototypes = store.prototypes
    stored = [prototypes.add(record("a", label), b"x", b"y") for label in ("1", "2")]
    assert [one.version for one in stored] == [1, 2]
    assert prototypes.add(record("b", "2"), b"x", b"y") == stored[1]
    assert prototypes.add(record("b", "3"), b"x", b"y").version == 1
    assert prototypes.delete("p-2")
    assert not prototypes.delete("p-2")
    assert not prototypes.expired("p-2")
    assert prototypes.add(record("a", "4"), b"x", b"y").version == 3
    assert [one.id for one in prototypes.page(10, None, "a").items] == ["p-4", "p-1"]
    assert len(prototypes.page(10, None).items) == 3


def test_an_archive_that_is_lost_is_restored_to_its_version(store: Store) -> None:
    prototypes = store.prototypes
    first = prototypes.add(record("a", "1"), b"archive", b"geometry")
    assert prototypes.add(record("a", "2"), b"archive", b"geometry").version == 2
    reference = store.blobs.reference(DEFAULT_KEYS.prototype_archive("p-1"))
    store.blobs.discard([(DEFAULT_KEYS.prototype_archive("p-1"), reference)])
    assert prototypes.lost("p-1")
    assert prototypes.add(record("a", "1"), b"archive", b"geometry") == first
    assert prototypes.archive("p-1") == b"archive"
    assert prototypes.add(record("a", "3"), b"archive", b"geometry").version == 3


def cached(store: Store) -> list[str]:
    """Names of what is in the cache."""
    prefix = Keys.cached_spectrum("")
    return [text(key).removeprefix(prefix) for key in store.client.scan_iter(f"{prefix}*")]


def test_spectra_of_surfaces_are_computed_once_for_each_prototype(store: Store) -> None:
    """What is cached and cannot be read, or is of something else, is computed again."""
    mesh = triangle_mesh(*blob(1))
    surfaces = [
        ExampleSurface(mesh.vertices, mesh.faces, np.arange(3), np.ones(19)) for _ in range(2)
    ]
    usual = laplace_beltrami_spectrum(mesh, 5)
    computed: list[tuple[str, int]] = []

    def found(prototype: str, place: int) -> Spectrum:
        def compute() -> Spectrum:
            computed.append((prototype, place))
            return usual

        return surface_spectra(prototype, surfaces, store.spectra)(surfaces[place], compute)

    asked = [("p-1", 0), ("p-1", 1), ("p-2", 0)]
    for one in (*asked, *asked):
        np.testing.assert_array_equal(found(*one).eigenfunctions, usual.eigenfunctions)
    assert computed == asked
    assert len(cached(store)) == len(asked)
    store.spectra.drop("p-1")
    (left,) = cached(store)
    assert left.startswith("p-2:")
    other = laplace_beltrami_spectrum(triangle_mesh(*blob(2)), 5)
    for wrong in (b"nothing", other.to_bytes()):
        store.spectra.put(left, wrong)
        found("p-2", 0)
    assert computed == [*asked, ("p-2", 0), ("p-2", 0)]


def test_what_belongs_to_a_name_outlives_what_has_it(
    store: Store, settings: WorkerSettings
) -> None:
    changed = settings.model_copy(update={"shape_ttl": TTL, "trace_ttl": TRACE})
    prototypes = Store.over(store.client, changed, retry_seconds=1).prototypes
    prototypes.add(record("a", "1"), b"archive", b"geometry")
    kept = (
        DEFAULT_KEYS.prototype("p-1"),
        DEFAULT_KEYS.prototype_archive("p-1"),
        DEFAULT_KEYS.prototype_geometry("p-1"),
    )
    longer = (
        DEFAULT_KEYS.prototype_tombstone("p-1"),
        DEFAULT_KEYS.prototypes_named("a"),
        DEFAULT_KEYS.prototype_versions("a"),
    )
    for use in (prototypes.use, prototypes.open_archive, prototypes.open_geometry):
        for key in (*kept, *longer):
            store.client.expire(key, 10)
        assert prototypes.get("p-1") is not None
        assert store.client.ttl(kept[0]) <= 10
        found = use("p-1")
        assert found is not None
        if not isinstance(found, PrototypeRecord):
            found.close()
        assert all(TTL - 100 <= store.client.ttl(key) <= TTL for key in kept)
        assert all(store.client.ttl(key) >= TTL + TRACE - 100 for key in longer)
