"""Prototypes over HTTP: learned, listed, exchanged, deleted, and matched with."""

import hashlib
from dataclasses import replace
from typing import Any

import httpx2
import numpy as np
import pytest

from broker.contracts import MatchResult, PrototypeRecord, PrototypeResult
from broker.queue import JobQueue, QueueSettings
from broker.store import DEFAULT_KEYS
from service.standalone import EmbeddedServer
from solver.mesh import read_mesh
from solver.prototype import match_prototype, prototype_from_bytes, prototype_to_bytes
from solver.shape import Shape
from tests.service.conftest import Api, Json, Upload, idle_api, problem, put_shapes
from tests.solver import shapes
from tests.worker.families import family
from tests.worker.figures import blob_file, off, two_blobs_file
from tests.worker.records import shape_record
from worker.jobs.runner import Runner

QUICK: Json = {"points": 8, "components": 2, "eigenpairs": 30}
SHARED: Json = {**QUICK, "correspondence": "shared_connectivity"}


@pytest.fixture(scope="module")
def examples(upload: Upload) -> list[str]:
    """Five shapes of one connectivity."""
    return [upload(data)["id"] for data in family(5)]


def learn(http: httpx2.Client, body: Json) -> PrototypeResult:
    asked = http.post("/v1/prototypes", json=body)
    assert asked.status_code == 202, asked.text
    job: Json = http.get(asked.json()["links"]["self"], params={"wait": 60}).json()
    assert job["state"] == "succeeded", job["error"]
    assert job["kind"] == "prototype"
    assert job["links"]["resource"] == f"/v1/prototypes/{job['prototype']}"
    return PrototypeResult.model_validate_json(http.get(job["links"]["result"]).content)


@pytest.fixture(scope="module")
def prototype(http: httpx2.Client, examples: list[str]) -> PrototypeRecord:
    return learn(http, {"shapes": examples, "name": "blob", **SHARED}).prototype


@pytest.fixture(scope="module")
def archive(http: httpx2.Client, prototype: PrototypeRecord) -> bytes:
    return http.get(f"/v1/prototypes/{prototype.id}/archive").content


def send(http: httpx2.Client, data: bytes, name: str | None = None) -> httpx2.Response:
    form = {} if name is None else {"name": name}
    files = {"file": ("mine.npz", data)}
    return http.post("/v1/prototype-archives", files=files, data=form)


def test_a_prototype_is_learned(
    http: httpx2.Client, examples: list[str], prototype: PrototypeRecord, archive: bytes
) -> None:
    assert prototype.id == "p-" + hashlib.sha256(archive).hexdigest()[:32]
    assert prototype.bytes == len(archive)
    assert (prototype.name, prototype.points, prototype.components) == ("blob", 8, 2)
    assert prototype.examples == len(examples)
    assert prototype.surfaces == len(examples)
    assert prototype.reference == examples[0]
    assert prototype.learned_from is not None
    assert [one.shape for one in prototype.learned_from] == examples
    assert all(one.used and one.reason is None for one in prototype.learned_from)
    assert [choice.name for choice in prototype.parameters.metrics] == ["geodesic"]
    assert prototype.parameters.eigenpairs == 30
    shown = http.get(f"/v1/prototypes/{prototype.id}")
    assert PrototypeRecord.model_validate_json(shown.content) == prototype
    read = prototype_from_bytes(archive)
    assert (read.points, read.examples) == (8, 5)


def test_versions_of_a_name(http: httpx2.Client, examples: list[str]) -> None:
    body = {"shapes": examples, "name": "versions", **SHARED}
    first = learn(http, {**body, "components": 1}).prototype
    again = learn(http, {**body, "components": 1})
    second = learn(http, {**body, "components": 1, "points": 6}).prototype
    assert (first.version, second.version) == (1, 2)
    assert (again.prototype, again.warnings) == (first, ())
    other = learn(http, {**body, "components": 1, "name": "another"})
    assert other.prototype == first
    assert "version 1 of 'versions'" in other.warnings[0]
    found = http.get("/v1/prototypes", params={"name": "versions"}).json()["items"]
    assert [item["id"] for item in found] == [second.id, first.id]
    assert http.get("/v1/prototypes", params={"name": "another"}).json()["items"] == []
    # A number is never given twice.
    assert http.delete(f"/v1/prototypes/{second.id}").status_code == 204
    third = learn(http, {**body, "components": 1, "points": 6}).prototype
    assert (third.id, third.version) == (second.id, 3)


