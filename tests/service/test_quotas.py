"""Quotas: what a tenant may have, however many ask at once, and when it gets it back."""

import hashlib
import threading
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from io import BufferedIOBase
from typing import cast

import httpx2
import pytest

from broker.store import Quotas
from service.settings import Settings
from service.standalone import EmbeddedServer
from tests.service.conftest import Api, idle_api, problem, running_api
from tests.worker.figures import blob_file

MATCH = {"points": 8, "coarse_points": 8, "orientation": False}


@pytest.fixture(scope="module")
def shared(api: Api, settings: Settings) -> Iterator[Api]:
    keys = "small/ann:anns-key, other/bob:bobs-key"
    with running_api(Settings(**(settings.model_dump() | {"api_keys": keys}))) as running:
        yield running


@pytest.fixture
def ann(shared: Api) -> Iterator[httpx2.Client]:
    """A client of a tenant that has nothing."""
    headers = {"Authorization": "Bearer anns-key"}
    with httpx2.Client(base_url=shared.url, headers=headers, timeout=300.0) as http:
        yield http
        quotas(shared).unset()
        for shape in http.get("/v1/shapes").json()["items"]:
            http.delete(f"/v1/shapes/{shape['id']}")


def quotas(api: Api) -> Quotas:
    return api.store.of("small").quotas


def sent(http: httpx2.Client, seed: int) -> httpx2.Response:
    return http.post("/v1/shapes", files={"file": ("blob.off", blob_file(2, seed))})


def test_shapes_never_pass_the_quota(shared: Api, ann: httpx2.Client) -> None:
    quotas(shared).set(shapes=3)
    start = threading.Barrier(8)

    def upload(seed: int) -> httpx2.Response:
        start.wait()
        return sent(ann, seed)

    with ThreadPoolExecutor(8) as threads:
        answers = [one.result() for one in [threads.submit(upload, n) for n in range(200, 208)]]
    assert sorted(answer.status_code for answer in answers) == [201] * 3 + [507] * 5
    refused = next(answer for answer in answers if answer.status_code == 507)
    said = problem(refused, 507, "quota-exceeded")["detail"]
    assert "3 shapes, and may keep 3" in said
    listed = ann.get("/v1/shapes").json()["items"]
    assert len(listed) == 3
    # What is there already is no more than it was.
    known = next(n for n, answer in enumerate(answers, 200) if answer.status_code == 201)
    assert sent(ann, known).status_code == 200
    assert ann.delete(f"/v1/shapes/{listed[0]['id']}").status_code == 204
    assert sent(ann, 210).status_code == 201
    problem(sent(ann, 211), 507, "quota-exceeded")
    # An expired shape is one less.
    shared.store.client.delete(shared.store.of("small").keys.shape(listed[1]["id"]))
    assert sent(ann, 211).status_code == 201


def test_other_tenants_have_their_own_quota(shared: Api, ann: httpx2.Client) -> None:
    quotas(shared).set(shapes=1)
    assert sent(ann, 220).status_code == 201
    problem(sent(ann, 221), 507, "quota-exceeded")
    headers = {"Authorization": "Bearer bobs-key"}
    with httpx2.Client(base_url=shared.url, headers=headers, timeout=300.0) as bob:
        assert sent(bob, 221).status_code == 201


def test_uploads_at_once_do_not_pass_the_quota_of_bytes(shared: Api, ann: httpx2.Client) -> None:
    store, size = shared.store.of("small"), len(blob_file(2, 240))
    limit = store.quotas.bytes() + 3 * size
    quotas(shared).set(bytes=limit)
    most = [0]
    done = threading.Event()

    def watch() -> None:
        while not done.is_set():
            held = store.client.zrange(store.keys.held, 0, -1, withscores=True)
            sizes = [size for _, size in cast(list[tuple[bytes, float]], held)]
            most[0] = max(most[0], int(sum(sizes)))

    with ThreadPoolExecutor(9) as threads:
        watching = threads.submit(watch)
        answers = [threads.submit(sent, ann, seed) for seed in range(240, 248)]
        codes = {answer.result().status_code for answer in answers}
        done.set()
        watching.result()
    assert 507 in codes
    assert most[0] <= limit


def test_uploads_at_once_wait_for_their_turn(shared: Api, ann: httpx2.Client) -> None:
    quotas(shared).set(jobs=1)
    with ThreadPoolExecutor(6) as threads:
        answers = list(threads.map(partial(sent, ann), range(250, 256)))
    assert {answer.status_code for answer in answers} == {201}
    # Whoever waits for a place holds none if the bytes are known by then.
    with ThreadPoolExecutor(3) as threads:
        answers = list(threads.map(partial(sent, ann), [256, 257, 257]))
    assert sorted(answer.status_code for answer in answers)[-2:] == [201, 201]
    assert sent(ann, 258).status_code == 201
    store = shared.store.of("small")
    assert not store.client.exists(store.keys.validating, store.keys.validations_by("ann"))


