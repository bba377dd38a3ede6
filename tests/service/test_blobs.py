"""A blob store that is away, full, or has lost something, over HTTP."""

from collections.abc import Callable
from pathlib import Path
from tempfile import SpooledTemporaryFile

import httpx2
import pytest

from broker.blobs.directory import DirectoryBlobs
from broker.contracts import shape_id
from broker.queue import JobQueue, QueueSettings
from broker.store import DEFAULT_KEYS, PREFIX, Shapes, Store
from service.settings import Settings
from service.standalone import EmbeddedServer
from tests.blobs import blob_url
from tests.service.conftest import (
    PATIENCE,
    Api,
    Json,
    empty_database,
    idle_api,
    problem,
    served_api,
)
from tests.worker.figures import blob_file
from worker.jobs.runner import Runner

QUICK = {"points": 3, "orientation": False}


def path_of(store: Store, key: str) -> Path:
    """Where the bytes of a key are."""
    assert isinstance(store.blobs.store, DirectoryBlobs)
    name = key.removeprefix(PREFIX).replace(":", "!")
    (found,) = store.blobs.store.root.glob(f"*/{name}!*")
    return found


def test_a_mesh_is_sent_in_pieces(http: httpx2.Client, upload: Callable[..., Json]) -> None:
    data = blob_file(3, seed=5) + b"# and more\n" * 150_000
    shape = upload(data)["id"]
    with http.stream("GET", f"/v1/shapes/{shape}/mesh") as answer:
        assert answer.headers["content-length"] == str(len(data))
        assert b"".join(answer.iter_bytes()) == data
    assert http.head(f"/v1/shapes/{shape}/mesh").headers["content-length"] == str(len(data))


def test_an_upload_is_stored_in_pieces(
    server: EmbeddedServer, monkeypatch: pytest.MonkeyPatch
) -> None:
    read = SpooledTemporaryFile.read

    def some(file: SpooledTemporaryFile[bytes], size: int = -1) -> bytes:
        assert size >= 0, "the upload is not read as a whole"
        return read(file, size)

    monkeypatch.setattr(SpooledTemporaryFile, "read", some)
    data = blob_file(2, seed=6) + b"#" * 2 * 1024**2
    with (
        idle_api(server, validation_wait=0) as api,
        httpx2.Client(base_url=api.url, timeout=60.0) as http,
    ):
        answer = http.post("/v1/shapes", files={"file": ("a.off", data)})
        assert answer.status_code == 202, answer.text
        job = answer.json()["id"]
        assert api.store.uploads.candidate(shape_id(data), "off", job) == data


@pytest.mark.parametrize("harm", ["missing", "damaged"])
def test_lost_content_is_told(
    api: Api, http: httpx2.Client, upload: Callable[..., Json], harm: str
) -> None:
    data = blob_file(2, seed=300 + len(harm))
    shape = upload(data)["id"]
    for key, address in (
        (DEFAULT_KEYS.shape_upload(shape), f"/v1/shapes/{shape}/mesh"),
        (DEFAULT_KEYS.shape_geometry(shape), f"/v1/shapes/{shape}/geometry"),
        (DEFAULT_KEYS.shape_mesh(shape), None),
    ):
        found = path_of(api.store, key)
        found.unlink() if harm == "missing" else found.write_bytes(b"other")
        if address is not None:
            told = problem(http.get(address), 410, "content-lost")
            assert harm in told["detail"]
    asked = http.post("/v1/matches", json={"source": shape, "target": shape, **QUICK})
    assert asked.status_code == 202, asked.text
    job = http.get(f"/v1/jobs/{asked.json()['id']}", params={"wait": 60}).json()
    assert job["state"] == "failed"
    assert job["error"]["type"] == "urn:isomatch:problem:content-lost"
    assert shape in job["error"]["detail"]
    # What the problem says to do helps.
    assert http.delete(f"/v1/shapes/{shape}").status_code == 204
    upload(data)
    assert http.get(f"/v1/shapes/{shape}/mesh").content == data