def test_listing(http: httpx2.Client, prototype: PrototypeRecord) -> None:
    seen: list[str] = []
    cursor: str | None = None
    while True:
        after = {} if cursor is None else {"cursor": cursor}
        page = http.get("/v1/prototypes", params={"limit": 1, **after})
        seen += [item["id"] for item in page.json()["items"]]
        cursor = page.json()["next_cursor"]
        if cursor is None:
            break
    assert len(seen) == len(set(seen))
    assert prototype.id in seen
    refused = http.get("/v1/prototypes", params={"cursor": "nonsense"})
    assert problem(refused, 422, "invalid-request")["errors"][0]["field"] == "query.cursor"


def test_a_downloaded_archive_uploads_as_the_same_prototype(
    http: httpx2.Client, prototype: PrototypeRecord, archive: bytes
) -> None:
    answer = http.get(f"/v1/prototypes/{prototype.id}/archive")
    assert answer.headers["content-type"] == "application/octet-stream"
    assert f"{prototype.id}.npz" in answer.headers["content-disposition"]
    known = send(http, archive, "under another name")
    assert known.status_code == 200
    assert PrototypeRecord.model_validate_json(known.content) == prototype
    assert http.delete(f"/v1/prototypes/{prototype.id}").status_code == 204
    path = f"/v1/prototypes/{prototype.id}"
    for gone in (http.get(path), http.get(f"{path}/archive"), http.delete(path)):
        problem(gone, 404, "prototype-not-found")
    again = send(http, archive, "elsewhere")
    assert again.status_code == 201
    assert again.headers["location"] == path
    record = PrototypeRecord.model_validate_json(again.content)
    assert (record.id, record.name, record.version) == (prototype.id, "elsewhere", 1)
    assert (record.learned_from, record.reference) == (None, None)
    assert record.parameters == prototype.parameters
    assert http.get(f"{path}/archive").content == archive
    named = [item["id"] for item in http.get("/v1/prototypes?name=elsewhere").json()["items"]]
    assert named == [record.id]


@pytest.mark.parametrize(("unit", "surfaces"), [(1e30, 3), (1e-30, 3), (1e60, 0)])
def test_what_was_learned_in_any_unit_can_be_uploaded_again(
    http: httpx2.Client, upload: Upload, unit: float, surfaces: int
) -> None:
    meshes = [read_mesh(data, "off") for data in family(3)]
    examples = [upload(off(unit * mesh.vertices, mesh.faces))["id"] for mesh in meshes]
    learned = learn(http, {"shapes": examples, "name": "huge", **SHARED}).prototype
    path = f"/v1/prototypes/{learned.id}"
    archive = http.get(f"{path}/archive").content
    assert http.delete(path).status_code == 204
    again = send(http, archive)
    assert again.status_code == 201, again.text
    assert (again.json()["id"], again.json()["surfaces"]) == (learned.id, surfaces)
    body = {"source": learned.id, "target": examples[0]}
    job = http.post("/v1/matches", json=body).json()
    ended = http.get(job["links"]["self"], params={"wait": 60}).json()
    assert ended["state"] == "succeeded", ended["error"]
    assert http.get(f"{job['links']['self']}/result.png").status_code == 200


def test_a_match_with_a_prototype_is_that_of_the_solver(
    http: httpx2.Client, upload: Upload, archive: bytes
) -> None:
    prototype = send(http, archive).json()["id"]
    (data,) = family(1, first=50)
    target = upload(data)["id"]
    job = http.post("/v1/matches", json={"source": prototype, "target": target}).json()
    ended = http.get(job["links"]["self"], params={"wait": 60}).json()
    assert ended["state"] == "succeeded", ended["error"]
    result = MatchResult.model_validate_json(http.get(job["links"]["result"]).content)
    shape = Shape(read_mesh(data, "off"), eigenpairs=30)
    direct = match_prototype(prototype_from_bytes(archive), shape)
    assert result.parameters.orientation
    assert (result.source_kind, result.source, result.target) == ("prototype", prototype, target)
    assert [pair.source for pair in result.correspondences] == direct.best.source.tolist()
    assert [pair.target for pair in result.correspondences] == direct.best.target.tolist()
    assert set(direct.best.source.tolist()) == set(range(8))
    assert result.energy == pytest.approx(direct.best.energy, rel=1e-9)
    assert result.lower_bound == pytest.approx(direct.lower_bound, rel=1e-9)
    assert direct.misfit is not None
    assert result.misfit == pytest.approx(direct.misfit, rel=1e-9)
    assert (result.parameters.points, result.parameters.eigenpairs) == (8, 30)
    assert [choice.name for choice in result.parameters.metrics] == ["geodesic"]
    picture = http.get(job["links"]["picture"])
    assert picture.headers["content-type"] == "image/png"
    assert picture.content.startswith(b"\x89PNG")
    assert not any("points were asked for" in one for one in result.warnings)
    beyond = {"source": prototype, "target": target, "points": 12}
    job = http.post("/v1/matches", json=beyond).json()
    http.get(job["links"]["self"], params={"wait": 60})
    more = http.get(job["links"]["result"]).json()
    assert len(more["correspondences"]) == 8
    assert "12 points were asked for: the prototype has 8" in more["warnings"]


