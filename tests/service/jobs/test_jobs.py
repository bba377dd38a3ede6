"""Matches and their jobs over HTTP: asked for, waited for, cancelled, fetched, drawn, refused."""

import json
import threading
import time
from collections.abc import Iterator
from datetime import datetime

import httpx2
import numpy as np
import pytest
from rq.utils import now, utcformat
from rq.worker_registration import REDIS_WORKER_KEYS

from broker.contracts import JobKind, MatchResult, MatchSummary, PicturePayload
from broker.store import DEFAULT_KEYS
from service.standalone import EmbeddedServer
from tests.service.conftest import WORKERS, Api, Json, Upload, idle_api, problem, put_shapes
from tests.service.matching import Shapes, ask, matched, wait
from tests.service.test_blobs import path_of
from tests.waiting import until
from tests.worker.figures import blob, blob_file, off

QUICK = {"points": 8, "eigenpairs": 30, "orientation": False}
LONG = {"points": 256, "coarse_points": 10, "alternatives": 32}
"""Parameters of a match that lasts, on a larger shape."""


def test_the_way_of_a_match(http: httpx2.Client, shapes: Shapes) -> None:
    body = {"source": shapes[0], "target": shapes[1], **QUICK}
    asked = http.post("/v1/matches", json=body)
    assert asked.status_code == 202
    job = asked.json()
    assert asked.headers["location"] == job["links"]["self"] == f"/v1/jobs/{job['id']}"
    assert job["kind"] == "match"
    assert job["state"] in ("queued", "running")
    assert set(job["progress"]) == {"stage", "fraction"}
    done = wait(http, job)
    assert done["state"] == "succeeded", done["error"]
    assert done["progress"]["fraction"] == 1.0
    assert done["position"] is None
    assert done["error"] is None
    times = [datetime.fromisoformat(done[name]) for name in ("created", "started", "ended")]
    assert times == sorted(times)
    answer = http.get(done["links"]["result"])
    assert answer.status_code == 200
    assert answer.headers["content-type"] == "application/json"
    result = MatchResult.model_validate_json(answer.content)
    assert (result.source, result.target) == shapes
    assert result.parameters.points == 8
    assert result.parameters.beta == 1.0
    assert len(result.correspondences) == 8
    assert all(0 <= pair.source < 642 for pair in result.correspondences)
    assert result.timings["total"] > 0
    assert (result.kind, result.job) == ("match", job["id"])
    summary = MatchSummary.model_validate(done["summary"])
    assert summary.confidence == result.confidence
    assert (summary.energy, summary.gap) == (result.energy, result.gap)
    assert summary.warnings == result.warnings
    (listed,) = (one for one in http.get("/v1/jobs").json()["items"] if one["id"] == job["id"])
    assert listed["summary"] == done["summary"]


def test_a_result_is_compressed_for_those_who_can(http: httpx2.Client, shapes: Shapes) -> None:
    path = matched(http, shapes, **QUICK)["links"]["result"]
    packed = http.get(path, headers={"Accept-Encoding": "gzip"})
    plain = http.get(path, headers={"Accept-Encoding": "identity"})
    assert packed.headers["content-encoding"] == "gzip"
    assert "content-encoding" not in plain.headers
    assert packed.json() == plain.json()
    assert int(packed.headers["content-length"]) < len(plain.content)


def test_the_picture(http: httpx2.Client, shapes: Shapes, api: Api) -> None:
    job = matched(http, shapes, **QUICK)
    first = http.get(job["links"]["picture"])
    assert first.status_code == 200, first.text
    assert first.headers["content-type"] == "image/png"
    assert first.content.startswith(b"\x89PNG")
    assert api.store.results.picture(PicturePayload(job=job["id"])) == first.content
    assert http.get(job["links"]["picture"]).content == first.content
    plain = http.get(job["links"]["picture"], headers={"accept": "application/octet-stream"})
    assert plain.headers["content-type"] == "application/octet-stream"
    assert plain.content == first.content
    # Jobs that only serve others are not listed.
    kinds = {item["kind"] for item in http.get("/v1/jobs").json()["items"]}
    assert "match" in kinds
    assert all(JobKind(kind).has_result for kind in kinds)


