"""Uploading, listing, fetching and deleting shapes; and whatever is uploaded instead of a mesh."""

import hashlib
import json
import socket
import struct
import threading
from collections.abc import Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import suppress
from datetime import datetime
from typing import Any
from urllib.parse import urlsplit

import httpx2
import numpy as np
import pytest
import trimesh

from broker.contracts import Problem, ProblemType
from broker.store import Durability
from service.dependencies import UPLOADS_AT_ONCE
from service.standalone import EmbeddedServer
from tests.service.conftest import LIMIT, Api, Upload, idle_api, problem
from tests.worker.figures import blob, blob_file, off
from tests.workers import nothing_is_left
from worker.pictures import source_view


def post(http: httpx2.Client, data: bytes, filename: str = "mesh.off") -> httpx2.Response:
    return http.post("/v1/shapes", files={"file": (filename, data)})


def test_a_new_shape(http: httpx2.Client) -> None:
    data = blob_file(2, seed=20)
    answer = http.post("/v1/shapes", files={"file": ("cat.OFF", data)}, data={"name": "a cat"})
    assert answer.status_code == 201
    shape = answer.json()
    assert shape["id"] == hashlib.sha256(data).hexdigest()[:32]
    assert answer.headers["location"] == f"/v1/shapes/{shape['id']}"
    assert datetime.fromisoformat(shape.pop("created")).tzinfo is not None
    assert shape.pop("area") > 0
    vertices, faces = blob(2, seed=20)
    np.testing.assert_allclose(shape.pop("view"), source_view(vertices, faces).axes, atol=1e-6)
    assert shape == {
        "id": shape["id"],
        "name": "a cat",
        "file_type": "off",
        "kind": "mesh",
        "bytes": len(data),
        "vertices": 162,
        "faces": 320,
        "file_vertices": 162,
        "file_faces": 320,
        "components": 1,
        "closed": True,
        "has_colors": False,
        "warnings": [],
    }


def test_y_is_up_for_a_shape_of_an_earlier_version(http: httpx2.Client, api: Api) -> None:
    shape = post(http, blob_file(2, seed=25)).json()
    stored = {name: value for name, value in shape.items() if name != "view"}
    api.store.client.set(api.store.keys.shape(shape["id"]), json.dumps(stored), keepttl=True)
    earlier = http.get(f"/v1/shapes/{shape['id']}").json()
    assert earlier == shape | {"view": [[1, 0, 0], [0, 1, 0], [0, 0, 1]]}


def test_the_same_bytes_are_the_same_shape(http: httpx2.Client) -> None:
    data = blob_file(2, seed=21)
    first = post(http, data)
    second = post(http, data, "other.obj")
    assert (first.status_code, second.status_code) == (201, 200)
    assert first.json() == http.get(first.headers["location"]).json()
    assert first.headers["location"] == second.headers["location"]


def test_the_same_bytes_under_a_second_name_keep_it_for_that_upload(http: httpx2.Client) -> None:
    data = blob_file(2, seed=24)
    first, second = post(http, data), post(http, data, "other.off")
    assert second.json() == {**first.json(), "name": "other.off"}
    assert http.get(first.headers["location"]).json() == first.json()