# The blobs that are not lost are left to the sweep: each case has a shape of its own.
@pytest.mark.parametrize(
    ("seed", "key"), [(330, DEFAULT_KEYS.shape_mesh), (333, DEFAULT_KEYS.shape_upload)]
)
def test_an_upload_restores_lost_content(
    api: Api, http: httpx2.Client, upload: Callable[..., Json], seed: int, key: Callable[[str], str]
) -> None:
    data = blob_file(2, seed=seed)
    shape = upload(data)["id"]
    path_of(api.store, key(shape)).unlink()
    upload(data)
    assert http.get(f"/v1/shapes/{shape}/mesh").content == data
    asked = http.post("/v1/matches", json={"source": shape, "target": shape, **QUICK})
    job = http.get(f"/v1/jobs/{asked.json()['id']}", params={"wait": 60}).json()
    assert job["state"] == "succeeded", job


def test_an_upload_leaves_content_that_another_has_restored(
    server: EmbeddedServer, monkeypatch: pytest.MonkeyPatch
) -> None:
    data, is_lost = blob_file(2, seed=331), Shapes.lost
    others: list[Callable[[], None]] = []

    def restored_meanwhile(shapes: Shapes, shape: str) -> bool:
        found = is_lost(shapes, shape)
        while others:
            others.pop()()
        return found

    monkeypatch.setattr(Shapes, "lost", restored_meanwhile)
    # No worker serves this database: the test does what one would do.
    with (
        idle_api(server, validation_wait=0) as api,
        httpx2.Client(base_url=api.url, timeout=60.0) as http,
    ):
        queue = JobQueue(api.store, QueueSettings())

        def sent() -> httpx2.Response:
            return http.post("/v1/shapes", files={"file": ("a.off", data)})

        def restore() -> None:
            Runner(queue, "runner").run(sent().json()["id"])

        restore()
        shape = shape_id(data)
        path_of(api.store, DEFAULT_KEYS.shape_mesh(shape)).unlink()
        others.append(restore)
        assert sent().status_code == 201
        assert api.store.shapes.mesh(shape) is not None


def test_lost_content_is_named_until_it_is_restored(server: EmbeddedServer) -> None:
    data = blob_file(2, seed=332)
    with (
        idle_api(server, validation_wait=0) as api,
        httpx2.Client(base_url=api.url, timeout=60.0) as http,
    ):
        queue = JobQueue(api.store, QueueSettings())

        def sent() -> httpx2.Response:
            return http.post("/v1/shapes", files={"file": ("a.off", data)})

        Runner(queue, "runner").run(sent().json()["id"])
        shape = sent().json()["id"]
        path_of(api.store, DEFAULT_KEYS.shape_upload(shape)).unlink()
        first, second = sent(), sent()
        assert (first.status_code, second.json()) == (202, first.json())
        assert http.get(first.headers["location"]).status_code == 202
        problem(http.get(f"/v1/shapes/{shape}/mesh"), 410, "content-lost")
        # What cannot be restored is not deleted either.
        api.store.jobs.cancel(first.json()["id"])
        assert http.get(first.headers["location"]).status_code == 200
        problem(http.get(f"/v1/shapes/{shape}/mesh"), 410, "content-lost")
        Runner(queue, "runner").run(sent().json()["id"])
        assert http.get(f"/v1/shapes/{shape}/mesh").content == data


def test_results_that_are_lost_are_told(
    api: Api, http: httpx2.Client, shapes: tuple[str, str]
) -> None:
    source, target = shapes
    asked = http.post("/v1/matches", json={"source": source, "target": target, **QUICK})
    job = asked.json()["id"]
    assert http.get(f"/v1/jobs/{job}", params={"wait": 60}).json()["state"] == "succeeded"
    picture = http.get(f"/v1/jobs/{job}/result.png")
    assert picture.status_code == 200
    # A picture is made again; arrays and the result itself are not.
    path_of(api.store, DEFAULT_KEYS.job_picture(job)).unlink()
    assert http.get(f"/v1/jobs/{job}/result.png").status_code == 200
    path_of(api.store, DEFAULT_KEYS.job_arrays(job)).write_bytes(b"")
    problem(http.get(f"/v1/jobs/{job}/result.npz"), 410, "content-lost")
    path_of(api.store, DEFAULT_KEYS.job_result(job)).unlink()
    problem(http.get(f"/v1/jobs/{job}/result"), 410, "content-lost")