def test_records_of_a_newer_version_do_not_break_listings(server: EmbeddedServer) -> None:
    with idle_api(server) as api, httpx2.Client(base_url=api.url, timeout=60.0) as http:
        shapes = put_shapes(api)
        unread, other = (ask(http, shapes)["id"] for _ in range(2))
        record = api.store.client.hget(DEFAULT_KEYS.job(unread), "record")
        assert record is not None
        document = json.loads(record)
        document["payload"]["parameters"]["novel"] = 1
        api.store.client.hset(DEFAULT_KEYS.job(unread), "record", json.dumps(document))
        assert [job["id"] for job in http.get("/v1/jobs").json()["items"]] == [other]
        refused = http.get(f"/v1/jobs/{unread}")
        assert "upgraded" in problem(refused, 503, "newer-version")["detail"]
        assert refused.headers["retry-after"] == "10"


def test_pictures_of_alternatives(http: httpx2.Client, shapes: Shapes, api: Api) -> None:
    job = matched(http, shapes, **QUICK)
    path = job["links"]["picture"]
    count = len(http.get(job["links"]["result"]).json()["alternatives"])
    assert count
    drawn = [http.get(path, params={"alternative": which}).content for which in range(count + 1)]
    assert all(picture.startswith(b"\x89PNG") for picture in drawn)
    assert len(set(drawn)) == count + 1
    # Nothing was refined or extended: the match itself is what is drawn of it anyway.
    assert http.get(path).content == drawn[0]
    assert api.store.results.picture(PicturePayload(job=job["id"], alternative=1)) == drawn[1]
    for wrong, said in ((count + 1, f"it has {count}"), (33, "less than"), (-1, "greater than")):
        refused = problem(http.get(path, params={"alternative": wrong}), 422, "invalid-request")
        (wrong_field,) = refused["errors"]
        assert wrong_field["field"] == "query.alternative"
        assert said in wrong_field["message"]
    refused = http.get(path, params={"alternative": count + 1}).json()
    assert refused["detail"] == (
        f"The match has no alternative {count + 1}: it has {count}, numbered from 1; 0 is the match"
        " itself."
    )
    assert [one["field"] for one in refused["errors"]] == ["query.alternative"]
    assert refused["instance"] == path


def test_files_are_named_after_the_shapes(http: httpx2.Client, shapes: Shapes) -> None:
    job = matched(http, shapes, **QUICK, source_name="Fuß.off", target_name="b/c.2.ply")
    for link, ending in ((job["links"]["exports"][0], "csv"), (job["links"]["arrays"], "npz")):
        for answer in (http.get(link), http.head(link)):
            assert answer.headers["content-disposition"] == (
                f'attachment; filename="Fu_-to-b_c.2.{ending}";'
                f" filename*=UTF-8''Fu%C3%9F-to-b_c.2.{ending}"
            )


def test_files_of_deleted_shapes(http: httpx2.Client, upload: Upload) -> None:
    """A table needs no shape."""
    shape = upload(blob_file(2, seed=40))["id"]
    job = matched(http, (shape, shape), **QUICK)
    http.delete(f"/v1/shapes/{shape}")
    problem(http.get(job["links"]["picture"]), 410, "shape-deleted")
    (table,) = job["links"]["exports"]
    assert http.get(table).text.startswith("source,target")


def test_listing(http: httpx2.Client, shapes: Shapes) -> None:
    ids = [matched(http, shapes, **QUICK)["id"] for _ in range(3)]
    page = http.get("/v1/jobs", params={"limit": 2}).json()
    assert [item["id"] for item in page["items"]] == ids[:0:-1]
    rest = http.get("/v1/jobs", params={"limit": 2, "cursor": page["next_cursor"]}).json()
    assert rest["items"][0]["id"] == ids[0]
    in_state = {
        state: http.get("/v1/jobs", params={"state": state}).json()["items"]
        for state in ("queued", "running", "succeeded", "failed", "cancelled")
    }
    for state, items in in_state.items():
        assert {item["state"] for item in items} <= {state}
    assert ids[0] in [item["id"] for item in in_state["succeeded"]]
    either: Json = {"state": ["failed", "succeeded"], "limit": 2}
    page = http.get("/v1/jobs", params=either).json()
    assert {item["state"] for item in page["items"]} <= {"failed", "succeeded"}
    further = http.get("/v1/jobs", params=either | {"cursor": page["next_cursor"]}).json()
    found = [item["id"] for item in (*page["items"], *further["items"])]
    assert found[:3] == ids[::-1]