def test_an_upload_is_hashed_once(server: EmbeddedServer, monkeypatch: pytest.MonkeyPatch) -> None:
    hashed = []
    digest_of = hashlib.file_digest

    def counted(file: BufferedIOBase, algorithm: str) -> object:
        hashed.append(algorithm)
        return digest_of(file, algorithm)

    with (
        idle_api(server, tenant_jobs=1, validation_wait=0.5) as api,
        httpx2.Client(base_url=api.url, timeout=60.0) as http,
    ):
        monkeypatch.setattr(hashlib, "file_digest", counted)
        assert sent(http, 262).status_code == 202
        assert hashed == ["sha256"]
        # It waits for a place, and finds none.
        assert sent(http, 263).status_code == 429
        assert hashed == ["sha256", "sha256"]


def test_an_upload_that_finds_no_place_is_refused(server: EmbeddedServer) -> None:
    with (
        idle_api(server, tenant_jobs=1, validation_wait=0.2) as api,
        httpx2.Client(base_url=api.url, timeout=60.0) as http,
    ):
        assert sent(http, 260).status_code == 202
        stored = api.store.client.zcard(api.store.keys.held)
        refused = sent(http, 261)
        document = problem(refused, 429, "too-many-jobs")
        assert "Your tenant has 1 validations of uploads queued" in document["detail"]
        assert refused.headers["retry-after"]
        assert api.store.client.zcard(api.store.keys.held) == stored


def test_bytes_are_those_of_what_is_kept(shared: Api, ann: httpx2.Client) -> None:
    store = shared.store.of("small")
    before = store.quotas.bytes()
    first = sent(ann, 230).json()["id"]
    keys = (store.keys.shape_upload, store.keys.shape_mesh, store.keys.shape_geometry)
    size = sum(len(store.blobs.get(key(first)) or b"") for key in keys)
    assert store.quotas.bytes() - before == size
    quotas(shared).set(bytes=before + size + len(blob_file(2, 231)))
    # The upload would fit, but not with what is made of it.
    problem(sent(ann, 231), 507, "quota-exceeded")
    assert store.quotas.bytes() == before + size
    quotas(shared).set(bytes=before + 2 * size + 2000)
    second = sent(ann, 231)
    assert second.status_code == 201
    body = {"source": first, "target": second.json()["id"], **MATCH}
    quotas(shared).set(bytes=store.quotas.bytes())
    problem(ann.post("/v1/matches", json=body), 507, "quota-exceeded")
    quotas(shared).set(bytes=store.quotas.bytes() + 1)
    job = ann.post("/v1/matches", json=body)
    assert job.status_code == 202
    done = ann.get(job.json()["links"]["self"], params={"wait": 60}).json()
    assert done["state"] == "succeeded"
    result = store.results.document(done["id"])
    assert result is not None
    assert store.quotas.bytes() >= quotas(shared).get().bytes - 1 + len(result)
    # So is a batch, but its matches that come after the quota is used up fail.
    quotas(shared).set(bytes=store.quotas.bytes() + 1)
    targets = {"source": first, "targets": [second.json()["id"]] * 6, **MATCH}
    batch = ann.post("/v1/batches", json=targets).json()
    assert ann.get(batch["links"]["self"], params={"wait": 60}).json()["state"] == "succeeded"
    matches = ann.get(batch["links"]["partial"]).json()["matches"]
    assert [one["error"]["type"] for one in matches if one["state"] == "failed"][-1:] == [
        "urn:isomatch:problem:quota-exceeded"
    ]
    problem(ann.get(done["links"]["picture"]), 507, "quota-exceeded")
    quotas(shared).set(bytes=0)
    assert ann.get(done["links"]["picture"]).status_code == 200
    held = store.quotas.bytes()
    ann.delete(f"/v1/shapes/{first}")
    assert store.quotas.bytes() == held - size
    path, job_id = done["links"]["result"], done["id"]
    kept = [store.keys.job_result(job_id), store.keys.job_arrays(job_id)]
    freed = sum(int(store.client.zscore(store.keys.held, key) or 0) for key in kept)
    freed += len(ann.get(done["links"]["picture"]).content)
    assert ann.delete(path).status_code == 204
    assert store.quotas.bytes() == held - size - freed
    for method in ("GET", "DELETE"):
        problem(ann.request(method, path), 410, "result-expired")
    problem(ann.get(done["links"]["picture"]), 410, "result-expired")
    left = ann.get(done["links"]["self"]).json()
    assert left["links"]["result"] is left["summary"] is None
    assert {**left, "links": done["links"], "summary": done["summary"]} == done
    # The sum that is kept is the one of all sizes, among them that of the request.
    found = store.client.zrange(store.keys.held, 0, -1, withscores=True)
    sizes = dict(cast(list[tuple[bytes, float]], found))
    assert store.quotas.bytes() == sum(sizes.values())
    assert sizes[store.keys.job(job_id).encode()] > len(first)