def test_a_blob_store_that_is_away_is_named(server: EmbeddedServer, tmp_path: Path) -> None:
    (tmp_path / "blobs").write_text("a file where a directory is to be")
    blobs = blob_url(tmp_path)
    with (
        idle_api(server, blob_url=blobs, ready_workers=0) as api,
        httpx2.Client(base_url=api.url, timeout=60.0) as http,
    ):
        told = problem(http.get("/health/ready"), 503, "not-ready")
        assert "blob directory" in told["detail"]
        answer = http.post("/v1/shapes", files={"file": ("a.off", b"OFF")})
        assert "meshes and results" in problem(answer, 503, "store-away")["detail"]
        assert answer.headers["retry-after"]
        assert list(api.store.jobs.active()) == [], "nothing was queued without its bytes"
        (tmp_path / "blobs").unlink()
        assert http.get("/health/ready").status_code == 200


def test_bytes_that_are_not_migrated_are_told(
    api: Api, http: httpx2.Client, upload: Callable[..., Json]
) -> None:
    shape = upload(blob_file(2, seed=310))["id"]
    api.store.client.delete(DEFAULT_KEYS.shape_upload(shape))
    api.store.client.set(DEFAULT_KEYS.shape_upload(shape), b"bytes", ex=1000)
    told = problem(http.get(f"/v1/shapes/{shape}/mesh"), 503, "store-away")
    assert "earlier version" in told["detail"]


def test_a_full_disk_is_told_to_the_uploader(server: EmbeddedServer, small_disk: Path) -> None:
    settings = Settings(
        redis_url=empty_database(server), blob_url=blob_url(small_disk), validation_wait=PATIENCE
    )
    mesh = blob_file(2, seed=320)
    with served_api(settings) as api, httpx2.Client(base_url=api.url, timeout=300.0) as http:

        def sent(more: int) -> httpx2.Response:
            data = mesh + b"#" * more
            return http.post("/v1/shapes", files={"file": ("a.off", data)})

        assert sent(0).status_code == 201
        answer = sent(4 * 1024**2)
        problem(answer, 507, "storage-full")
        assert answer.headers["retry-after"]
        # The upload finds its place, and what is made of it does not.
        problem(sent(2 * 1024**2), 507, "storage-full")
        assert len(http.get("/v1/shapes").json()["items"]) == 1
        assert sent(10).status_code == 201, "nothing of the refused uploads is left"
        filler = small_disk / "filler"
        with pytest.raises(OSError, match="space"):
            filler.write_bytes(bytes(3 * 1024**2))
        told = problem(http.get("/health/ready"), 503, "not-ready")
        assert "No space left" in told["detail"]
        problem(sent(20), 507, "storage-full")
        filler.unlink()
        assert http.get("/health/ready").status_code == 200
        assert sent(20).status_code == 201


def test_a_full_temporary_directory_is_told_to_the_uploader(
    server: EmbeddedServer, small_disk: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Uploads on their way are in a temporary directory."""
    monkeypatch.setattr("tempfile.tempdir", str(small_disk))
    with (
        idle_api(server, blob_url=blob_url(small_disk)) as api,
        httpx2.Client(base_url=api.url, timeout=60.0) as http,
    ):
        answer = http.post("/v1/shapes", files={"file": ("a.off", bytes(4 * 1024**2))})
        problem(answer, 507, "storage-full")
        assert list(api.store.jobs.active()) == []


def test_an_api_of_another_redis_is_not_ready(server: EmbeddedServer, tmp_path: Path) -> None:
    for ready in (True, False):
        with (
            idle_api(server, blob_url=blob_url(tmp_path), ready_workers=0) as api,
            httpx2.Client(base_url=api.url, timeout=60.0) as http,
        ):
            answer = http.get("/health/ready")
            if ready:
                assert answer.status_code == 200
            else:
                told = problem(answer, 503, "not-ready")
                assert "belongs to another Redis" in told["detail"]
