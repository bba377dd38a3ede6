"""The sweep deletes blobs that no reference names, and no others."""

import os
import time
from pathlib import Path

import pytest

from broker.blobs import BlobsAway
from broker.blobs.directory import DirectoryBlobs
from broker.store import DEFAULT_KEYS, FOLDERS, Store
from broker.upkeep import OrphanSweep
from broker.upkeep.orphans import SAFE_AGE

ROUNDS = len(FOLDERS) + 1


def root(store: Store) -> Path:
    assert isinstance(store.blobs.store, DirectoryBlobs)
    return store.blobs.store.root


def blobs_of(store: Store) -> set[Path]:
    return {path for path in root(store).glob("*/*") if path.parent.name != "owner"}


def make_old(store: Store) -> None:
    old = time.time() - SAFE_AGE - 60
    for path in blobs_of(store):
        os.utime(path, (old, old))


def sweep(store: Store) -> int:
    """Sweep every folder once."""
    return sum(OrphanSweep(store).step() for _ in range(ROUNDS))


def fill(store: Store, names: range) -> None:
    for number in names:
        store.blobs.save(DEFAULT_KEYS.job_arrays(f"{number}"), bytes([number]), 1000)


def test_what_is_referred_to_stays(store: Store) -> None:
    fill(store, range(50))
    make_old(store)
    assert sweep(store) == 0
    assert [store.results.arrays(f"{number}") for number in range(50)] == [
        bytes([number]) for number in range(50)
    ]


def test_blobs_expire_with_their_references(store: Store) -> None:
    fill(store, range(30))
    make_old(store)
    for number in range(20):
        store.client.delete(DEFAULT_KEYS.job_arrays(f"{number}"))
    assert sweep(store) == 20
    assert len(blobs_of(store)) == 10
    assert store.results.arrays("25") == bytes([25])


def test_a_blob_waits_for_its_reference(store: Store) -> None:
    """An upload at the same time has written its bytes, and not yet its record."""
    reference = store.blobs.put(DEFAULT_KEYS.job_arrays("1"), b"arrays")
    assert sweep(store) == 0
    with store.client.pipeline() as pipe:
        store.blobs.link(DEFAULT_KEYS.job_arrays("1"), reference, pipe)
        pipe.execute()
    make_old(store)
    assert sweep(store) == 0
    assert store.results.arrays("1") == b"arrays"


def test_what_was_replaced_or_left_unfinished_is_deleted(store: Store) -> None:
    store.blobs.put(DEFAULT_KEYS.job_arrays("1"), b"of a run that was killed")
    fill(store, range(1, 2))
    (root(store) / "00").mkdir(exist_ok=True)
    (root(store) / "00" / "job!1!arrays!00.part").write_bytes(b"half")
    (root(store) / "probe").mkdir(exist_ok=True)
    (root(store) / "probe" / "of-a-check").write_bytes(b"")
    make_old(store)
    assert sweep(store) == 3
    assert store.results.arrays("1") == bytes([1])
    assert len(blobs_of(store)) == 1


def test_one_step_deletes_so_many(store: Store, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("broker.upkeep.orphans.MOST_DELETED", 3)
    monkeypatch.setattr("broker.upkeep.orphans._SWEPT", ("probe",))
    for number in range(7):
        store.blobs.store.put(f"probe/{number}", b"")
    make_old(store)
    assert [OrphanSweep(store).step() for _ in range(4)] == [3, 3, 1, 0]


def test_blobs_of_another_redis_stay(store: Store) -> None:
    """A Redis that has lost its data names no blob: that is no reason to delete them all."""
    fill(store, range(10))
    assert sweep(store) == 0
    make_old(store)
    store.client.flushdb()
    with pytest.raises(BlobsAway, match="another Redis"):
        sweep(store)
    assert len(blobs_of(store)) == 10