def test_examples_are_matched_or_their_correspondences_given(
    http: httpx2.Client, examples: list[str], upload: Upload
) -> None:
    odd = upload(blob_file(3, seed=77))["id"]
    body = {"shapes": [*examples, odd], "reference": examples[1], "name": "matched", **QUICK}
    learned = learn(http, body)
    record = learned.prototype
    assert record.reference == examples[1]
    assert record.learned_from is not None
    assert [one.used for one in record.learned_from][:1] == [True]
    assert all(one.used or one.reason for one in record.learned_from)
    assert record.examples == sum(one.used for one in record.learned_from)
    assert {"spectra of the examples", "matches of the examples", "total"} <= set(learned.timings)
    rows = [[5, 0, 9, 40, 77, 120]] * len(examples)
    given = {"shapes": examples, "correspondences": rows, "name": "given", "components": 1}
    told = learn(http, {**given, "metric": ["commute_time", "geodesic"], "descriptor": "none"})
    assert (told.prototype.points, told.parameters.points) == (6, 6)
    with_four = learn(http, {**given, "points": 4, "metric": "geodesic", "descriptor": "none"})
    data = http.get(f"/v1/prototypes/{with_four.prototype.id}/archive").content
    assert set(prototype_from_bytes(data).vertices.tolist()) < set(rows[0])


@pytest.mark.parametrize(
    ("change", "field", "word"),
    [
        ({"shapes": []}, "body.shapes", "at least 2"),
        ({"shapes": ["a"] * 257}, "body.shapes", "at most 256"),
        ({"points": 2}, "body.points", "3"),
        ({"components": 17}, "body.components", "16"),
        ({"metric": "euclid"}, "body.metric", "geodesic"),
        ({"descriptor": "eigenfunctions"}, "body.descriptor", "signs"),
        ({"descriptor": ["hks", "eigenfunctions"]}, "body.descriptor.1", "signs"),
        ({"descriptor": "photometric"}, "body.descriptor", "colours"),
        ({"name": "a\nb"}, "body.name", "one line"),
        ({"name": ""}, "body.name", "at least 1"),
        ({"reference": "nobody"}, "body.reference", "one of `shapes`"),
        ({"correspondence": "guess"}, "body.correspondence", "matches"),
        ({"correspondences": [[0, 1, 2]]}, "body.correspondences", "2, not 1"),
        ({"correspondences": [[0, 1, 2], [0, 1, 2, 3]]}, "body.correspondences", "has 4"),
        ({"correspondences": [[0, 1, 2], [0, 1, 1]]}, "body.correspondences", "repeats"),
        ({"correspondences": [[0, 1, -2], [0, 1, 2]]}, "body.correspondences.0.2", "0"),
        ({"correspondences": [[0, 1], [0, 1]]}, "body.correspondences.0", "at least 3"),
        ({"correspondences": [[0, 1, 2]] * 2, "points": 4}, "body.points", "3"),
        ({"correspondence": "shared_connectivity", "simplify": 100}, "body.simplify", "vertices"),
        ({"seed": -1}, "body.seed", "0"),
        ({"colour": "red"}, "body.colour", "no such field"),
    ],
)
def test_a_wrong_request_is_told_what_is_wrong(
    http: httpx2.Client, shapes: tuple[str, str], change: Json, field: str, word: str
) -> None:
    answer = http.post("/v1/prototypes", json={"shapes": shapes, **change})
    document = problem(answer, 422, "invalid-request")
    assert document["errors"][0]["field"] == field
    assert word in document["errors"][0]["message"]


