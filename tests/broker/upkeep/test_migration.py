"""Migration of the layout that kept all bytes in Redis."""

import gzip
import os
import subprocess
import sys
from typing import BinaryIO

import pytest

from broker.blobs import BlobsFull
from broker.blobs.directory import DirectoryBlobs
from broker.contracts import (
    PicturePayload,
    ValidationPayload,
    attributes_id,
)
from broker.queue import JobQueue
from broker.store import DEFAULT_KEYS, Keys, Store
from broker.upkeep import Migrated, migrate
from tests.worker.records import shape_record
from worker.settings import WorkerSettings

SHAPE, PROTOTYPE, FILE = "a" * 32, "p-" + "b" * 32, attributes_id(b"file")
PICTURE = PicturePayload(job="1", format="glb", specimen=3)
BYTES = {
    DEFAULT_KEYS.shape_upload(SHAPE): b"upload",
    DEFAULT_KEYS.shape_mesh(SHAPE): b"mesh",
    DEFAULT_KEYS.shape_geometry(SHAPE): b"",
    DEFAULT_KEYS.prototype_archive(PROTOTYPE): b"archive",
    DEFAULT_KEYS.prototype_geometry(PROTOTYPE): b"points",
    DEFAULT_KEYS.attributes_file(FILE): b"file",
    DEFAULT_KEYS.candidate(SHAPE, "off", "job-of-it"): b"candidate",
    DEFAULT_KEYS.job_result("1"): gzip.compress(b"{}"),
    DEFAULT_KEYS.job_result("1-0"): b"of a batch",
    DEFAULT_KEYS.job_arrays("1"): b"arrays",
    DEFAULT_KEYS.job_picture("1"): b"picture",
    DEFAULT_KEYS.job_picture("1", PICTURE.variant): b"variant",
}
"""What the earlier layout kept, by its keys."""

OTHERS = {
    DEFAULT_KEYS.shape(SHAPE): shape_record(SHAPE).model_dump_json().encode(),
    DEFAULT_KEYS.shape_tombstone(SHAPE): b"",
    DEFAULT_KEYS.prototype_versions("x"): b"3",
    DEFAULT_KEYS.candidate_job(SHAPE, "off"): b"job-of-it",
    DEFAULT_KEYS.picture_job("1"): b"job",
    DEFAULT_KEYS.picture_job("1", PICTURE.variant): b"job",
    DEFAULT_KEYS.job_summary("1"): b"{}",
    DEFAULT_KEYS.job_tombstone("1"): b"",
    DEFAULT_KEYS.deferred(SHAPE): b"job",
    Keys.cached_spectrum(f"{SHAPE}:10"): b"spectrum",
    "rq:job:1": b"of RQ",
}
"""What stays as it is."""


@pytest.fixture
def earlier(store: Store) -> Store:
    """A store as an earlier version left it."""
    for key, data in (BYTES | OTHERS).items():
        store.client.set(key, data, ex=1000)
    store.client.persist(DEFAULT_KEYS.shape_mesh(SHAPE))
    return store


def kept(store: Store) -> dict[str, bytes | None]:
    return {key: store.blobs.get(key) for key in BYTES}


def test_everything_is_readable_afterwards(earlier: Store) -> None:
    assert migrate(earlier) == Migrated(len(BYTES), sum(map(len, BYTES.values())))
    assert kept(earlier) == BYTES
    assert {key: earlier.client.get(key) for key in OTHERS} == OTHERS
    assert earlier.shapes.upload(SHAPE) == b"upload"
    assert earlier.prototypes.archive(PROTOTYPE) == b"archive"
    assert earlier.attributes.file(FILE) == b"file"
    assert earlier.uploads.candidate(SHAPE, "off", "job-of-it") == b"candidate"
    assert earlier.results.picture(PICTURE) == b"variant"


def test_what_was_to_expire_still_does(earlier: Store) -> None:
    migrate(earlier)
    for key in BYTES:
        if key != DEFAULT_KEYS.shape_mesh(SHAPE) and not key.startswith(DEFAULT_KEYS.shape("")):
            assert 0 < earlier.client.ttl(key) <= 1000
    assert earlier.client.ttl(DEFAULT_KEYS.shape_mesh(SHAPE)) == -1


def test_it_can_be_repeated(earlier: Store) -> None:
    migrate(earlier)
    references = {key: earlier.client.hgetall(key) for key in BYTES}
    assert migrate(earlier) == Migrated(0, 0)
    assert {key: earlier.client.hgetall(key) for key in BYTES} == references


class Filling(DirectoryBlobs):
    """A disk that is full after three blobs; files of checks do not count."""

    taken = 0

    def put(self, path: str, data: bytes | BinaryIO) -> None:
        """Store the first three."""
        if "!" in path:
            type(self).taken += 1
        if type(self).taken > 3:
            raise BlobsFull("full")
        super().put(path, data)


def test_it_goes_on_after_an_interruption(earlier: Store) -> None:
    assert isinstance(earlier.blobs.store, DirectoryBlobs)
    roomy = earlier.blobs.store
    object.__setattr__(earlier.blobs, "store", Filling(roomy.root))
    with pytest.raises(BlobsFull):
        migrate(earlier)
    object.__setattr__(earlier.blobs, "store", roomy)
    assert migrate(earlier).values == len(BYTES) - 3
    assert kept(earlier) == BYTES


def test_the_command(earlier: Store, settings: WorkerSettings) -> None:
    assert settings.redis_url is not None
    assert settings.blob_url is not None

    def run(**stores: str) -> subprocess.CompletedProcess[str]:
        command = [sys.executable, "-m", "broker.migrate"]
        return subprocess.run(
            command, env={**os.environ, **stores}, capture_output=True, text=True, check=False
        )

    stores = {"ISOMATCH_REDIS_URL": settings.redis_url, "ISOMATCH_BLOB_URL": settings.blob_url}
    moved = run(**stores)
    assert (moved.returncode, moved.stdout[:9]) == (0, f"moved {len(BYTES)} "), moved.stderr
    assert kept(earlier) == BYTES
    refused = run(**stores | {"ISOMATCH_BLOB_URL": ""})
    assert (refused.returncode, refused.stderr) == (1, "migrate: ISOMATCH_BLOB_URL is not set\n")
    assert run(**stores | {"ISOMATCH_BLOB_URL": "elsewhere"}).returncode == 2


def test_a_job_that_was_queued_before_is_validated_afterwards(queue: JobQueue) -> None:
    store = queue.store
    job = queue.submit_validation(
        ValidationPayload(shape=SHAPE, name="x", file_type="off"), b"data"
    )
    key = DEFAULT_KEYS.candidate(SHAPE, "off", job)
    store.client.delete(key)
    store.client.set(key, b"data", ex=100)
    migrate(store)
    assert store.uploads.candidate(SHAPE, "off", job) == b"data"