def test_a_second_match_computes_no_spectrum(http: httpx2.Client, upload: Upload, api: Api) -> None:
    shapes = upload(blob_file(seed=41))["id"], upload(blob_file(seed=42))["id"]
    before = api.store.spectra.counts()
    matched(http, shapes, **QUICK)
    assert api.store.spectra.counts().computed == before.computed + 2
    matched(http, shapes, **QUICK | {"points": 10})
    assert api.store.spectra.counts().computed == before.computed + 2


@pytest.fixture
def idle(server: EmbeddedServer) -> Iterator[tuple[httpx2.Client, Api]]:
    """An API that no worker serves, with two shapes: whatever is asked stays queued."""
    with (
        idle_api(server, picture_wait=0.1) as api,
        httpx2.Client(base_url=api.url, timeout=30.0) as http,
    ):
        yield http, api


def test_a_job_that_waits_for_its_spectra_says_so(idle: tuple[httpx2.Client, Api]) -> None:
    http, api = idle
    shapes = put_shapes(api)
    client = api.store.client
    jobs = [ask(http, shapes, **QUICK) for _ in range(2)]
    # No worker is alive that could compute them.
    assert [job["progress"]["stage"] for job in jobs] == ["queued", "queued"]
    client.sadd(REDIS_WORKER_KEYS, "rq:worker:one")
    client.hset("rq:worker:one", "last_heartbeat", utcformat(now()))
    jobs = [wait(http, job, 0) for job in jobs]
    assert [job["position"] for job in jobs] == [2, 3]
    # The two spectra are all that is ahead of the first.
    assert [job["progress"]["stage"] for job in jobs] == ["spectra", "queued"]
    assert [job["waiting_for"] for job in jobs] == ["turn", "turn"]
    for key in client.scan_iter("*spectrum*job*"):
        client.delete(key)
    assert wait(http, jobs[0], 0)["progress"]["stage"] == "queued"


def test_queued_jobs(idle: tuple[httpx2.Client, Api]) -> None:
    http, api = idle
    shapes = put_shapes(api)
    jobs = [
        ask(http, shapes, metric="geodesic", descriptor="none", orientation=False) for _ in range(3)
    ]
    assert [wait(http, job, 0)["position"] for job in jobs] == [0, 1, 2]
    assert {wait(http, job, 0)["waiting_for"] for job in jobs} == {"worker"}
    answer = http.delete(jobs[0]["links"]["self"])
    assert answer.status_code == 200
    assert answer.json()["state"] == "cancelled"
    assert answer.json()["ended"] is not None
    assert [wait(http, job, 0)["position"] for job in jobs] == [None, 0, 1]
    assert wait(http, jobs[0], 0)["waiting_for"] is None
    assert http.delete(jobs[0]["links"]["self"]).json() == answer.json()
    assert wait(http, jobs[0], 0)["links"]["result"] is None
    problem(http.get(jobs[0]["links"]["result"]), 409, "job-without-result")
    problem(http.get(jobs[1]["links"]["result"]), 409, "result-not-ready")
    problem(http.get(jobs[1]["links"]["picture"]), 409, "result-not-ready")
    # Spectra are queued once for each shape, before the matches.
    first, second = (ask(http, shapes) for _ in range(2))
    assert (first["position"], second["position"]) == (4, 5)


def test_a_result_is_read_by_the_worker_alone(idle: tuple[httpx2.Client, Api]) -> None:
    http, api = idle
    job = ask(http, put_shapes(api), metric="geodesic", descriptor="none", orientation=False)
    picture, jobs = job["links"]["picture"], api.store.jobs
    assert jobs.claim(job["id"], "runner")
    assert jobs.succeed(job["id"], "runner", b"{}")
    api.store.blobs.save(DEFAULT_KEYS.job_result(job["id"]), b"unreadable", 1000)
    problem(http.get(picture, params={"alternative": 1}), 503, "picture-not-ready")
    path_of(api.store, DEFAULT_KEYS.job_result(job["id"])).unlink()
    problem(http.get(picture, params={"view": "left"}), 410, "content-lost")