def test_shapes_that_cannot_be_examples_are_named(
    http: httpx2.Client, upload: Upload, examples: list[str]
) -> None:
    one, other = examples[:2]
    coarse = upload(blob_file(1, seed=3))["id"]

    def refused(given: list[str], slug: str = "invalid-request", **more: Any) -> dict[str, str]:
        body = {"shapes": given, **more}
        document = problem(http.post("/v1/prototypes", json=body), 422, slug)
        return {error["field"]: error["message"] for error in document["errors"]}

    few = refused([one, other], simplify=100, points=101)
    assert "shapes.0, shapes.1 would have 100 vertices" in few["body.simplify"]
    assert refused([one, "nobody"], "unknown-shape").keys() == {"body.shapes.1"}
    assert "shapes.0" in refused([one, other, one])["body.shapes.2"]
    assert "42 vertices" in refused([one, coarse], points=50)["body.shapes.1"]
    alike = refused([one, coarse], correspondence="shared_connectivity")
    assert "connectivity" in alike["body.shapes.1"]


def test_correspondences_at_no_vertex_are_refused_by_their_place(
    http: httpx2.Client, examples: list[str]
) -> None:
    body = {"shapes": examples[:2], "correspondences": [[0, 1, 2], [0, 162, 1]], **QUICK}
    answer = http.post("/v1/prototypes", json={**body, "points": 3})
    assert problem(answer, 422, "invalid-request")["errors"] == [
        {
            "field": "body.correspondences.1.1",
            "message": "162 is no vertex of shapes.1, whose file has vertices 0 to 161",
            "pointer": "/correspondences/1/1",
        }
    ]


def failed(http: httpx2.Client, body: Json) -> Json:
    job = http.post("/v1/prototypes", json=body).json()
    ended = http.get(job["links"]["self"], params={"wait": 60}).json()
    assert ended["state"] == "failed"
    error: Json = ended["error"]
    return error


def test_errors_found_while_learning_name_the_field(
    http: httpx2.Client, upload: Upload, examples: list[str]
) -> None:
    mesh = read_mesh(family(1)[0], "off")
    turned = upload(off(mesh.vertices, np.roll(mesh.faces, 1, axis=0)))["id"]
    error = failed(http, {"shapes": [examples[0], turned], **SHARED})
    assert error["errors"][0]["field"] == "body.shapes.1"


def test_a_class_of_one_shape_is_not_learned(
    http: httpx2.Client, upload: Upload, examples: list[str]
) -> None:
    """No registration reaches a needle from a blob, so one example is left."""
    needle = shapes.tube()
    other = upload(off(needle.vertices, needle.faces), "needle.off")["id"]
    error = failed(http, {"shapes": [examples[0], other], **QUICK})
    (wrong,) = error["errors"]
    assert wrong["field"] == "body.shapes"
    assert "shapes.1: left out, for " in wrong["message"]
    assert "2 examples or more" in wrong["message"]


@pytest.mark.parametrize(
    ("change", "field", "word"),
    [
        ({"refine": "gmds"}, "body.refine", "not supported"),
        ({"dense": True}, "body.dense", "not supported"),
        ({"landmarks": [[0, 3]]}, "body.landmarks", "not supported"),
        ({"third_order": 0.1}, "body.third_order", "not supported"),
        ({"objective": "linf", "points": 8}, "body.objective", 'only "l2"'),
        ({"metric": "diffusion"}, "body.metric", "learned with"),
        ({"descriptor": "none"}, "body.descriptor", "learned with"),
        ({"eigenpairs": 60}, "body.eigenpairs", "learned with"),
        ({"normalise": False}, "body.normalise", "learned with"),
        ({"points": 2}, "body.points", "3"),
        ({"partial": "source"}, "body.partial", "not supported"),
        ({"partial": "both"}, "body.partial", "not supported"),
    ],
)
def test_parameters_not_supported_with_a_prototype(
    http: httpx2.Client, archive: bytes, examples: list[str], change: Json, field: str, word: str
) -> None:
    body = {"source": send(http, archive).json()["id"], "target": examples[0], **change}
    document = problem(http.post("/v1/matches", json=body), 422, "invalid-request")
    assert [error["field"] for error in document["errors"]] == [field]
    assert word in document["errors"][0]["message"]


