"""References to blobs: kept, lost, damaged, replaced, and of another installation."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from broker.blobs import BlobLost, BlobsAway, NotMigrated
from broker.blobs.directory import DirectoryBlobs
from broker.store import DEFAULT_KEYS, PREFIX, BlobReference, Blobs, Keys, Store
from broker.store.blobs import referring_key
from tests.broker.upkeep.test_retention import SHAPE, put_shape

KEY = DEFAULT_KEYS.job_arrays("1")
PARTS = st.text("abcdefghijklmnopqrstuvwxyzABCXYZ0189-._", min_size=1, max_size=40)


def files(store: Store) -> list[str]:
    """Paths of all blobs of records."""
    root = store.blobs.store
    assert isinstance(root, DirectoryBlobs)
    found = root.root.glob("*/*")
    return sorted(str(path.relative_to(root.root)) for path in found if path.parent.name != "owner")


def damage(store: Store, data: bytes) -> None:
    root = store.blobs.store
    assert isinstance(root, DirectoryBlobs)
    (path,) = files(store)
    (root.root / path).write_bytes(data)


@given(st.lists(PARTS, min_size=1, max_size=5), st.integers(0, 2**128 - 1))
def test_the_path_of_a_blob_names_its_reference(parts: list[str], number: int) -> None:
    key = PREFIX + ":".join(parts)
    reference = BlobReference(f"{number:032x}", 1, "0" * 64)
    path = reference.path(key)
    assert referring_key(path) == (key, reference.token)
    assert path.count("/") == 1
    assert BlobReference.read(str(reference)) == reference


@pytest.mark.parametrize("name", ["", "a/b", "a!b", "..\\x", "a b", "ä"])
def test_keys_that_are_no_paths_are_refused(store: Store, name: str) -> None:
    with pytest.raises(ValueError, match="no blob can be kept"):
        store.blobs.put(PREFIX + name, b"data")
    assert files(store) == []


def test_bytes_are_kept_apart_from_their_record(store: Store) -> None:
    data = bytes(100_000)
    store.blobs.save(KEY, data, 100)
    assert store.blobs.get(KEY) == data
    file = store.blobs.open(KEY)
    assert file is not None
    with file:
        assert file.read() == data
    assert 0 < store.client.ttl(KEY) <= 100
    assert int(store.client.memory_usage(KEY) or 0) < 500
    assert store.blobs.get(DEFAULT_KEYS.job_arrays("2")) is None
    assert store.blobs.open(DEFAULT_KEYS.job_arrays("2")) is None


def test_what_is_replaced_is_deleted(store: Store) -> None:
    store.blobs.save(KEY, b"first", 100)
    (first,) = files(store)
    store.blobs.save(KEY, b"second", 100)
    (second,) = files(store)
    assert first != second
    assert store.blobs.get(KEY) == b"second"


@pytest.mark.parametrize("data", [b"", b"conten", b"contents", b"CONTENT"])
def test_damaged_bytes_are_never_returned(store: Store, data: bytes) -> None:
    store.blobs.save(KEY, b"content", 100)
    damage(store, data)
    for read in (store.blobs.get, store.blobs.open):
        with pytest.raises(BlobLost, match="damaged"):
            read(KEY)


def test_missing_bytes_are_told_from_a_missing_record(store: Store) -> None:
    store.blobs.save(KEY, b"content", 100)
    assert isinstance(store.blobs.store, DirectoryBlobs)
    (store.blobs.store.root / files(store)[0]).unlink()
    for read in (store.blobs.get, store.blobs.open):
        with pytest.raises(BlobLost, match="missing"):
            read(KEY)


def test_what_is_lost_is_seen_without_reading_it(store: Store) -> None:
    assert isinstance(store.blobs.store, DirectoryBlobs)
    store.blobs.save(KEY, b"content", 100)
    assert not store.blobs.lost([KEY])
    damage(store, b"conten")
    assert store.blobs.lost([KEY])
    (store.blobs.store.root / files(store)[0]).unlink()
    assert store.blobs.lost([KEY])
    store.client.delete(KEY)
    assert not store.blobs.lost([KEY])
    store.client.set(KEY, b"bytes of an earlier version")
    assert not store.blobs.lost([KEY])


def test_nothing_is_lost_where_the_directory_is_not_mounted(store: Store) -> None:
    store.blobs.check()
    store.blobs.save(KEY, b"content", 100)
    assert isinstance(store.blobs.store, DirectoryBlobs)
    root = store.blobs.store.root
    volume = root.rename(root.with_name("volume"))
    root.mkdir()
    for read in (store.blobs.get, store.blobs.open, lambda key: store.blobs.lost([key])):
        with pytest.raises(BlobsAway, match="is empty"):
            read(KEY)
    root.rmdir()
    volume.rename(root)
    assert store.blobs.get(KEY) == b"content"


class DeletedMeanwhile(DirectoryBlobs):
    """Blobs whose record somebody deletes, or replaces, between their reference and the bytes."""

    def read(self, path: str) -> bytes:
        """Delete the record, and then the blob, as others do."""
        blobs, again = MEANWHILE.pop() if MEANWHILE else (None, False)
        if blobs is not None and again:
            blobs.save(KEY, b"newer", 100)
        elif blobs is not None:
            blobs.client.delete(KEY)
            self.delete(path)
        return super().read(path)


MEANWHILE: list[tuple[Blobs, bool]] = []


@pytest.mark.parametrize(("again", "read"), [(False, None), (True, b"newer")])
def test_what_is_deleted_or_replaced_meanwhile_is_not_lost(
    store: Store, again: bool, read: bytes | None
) -> None:
    assert isinstance(store.blobs.store, DirectoryBlobs)
    store.blobs.save(KEY, b"content", 100)
    reading = Blobs(store.client, DeletedMeanwhile(store.blobs.store.root))
    MEANWHILE.append((store.blobs, again))
    assert reading.get(KEY) == read


def test_a_shape_that_is_deleted_leaves_no_bytes(store: Store) -> None:
    put_shape(store)
    assert len(files(store)) == 3, "the upload, the mesh and the geometry; no candidate"
    assert store.shapes.delete(SHAPE)
    assert files(store) == []


def test_a_result_of_a_job_that_was_taken_away_leaves_no_bytes(store: Store) -> None:
    put_shape(store)
    kept = files(store)
    (job,) = [record.id for record in store.jobs.active()]
    assert store.jobs.claim(job, "runner")
    assert not store.jobs.succeed(job, "another runner", b"{}")
    assert files(store) == kept
    assert store.results.document(job) is None
    assert store.jobs.succeed(job, "runner", b"{}")
    assert len(files(store)) == len(kept) + 1


def test_bytes_of_an_earlier_version_are_told(store: Store) -> None:
    put_shape(store)
    store.client.set(DEFAULT_KEYS.shape_mesh(SHAPE), b"mesh")
    store.client.set(KEY, b"arrays")
    for read in (store.shapes.mesh, store.results.arrays, store.results.open_arrays):
        with pytest.raises(NotMigrated, match=r"broker\.migrate"):
            read(SHAPE if read == store.shapes.mesh else "1")
    store.blobs.save(KEY, b"new arrays", 100)
    assert store.results.arrays("1") == b"new arrays"
    assert store.shapes.delete(SHAPE)
    assert not store.client.exists(DEFAULT_KEYS.shape_mesh(SHAPE))


def test_a_blob_store_belongs_to_one_redis(store: Store) -> None:
    for _ in range(2):
        store.check()
    store.client.delete(Keys.BLOB_OWNER)
    with pytest.raises(BlobsAway, match="belongs to another Redis"):
        store.check()


def test_a_blob_store_that_was_exchanged_is_told(store: Store) -> None:
    store.check()
    assert isinstance(store.blobs.store, DirectoryBlobs)
    root = store.blobs.store.root
    root.rename(root.with_name("elsewhere"))
    with pytest.raises(BlobsAway, match="is empty"):
        store.check()


def test_a_mark_that_was_interrupted_is_set_again(store: Store) -> None:
    """The process is killed after it has written the mark, and before Redis knows."""
    store.check()
    store.client.hdel(Keys.BLOB_OWNER, "marked")
    store.check()
    assert store.client.hexists(Keys.BLOB_OWNER, "marked")