def test_a_picture_whose_result_is_deleted_meanwhile(idle: tuple[httpx2.Client, Api]) -> None:
    http, api = idle
    job = ask(http, put_shapes(api), metric="geodesic", descriptor="none", orientation=False)
    assert api.store.jobs.claim(job["id"], "runner")
    assert api.store.jobs.succeed(job["id"], "runner", b"{}")
    problem(http.get(job["links"]["picture"]), 503, "picture-not-ready")
    assert http.delete(f"/v1/jobs/{job['id']}/result").status_code == 204
    problem(http.get(job["links"]["picture"]), 410, "result-expired")


def test_a_long_poll_ends_with_the_time_or_the_job(idle: tuple[httpx2.Client, Api]) -> None:
    http, api = idle
    job = ask(http, put_shapes(api), metric="geodesic", descriptor="none", orientation=False)
    start = time.monotonic()
    assert wait(http, job, 0.5)["state"] == "queued"
    assert time.monotonic() - start >= 0.5
    timer = threading.Timer(0.3, lambda: api.store.jobs.cancel(job["id"]))
    timer.start()
    # The client waits half as long for an answer, which is there before the time is over.
    assert wait(http, job, 60)["state"] == "cancelled"
    timer.join()


def test_a_running_job_is_cancelled(http: httpx2.Client, upload: Upload) -> None:
    shape = upload(blob_file(4))["id"]
    job, *others = (ask(http, (shape, shape), **LONG) for _ in range(WORKERS + 1))
    until(lambda: wait(http, job, 0)["progress"]["fraction"] >= 0.4)
    # All workers are busy.
    assert wait(http, others[-1], 0)["waiting_for"] == "turn"
    for other in others:
        http.delete(other["links"]["self"])
    assert http.delete(job["links"]["self"]).json()["state"] in ("running", "cancelled")
    assert wait(http, job)["state"] == "cancelled"
    problem(http.get(job["links"]["result"]), 409, "job-without-result")
    matched(http, (shape, shape), **QUICK)


def test_jobs_of_nobody(http: httpx2.Client) -> None:
    for path in ("", "/result", "/result.png"):
        problem(http.get(f"/v1/jobs/nobody{path}"), 404, "job-not-found")
    problem(http.get("/v1/jobs/nobody", params={"wait": 5}), 404, "job-not-found")
    problem(http.delete("/v1/jobs/nobody"), 404, "job-not-found")


def test_results_expire(http: httpx2.Client, shapes: Shapes, api: Api) -> None:
    job = matched(http, shapes, **QUICK)
    api.store.client.delete(DEFAULT_KEYS.job_result(job["id"]))
    problem(http.get(job["links"]["result"]), 410, "result-expired")
    problem(http.get(job["links"]["picture"]), 410, "result-expired")
    links = http.get(job["links"]["self"]).json()["links"]
    assert [links[name] for name in ("result", "picture", "arrays")] == [None] * 3
    assert links["exports"] == []


def test_a_failed_job_says_why(http: httpx2.Client, upload: Upload, shapes: Shapes) -> None:
    # A vertex that no face uses is in the file, but not on the surface.
    vertices, faces = blob(2, seed=31)
    loose = upload(off(np.vstack([vertices, [[0.0, 0.0, 0.0]]]), faces))["id"]
    landmarks = [[1, 1], [2, len(vertices)]]
    job = wait(http, ask(http, (shapes[0], loose), **QUICK, landmarks=landmarks))
    assert job["state"] == "failed"
    assert job["error"]["status"] == 422
    assert job["error"]["instance"] == job["links"]["self"]
    assert "landmarks" in job["error"]["detail"]
    (error,) = job["error"]["errors"]
    assert error["field"].startswith("body.landmarks")
    assert job["links"]["result"] is job["links"]["picture"] is job["links"]["arrays"] is None
    assert job["links"]["exports"] == job["links"]["registered"] == []
    assert job["summary"] is None
    refused = problem(http.get(f"/v1/jobs/{job['id']}/result"), 409, "job-without-result")
    assert job["error"]["detail"] in refused["detail"]


def test_unknown_shapes(http: httpx2.Client, shapes: Shapes) -> None:
    body = {"source": "nobody", "target": shapes[1]}
    document = problem(http.post("/v1/matches", json=body), 422, "unknown-shape")
    assert [error["field"] for error in document["errors"]] == ["body.source"]
    body = {"source": "nobody", "target": "0" * 32}
    document = problem(http.post("/v1/matches", json=body), 422, "unknown-shape")
    assert [error["field"] for error in document["errors"]] == ["body.source", "body.target"]