def test_orientation_is_that_of_the_surfaces_of_examples(
    http: httpx2.Client, archive: bytes, examples: list[str]
) -> None:
    """And an archive of old, which has none, is read, and matched without."""
    bare = prototype_to_bytes(replace(prototype_from_bytes(archive), surfaces=()))
    ids = {data: send(http, data, "any").json()["id"] for data in (archive, bare)}
    assert http.get(f"/v1/prototypes/{ids[bare]}").json()["surfaces"] == 0
    for data, given, expected in (
        (archive, {}, True),
        (archive, {"orientation": False}, False),
        (bare, {}, False),
        (bare, {"orientation": True}, False),
    ):
        body = {"source": ids[data], "target": examples[0], **given}
        job = http.post("/v1/matches", json=body).json()
        ended = http.get(job["links"]["self"], params={"wait": 60}).json()
        assert ended["state"] == "succeeded", ended["error"]
        result = http.get(job["links"]["result"]).json()
        assert result["parameters"]["orientation"] is expected
        assert result["confidence"] is None


def test_shapes_that_cannot_be_matched_with_a_prototype(
    http: httpx2.Client, archive: bytes, upload: Upload, examples: list[str]
) -> None:
    prototype = send(http, archive).json()["id"]
    several = upload(two_blobs_file())["id"]

    def refused(slug: str, **body: Any) -> list[str]:
        document = problem(http.post("/v1/matches", json=body), 422, slug)
        return [error["field"] for error in document["errors"]]

    nobody = "p-" + "0" * 32
    assert refused("unknown-prototype", source=nobody, target=examples[0]) == ["body.source"]
    assert refused("unknown-shape", source=prototype, target="nobody") == ["body.target"]
    assert refused("unknown-shape", source=prototype, target=prototype) == ["body.target"]
    # What is given as the prototype has it is no contradiction.
    body = {"source": prototype, "target": several, "largest_component": True}
    body |= {"eigenpairs": 30, "metric": "geodesic", "descriptor": ["si_hks"], "points": 6}
    job = http.post("/v1/matches", json=body).json()
    ended = http.get(job["links"]["self"], params={"wait": 60}).json()
    assert ended["state"] == "succeeded", ended["error"]
    result = http.get(job["links"]["result"]).json()
    assert sorted(pair["source"] for pair in result["correspondences"]) == list(range(6))


def test_a_shape_is_not_simplified_below_the_points_of_a_prototype(
    http: httpx2.Client, server: EmbeddedServer, archive: bytes
) -> None:
    with idle_api(server) as api, httpx2.Client(base_url=api.url, timeout=60.0) as idle:
        (target, other) = put_shapes(api)
        large = shape_record(target).model_copy(update={"vertices": 500})
        api.store.client.set(DEFAULT_KEYS.shape(target), large.model_dump_json())
        record = PrototypeRecord.model_validate_json(send(http, archive).content)
        api.store.prototypes.add(record.model_copy(update={"points": 120}), archive, b"")
        body = {"source": record.id, "target": target, "simplify": 100, "points": 101}
        document = problem(idle.post("/v1/matches", json=body), 422, "invalid-request")
        assert [error["field"] for error in document["errors"]] == ["body.simplify"]
        assert "target would have 100 vertices" in document["errors"][0]["message"]
        for fits in ({"points": 100}, {"simplify": 101}, {"target": other}):
            assert idle.post("/v1/matches", json=body | fits).status_code == 202


def test_a_learned_prototype_has_no_picture(http: httpx2.Client, examples: list[str]) -> None:
    job = http.post("/v1/prototypes", json={"shapes": examples, **SHARED}).json()
    assert job["links"]["picture"] is None
    http.get(job["links"]["self"], params={"wait": 60})
    problem(http.get(f"{job['links']['result']}.png"), 409, "job-without-result")
    problem(http.get(f"{job['links']['result']}.npz"), 409, "job-without-result")


def test_uploads_as_they_should_be_and_not(http: httpx2.Client, archive: bytes) -> None:
    assert send(http, archive).status_code in (200, 201)
    refused = http.post("/v1/prototype-archives", files={"name": (None, "nothing")})
    assert problem(refused, 422, "invalid-request")["errors"][0]["field"] == "body.file"
    answer = send(http, archive, "a\nb")
    assert problem(answer, 422, "invalid-request")["errors"][0]["field"] == "body.name"
    keyed = {"Idempotency-Key": "prototype-key"}
    for data, status in ((archive, 200), (archive + b" ", 409)):
        files = {"file": ("mine.npz", data)}
        again = http.post("/v1/prototype-archives", files=files, headers=keyed)
        assert again.status_code == status