def test_equal_uploads_at_the_same_time(http: httpx2.Client) -> None:
    data = blob_file(3, seed=22)
    answers: list[httpx2.Response] = []
    threads = [threading.Thread(target=lambda: answers.append(post(http, data))) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert {answer.status_code for answer in answers} <= {200, 201}
    assert len({answer.text for answer in answers}) == 1


@pytest.mark.parametrize("file_type", ["off", "obj", "ply", "stl", "glb"])
def test_formats(http: httpx2.Client, file_type: str) -> None:
    vertices, faces = blob(2, seed=23)
    mesh = trimesh.Trimesh(vertices, faces, process=False)
    data = mesh.export(file_type=file_type)
    assert isinstance(data, str | bytes)
    content = data if isinstance(data, bytes) else data.encode()
    answer = post(http, content, f"m.{file_type}")
    assert answer.status_code == 201, answer.text
    shape = answer.json()
    assert (shape["vertices"], shape["faces"], shape["file_type"]) == (162, 320, file_type)
    assert shape["area"] == pytest.approx(mesh.area, rel=1e-4)


@pytest.mark.parametrize(
    "name", ["a\nb", "\x1b[31mred", "nul\0", "\u2028", "\u202egnp.exe", "\x85"]
)
def test_names_that_cannot_be_shown(http: httpx2.Client, name: str) -> None:
    answer = http.post("/v1/shapes", files={"file": ("m.off", WHOLE)}, data={"name": name})
    document = problem(answer, 422, "invalid-request")
    assert [error["field"] for error in document["errors"]] == ["body.name"]


@pytest.mark.parametrize(
    ("filename", "name", "shown"),
    [
        (b"cat.off", "", "cat.off"),
        (b"cat.off", "  ", "cat.off"),
        (b"cat.off", " a cat ", "a cat"),
        ("貓.off".encode(), None, "貓.off"),
        (b"../../cat.off", None, "cat.off"),
        (b"C:\\cats\\cat.off", None, "cat.off"),
        (b"ca\x1b\nt.off", None, "cat.off"),
        (b"a;b%22c%0D%0A.off", None, 'a;b"c.off'),
        (b"100%25 cat%2F.off", None, "100%25 cat%2F.off"),
    ],
)
def test_names(http: httpx2.Client, filename: bytes, name: str | None, shown: str) -> None:
    data = blob_file(1) + f"# {filename!r} {name}\n".encode()
    parts = [
        b'Content-Disposition: form-data; name="file"; filename="%s"\r\n\r\n%s' % (filename, data)
    ]
    if name is not None:
        parts.append(b'Content-Disposition: form-data; name="name"\r\n\r\n' + name.encode())
    body = b"".join(b"--x\r\n" + part + b"\r\n" for part in parts) + b"--x--\r\n"
    headers = {"content-type": "multipart/form-data; boundary=x"}
    answer = http.post("/v1/shapes", content=body, headers=headers)
    assert answer.status_code == 201, answer.text
    assert answer.json()["name"] == shown


def test_listing(http: httpx2.Client, upload: Upload) -> None:
    ids = [upload(blob_file(1, seed=seed))["id"] for seed in (30, 31, 32)]
    seen: list[str] = []
    cursor: str | None = None
    while True:
        page = http.get("/v1/shapes", params={"limit": 2} | ({"cursor": cursor} if cursor else {}))
        assert page.status_code == 200
        assert len(page.json()["items"]) <= 2
        seen += [shape["id"] for shape in page.json()["items"]]
        cursor = page.json()["next_cursor"]
        if cursor is None:
            break
    assert len(seen) == len(set(seen))
    assert [shape for shape in seen if shape in ids] == ids[::-1]


def test_the_file_comes_back(http: httpx2.Client, upload: Upload) -> None:
    data = blob_file(2, seed=24)
    shape = upload(data)["id"]
    answer = http.get(f"/v1/shapes/{shape}/mesh")
    assert answer.content == data
    assert 'filename="mesh.off"' in answer.headers["content-disposition"]
    assert answer.headers["etag"] == f'"{shape}"'
    known = {"If-None-Match": f'"other", "{shape}"'}
    unchanged = http.get(f"/v1/shapes/{shape}/mesh", headers=known)
    assert (unchanged.status_code, unchanged.content) == (304, b"")
    assert unchanged.headers["cache-control"] == "private, no-cache"
    http.delete(f"/v1/shapes/{shape}")
    problem(http.get(f"/v1/shapes/{shape}/mesh", headers=known), 404, "shape-not-found")


def test_an_upload_need_not_wait_for_its_validation(http: httpx2.Client) -> None:
    answer = http.post("/v1/shapes?wait=0", files={"file": ("a.off", blob_file(3, seed=26))})
    assert answer.status_code in (201, 202)
    assert answer.headers["location"].startswith("/v1/shapes/")
    if answer.status_code == 202:
        http.get(answer.json()["links"]["self"], params={"wait": 60})
    assert http.get(answer.headers["location"]).json()["vertices"] == 642
    for wait in ("-1", "61", "nan"):
        answer = http.post(f"/v1/shapes?wait={wait}", files={"file": ("a.off", WHOLE)})
        problem(answer, 422, "invalid-request")


def test_deleting(http: httpx2.Client, upload: Upload) -> None:
    data = blob_file(2, seed=25)
    path = f"/v1/shapes/{upload(data)['id']}"
    assert http.delete(path).status_code == 204
    problem(http.delete(path), 404, "shape-not-found")
    problem(http.get(path), 404, "shape-not-found")
    problem(http.get(f"{path}/mesh"), 404, "shape-not-found")
    assert post(http, data).status_code == 201


def test_ids_of_nobody(http: httpx2.Client) -> None:
    for path in ("/v1/shapes/" + "0" * 32, "/v1/shapes/nobody"):
        problem(http.get(path), 404, "shape-not-found")
        problem(http.delete(path), 404, "shape-not-found")
    problem(http.get("/v1/shapes/%00"), 422, "invalid-request")


TRIANGLE = b"OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n"
WHOLE = blob_file(2, seed=26)
NO_MESHES = {
    "empty": b"",
    "blank": b" \n\n",
    "text": b"Dear reader,\nthis is a letter.\n",
    "binary": bytes(range(256)) * 40,
    "truncated": WHOLE[: len(WHOLE) // 2],
    "truncated in the faces": WHOLE[:-200],
    "nan": off(*blob(1)).replace(b"\n0", b"\nnan", 1),
    "infinite": b"OFF\n3 1 0\n0 0 0\n1 0 inf\n0 1 0\n3 0 1 2\n",
    "no faces": b"OFF\n3 0 0\n0 0 0\n1 0 0\n0 1 0\n",
    "only degenerate faces": TRIANGLE + b"3 0 1 1\n",
    "no area": b"OFF\n3 1 0\n0 0 0\n1 0 0\n2 0 0\n3 0 1 2\n",
    "index out of range": TRIANGLE + b"3 0 1 7\n",
    "negative index": TRIANGLE + b"3 0 1 -1\n",
    "huge counts": b"OFF\n4000000000 4000000000 0\n0 0 0\n",
}


@pytest.mark.parametrize("what", NO_MESHES)
def test_unreadable_meshes_are_refused_and_leave_nothing(
    http: httpx2.Client, api: Api, what: str
) -> None:
    data = NO_MESHES[what]
    name = hashlib.sha256(data).hexdigest()[:32]
    document = problem(post(http, data), 422, "unusable-mesh")
    assert len(document["detail"]) > 10
    (error,) = document["errors"]
    assert (error["field"], error["message"]) == ("body.file", document["detail"])
    problem(http.get(f"/v1/shapes/{name}"), 404, "shape-not-found")
    nothing_is_left(api.store, name)


def test_a_nan_among_coordinates_is_named(http: httpx2.Client) -> None:
    vertices, faces = blob(1)
    vertices[5, 1] = float("nan")
    document = problem(post(http, off(vertices, faces)), 422, "unusable-mesh")
    assert "finite" in document["detail"].lower() or "nan" in document["detail"].lower()


def test_equal_uploads_of_no_mesh_at_the_same_time(http: httpx2.Client) -> None:
    with ThreadPoolExecutor(16) as threads:
        for n in range(4):
            data = b"no mesh either %d" % n
            asked = [threads.submit(post, http, data) for _ in range(16)]
            for answer in asked:
                problem(answer.result(), 422, "unusable-mesh")


def test_other_formats_that_lie(http: httpx2.Client) -> None:
    stl = bytes(80) + struct.pack("<I", 4_000_000_000) + bytes(100)
    glb = b"glTF" + struct.pack("<III", 2, 20, 2**31) + b"JSON"
    gltf = json.dumps({"asset": {"version": "2.0"}, "buffers": [{"uri": "file:///etc/passwd"}]})
    ply = b"ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nend_header\n1\n"
    for filename, data in (
        ("m.stl", stl),
        ("m.glb", glb),
        ("m.gltf", gltf.encode()),
        ("m.ply", ply),
        ("m.obj", b"v 0 0 0\nf 1 2 3\n"),
    ):
        problem(post(http, data, filename), 422, "unusable-mesh")


@pytest.mark.parametrize(
    "filename", ["mesh", "mesh.doc", "mesh.off.gz", ".off", "a\\.off", "mesh.", "a" * 300]
)
def test_unknown_formats(http: httpx2.Client, filename: str) -> None:
    document = problem(post(http, WHOLE, filename), 415, "unsupported-format")
    assert ".ply" in document["detail"]
    assert document["errors"][0]["field"] == "body.file"


@pytest.mark.parametrize(
    ("file", "data"),
    [
        (("blob", WHOLE), {"name": "cat0.off"}),
        (("blob", WHOLE, "model/off"), {}),
        (("blob", WHOLE, "model/off; charset=utf-8"), {"name": "a cat"}),
        (("cat.off", WHOLE, "model/obj"), {"name": "cat.stl"}),
    ],
)
def test_the_format_of_a_file_without_a_name(
    http: httpx2.Client, file: Any, data: dict[str, str]
) -> None:
    shape = http.post("/v1/shapes", files={"file": file}, data=data).json()
    assert shape["file_type"] == "off"
    assert shape["name"] == data.get("name", file[0])


def test_uploads_that_are_none(http: httpx2.Client) -> None:
    document = problem(http.post("/v1/shapes"), 422, "invalid-request")
    assert document["errors"][0]["field"] == "body.file"
    problem(http.post("/v1/shapes", data={"file": "text"}), 415, "unsupported-format")
    problem(http.post("/v1/shapes", json={"file": "text"}), 415, "unsupported-format")
    broken = {"content-type": "multipart/form-data; boundary=x"}
    problem(http.post("/v1/shapes", content=b"--y\r\n", headers=broken), 400, "bad-request")
    empty_name = http.post("/v1/shapes", files={"file": ("a.off", WHOLE)}, data={"name": "n" * 201})
    assert problem(empty_name, 422, "invalid-request")["errors"][0]["field"] == "body.name"


def test_a_file_over_the_limit(http: httpx2.Client) -> None:
    document = problem(post(http, bytes(LIMIT + 1)), 413, "upload-too-large")
    assert (
        document["detail"]
        == "The limit is 2.097 MB; send a smaller file, such as a simplified mesh."
    )
    problem(post(http, bytes(20 * LIMIT)), 413, "upload-too-large")
    # Right at the limit it is looked at, and found to be no mesh.
    problem(post(http, bytes(LIMIT)), 422, "unusable-mesh")


def test_a_file_over_the_limit_that_does_not_say_so(http: httpx2.Client) -> None:
    def endless() -> Iterator[bytes]:
        yield b'--x\r\nContent-Disposition: form-data; name="file"; filename="a.off"\r\n\r\n'
        for _ in range(40):
            yield bytes(LIMIT // 8)
        yield b"\r\n--x--\r\n"

    headers = {"content-type": "multipart/form-data; boundary=x"}
    answer = http.post("/v1/shapes", content=endless(), headers=headers)
    assert "content-length" not in answer.request.headers
    problem(answer, 413, "upload-too-large")


@pytest.mark.parametrize(
    ("framing", "status"),
    [
        (b"Content-Length: %d\r\n\r\n" % (100 * LIMIT), 413),
        (b"Content-Encoding: gzip\r\nContent-Length: 1000\r\n\r\n", 415),
    ],
)
def test_a_sender_that_asks_first_is_spared_the_sending(
    api: Api, framing: bytes, status: int
) -> None:
    address = urlsplit(api.url)
    with socket.create_connection((address.hostname, address.port), timeout=30) as connection:
        connection.sendall(
            b"POST /v1/shapes HTTP/1.1\r\nHost: x\r\nExpect: 100-continue\r\n"
            b"Content-Type: multipart/form-data; boundary=x\r\n" + framing
        )
        assert connection.recv(100).startswith(b"HTTP/1.1 %d " % status)


@pytest.mark.parametrize(
    ("framing", "status"),
    [
        (b"Content-Length: 1000\r\n\r\n--x\r\n", 408),
        (b"Transfer-Encoding: chunked\r\n\r\n5\r\n--x\r\n\r\n", 408),
        (b"Transfer-Encoding: chunked\r\n\r\nffffffffffff\r\n--x\r\n", 408),
        (b"Content-Length: %d\r\n\r\n--x\r\n" % (100 * LIMIT), 413),
    ],
)
def test_a_sender_that_stops_sending_is_not_waited_for(
    server: EmbeddedServer, framing: bytes, status: int
) -> None:
    def refused(path: bytes) -> bytes:
        with idle_api(server, max_upload_bytes=LIMIT, body_patience=0.2) as api:
            address = urlsplit(api.url)
            connecting = socket.create_connection((address.hostname, address.port), timeout=90)
            with connecting as sender, suppress(ConnectionError):
                sender.sendall(
                    b"POST %s HTTP/1.1\r\nHost: x\r\n"
                    b"Content-Type: multipart/form-data; boundary=x\r\n%s" % (path, framing)
                )
                with sender.makefile("rb") as answer:
                    return answer.read()
        return b""

    for path in (b"/v1/shapes", b"/v1/matches"):
        head, _, body = refused(path).partition(b"\r\n\r\n")
        assert head.startswith(b"HTTP/1.1 %d " % status)
        assert b"application/problem+json" in head
        assert json.loads(body)["status"] == status


def test_other_bodies_have_a_smaller_limit(http: httpx2.Client) -> None:
    answer = http.post("/v1/matches", content=b'{"source": "' + b"a" * 2**21 + b'"}')
    problem(answer, 413, "upload-too-large")


def test_after_all_that_a_good_upload_still_works(http: httpx2.Client) -> None:
    assert post(http, blob_file(2, seed=27)).status_code == 201


def test_an_upload_that_takes_long_is_answered_before(server: EmbeddedServer) -> None:
    # No worker serves this database: nothing is ever validated.
    with (
        idle_api(server, validation_wait=0.05) as api,
        httpx2.Client(base_url=api.url, timeout=60.0) as http,
    ):
        answer = post(http, WHOLE)
        assert answer.status_code == 202
        job = answer.json()
        assert (job["kind"], job["state"], job["position"]) == ("validation", "queued", 0)
        again = http.get(answer.headers["location"])
        assert again.status_code == 202
        assert again.json() == job
        assert post(http, WHOLE).json()["id"] == job["id"]
        assert http.get("/v1/jobs").json()["items"] == []
        assert http.get(job["links"]["self"]).json() == job
        # Given up without a verdict, the file may be sent again.
        api.store.jobs.cancel(job["id"])
        problem(http.get(answer.headers["location"]), 404, "shape-not-found")
        fresh = post(http, WHOLE)
        assert fresh.status_code == 202
        assert fresh.json()["id"] != job["id"]
        # Refused after the sender was told to ask again, it is refused when he asks.
        stated = Problem.of(ProblemType.UNUSABLE_MESH, "the file lies")
        assert api.store.jobs.claim(fresh.json()["id"], "me")
        api.store.jobs.fail(fresh.json()["id"], "me", stated)
        refused = problem(http.get(fresh.headers["location"]), 422, "unusable-mesh")
        assert refused["detail"] == "the file lies"


def test_an_upload_that_others_meddle_with_while_it_is_read(server: EmbeddedServer) -> None:
    # No worker serves this database: the test does what one would do.
    with (
        idle_api(server) as api,
        httpx2.Client(base_url=api.url, timeout=60.0) as http,
        ThreadPoolExecutor(1) as threads,
    ):
        jobs = api.store.jobs

        def asked() -> tuple[Future[httpx2.Response], str]:
            answer = threads.submit(post, http, WHOLE)
            while not (active := list(jobs.active())):
                assert not answer.done()
            return answer, active[0].id

        answer, job = asked()
        jobs.cancel(job)
        problem(answer.result(), 409, "upload-cancelled")
        answer, job = asked()
        assert jobs.claim(job, "me")
        assert jobs.succeed(job, "me")
        problem(answer.result(), 410, "shape-deleted")


def test_a_shape_that_is_deleted_while_its_upload_is_answered(
    http: httpx2.Client, api: Api, monkeypatch: pytest.MonkeyPatch
) -> None:
    wait = Durability.wait

    def deleting(self: Durability, key: str) -> None:
        assert api.store.shapes.delete(key.rpartition(":")[2])
        wait(self, key)

    monkeypatch.setattr(Durability, "wait", deleting)
    data = blob_file(3, seed=1077)
    deleted = problem(
        http.post("/v1/shapes", files={"file": ("a.off", data)}), 410, "shape-deleted"
    )
    assert "upload it again" in deleted["detail"]


def test_uploads_at_the_same_time_are_all_taken(server: EmbeddedServer) -> None:
    """Few are in memory at a time; those that are refused make room as well."""
    count = 3 * UPLOADS_AT_ONCE
    with (
        idle_api(server, validation_wait=0.1) as api,
        httpx2.Client(base_url=api.url, timeout=60.0) as http,
    ):

        def send(number: int, key: str | None = None) -> httpx2.Response:
            headers = {} if key is None else {"Idempotency-Key": key}
            files = {"file": ("a.off", blob_file(2, seed=number))}
            return http.post("/v1/shapes", files=files, headers=headers, timeout=60.0)

        assert send(0, "mine").status_code == 202
        with ThreadPoolExecutor(count) as pool:
            refused = list(pool.map(lambda number: send(number, "mine"), range(1, count)))
            taken = list(pool.map(send, range(1, count)))
        assert {answer.status_code for answer in refused} == {409}
        assert {answer.status_code for answer in taken} == {202}
        assert len({answer.json()["shapes"][0] for answer in taken}) == count - 1