def test_shapes_that_cannot_be_matched_are_named(
    http: httpx2.Client, upload: Upload, shapes: Shapes
) -> None:
    def refused(source: str, target: str, **more: object) -> dict[str, str]:
        body = {"source": source, "target": target, **more}
        document = problem(http.post("/v1/matches", json=body), 422, "invalid-request")
        return {error["field"]: error["message"] for error in document["errors"]}

    few = refused(*shapes, points=200, simplify=199)
    assert few.keys() == {"body.simplify"}
    assert "source, target would have 199 vertices" in few["body.simplify"]
    # What has fewer vertices already is not simplified.
    coarse = upload(blob_file(1, seed=5))["id"]
    assert "source would" in refused(shapes[0], coarse, points=200, simplify=199)["body.simplify"]
    matched(http, (coarse, coarse), **QUICK | {"points": 200}, simplify=199)


BAD_PARAMETERS = {
    "points": (2, 257, "many", 8.5, True, "8"),
    "coarse_points": (2, 11),
    "level_factor": (1, 5),
    "oversampling": (0, 9),
    "rho": (1.0, 4.5),
    "metric": ("euclidean", [], ["geodesic", "euclidean"], 3, {"name": "diffusion", "t": 1}),
    "descriptor": ("shot", [], ["none"] * 9),
    "beta": (-1, 1e7),
    "first_order_weight": (-0.1,),
    "third_order": (-0.1, 1e7, "0.1"),
    "occlusion_cost": (-1, 0),
    "diffusion_time": (0.01,),
    "normalise": ("no", 0),
    "eigenpairs": (9, 301),
    "alternatives": (0, 33),
    "objective": ("l1", 2),
    "refine": ("magic", True, "", ["gmds"]),
    "largest_component": ("yes", 1),
    "simplify": (99, 1_000_001, True, "500"),
    "time_limit": (0, -5),
    "pionts": (32,),
}


@pytest.mark.parametrize("name", BAD_PARAMETERS)
def test_bad_parameters(http: httpx2.Client, shapes: Shapes, name: str) -> None:
    for value in BAD_PARAMETERS[name]:
        body = {"source": shapes[0], "target": shapes[1], name: value}
        document = problem(http.post("/v1/matches", json=body), 422, "invalid-request")
        assert all(error["field"].startswith(f"body.{name}") for error in document["errors"])
        assert all(error["message"] for error in document["errors"])


@pytest.mark.parametrize("value", ["NaN", "Infinity", "-Infinity", "1e999"])
def test_numbers_that_are_none(http: httpx2.Client, shapes: Shapes, value: str) -> None:
    for name in ("beta", "points", "rho", "occlusion_cost", "time_limit"):
        body = f'{{"source": "{shapes[0]}", "target": "{shapes[1]}", "{name}": {value}}}'
        answer = http.post(
            "/v1/matches", content=body, headers={"content-type": "application/json"}
        )
        document = problem(answer, 422, "invalid-request")
        assert document["errors"][0]["field"] == f"body.{name}"


@pytest.mark.parametrize("body", ["", "{", "[]", "3", '"a"', "null", '{"source": 3}', "\udcff"])
def test_bodies_that_are_no_requests(http: httpx2.Client, body: str) -> None:
    content = body.encode("utf-8", "surrogateescape")
    headers = {"content-type": "application/json"}
    answer = http.post("/v1/matches", content=content, headers=headers)
    assert answer.status_code in (400, 422)
    problem(answer, answer.status_code, answer.json()["type"].rpartition(":")[2])


@pytest.mark.parametrize(
    "query",
    [
        {"wait": "-1"},
        {"wait": "61"},
        {"wait": "nan"},
        {"wait": "soon"},
    ],
)
def test_bad_waits(http: httpx2.Client, query: dict[str, str]) -> None:
    document = problem(http.get("/v1/jobs/nobody", params=query), 422, "invalid-request")
    assert document["errors"][0]["field"] == "query.wait"


@pytest.mark.parametrize(
    ("name", "value"),
    [("limit", "0"), ("limit", "201"), ("cursor", "nonsense"), ("state", "lost")],
)
def test_bad_listings(http: httpx2.Client, name: str, value: str) -> None:
    document = problem(http.get("/v1/jobs", params={name: value}), 422, "invalid-request")
    assert document["errors"][0]["field"].startswith(f"query.{name}")