def test_a_learning_that_is_cancelled_leaves_nothing(http: httpx2.Client, upload: Upload) -> None:
    shapes = [upload(data)["id"] for data in family(8, subdivisions=3)]
    body = {"shapes": shapes, "points": 64, "eigenpairs": 40, "name": "never"}
    job: Json = http.post("/v1/prototypes", json=body).json()
    seen = []
    while job["progress"]["stage"] != "matches of the examples":
        assert job["state"] in ("queued", "running"), job
        job = http.get(job["links"]["self"]).json()
        seen.append(job["progress"]["fraction"])
    assert seen == sorted(seen)
    problem(http.get(job["links"]["result"]), 409, "result-not-ready")
    assert http.delete(job["links"]["self"]).json()["state"] in ("running", "cancelled")
    ended = http.get(job["links"]["self"], params={"wait": 60}).json()
    assert ended["state"] == "cancelled"
    problem(http.get(job["links"]["result"]), 409, "job-without-result")
    assert http.get("/v1/prototypes", params={"name": "never"}).json()["items"] == []


def test_a_request_is_the_same_when_it_comes_again(
    http: httpx2.Client, examples: list[str]
) -> None:
    body = {"shapes": examples, "name": "once", **SHARED}
    keyed = {"Idempotency-Key": "learn-once"}
    jobs = {http.post("/v1/prototypes", json=body, headers=keyed).json()["id"] for _ in range(3)}
    assert len(jobs) == 1
    other = http.post("/v1/prototypes", json={**body, "points": 6}, headers=keyed)
    problem(other, 409, "idempotency-key-reused")
    (job,) = jobs
    assert http.get(f"/v1/jobs/{job}", params={"wait": 60}).json()["state"] == "succeeded"
    counted = http.get("/metrics").text
    assert 'isomatch_jobs_ended_total{kind="prototype",state="succeeded"}' in counted
    assert 'stage="spectra of the examples"' in counted
    assert "isomatch_prototypes " in counted


def test_a_match_whose_prototype_is_deleted_meanwhile(
    http: httpx2.Client, server: EmbeddedServer, archive: bytes
) -> None:
    # No worker serves this database: the test does what one would do.
    with idle_api(server) as api, httpx2.Client(base_url=api.url, timeout=60.0) as idle:
        (target, _) = put_shapes(api)
        record = PrototypeRecord.model_validate_json(send(http, archive).content)
        api.store.prototypes.add(record, archive, b"")
        api.store.spectra.put(f"{record.id}:surface0", b"spectrum")
        body = {"source": record.id, "target": target}
        job = idle.post("/v1/matches", json=body).json()["id"]
        assert idle.delete(f"/v1/prototypes/{record.id}").status_code == 204
        assert api.store.spectra.get(f"{record.id}:surface0") is None
        runner = Runner(JobQueue(api.store, QueueSettings()), "me")
        runner.run(job)
        ended = idle.get(f"/v1/jobs/{job}").json()
        assert (ended["state"], ended["error"]["status"]) == ("failed", 410)
        assert ended["error"]["type"].endswith(":prototype-deleted")
        assert record.id in ended["error"]["detail"]


def test_an_expired_prototype_is_reported_as_expired(
    http: httpx2.Client, api: Api, archive: bytes
) -> None:
    record = send(http, archive).json()
    path = f"/v1/prototypes/{record['id']}"
    store = api.store.client
    assert (
        0
        < store.ttl(DEFAULT_KEYS.prototype(record["id"]))
        <= api.store.prototypes.settings.shape_ttl
    )
    names = (
        DEFAULT_KEYS.prototype,
        DEFAULT_KEYS.prototype_archive,
        DEFAULT_KEYS.prototype_geometry,
    )
    store.delete(*(name(record["id"]) for name in names))
    for gone in (http.get(path), http.get(f"{path}/archive"), http.get(f"{path}/geometry")):
        problem(gone, 410, "prototype-expired")
    match = http.post("/v1/matches", json={"source": record["id"], "target": "x"})
    assert "no longer kept" in problem(match, 422, "unknown-prototype")["errors"][0]["message"]
    listed = http.get("/v1/prototypes").json()["items"]
    assert record["id"] not in [item["id"] for item in listed]
    assert send(http, archive).status_code == 201
