"""Requests that mean nothing: what is wrong is said of the sender's fields, and briefly."""

import gzip
import json
from collections.abc import Iterator
from typing import Any, cast

import httpx2
import pytest
from pydantic import ValidationError

from service.batches.schemas import BatchRequest
from service.consistent_maps.schemas import ConsistentMapsRequest
from service.dissimilarities.schemas import DissimilaritiesRequest
from service.jobs import JobRequest
from service.matches.schemas import MatchRequest
from service.prototypes.schemas import PrototypeRequest
from service.registrations.schemas import RegistrationRequest
from service.transfers.schemas import TransferRequest
from tests.service.conftest import Json, problem

MESH = ("m.off", b"OFF\n")
REQUESTS = (
    MatchRequest,
    BatchRequest,
    TransferRequest,
    DissimilaritiesRequest,
    RegistrationRequest,
    ConsistentMapsRequest,
    PrototypeRequest,
)


def ask(http: httpx2.Client, body: bytes, media_type: str = "application/json") -> httpx2.Response:
    return http.post("/v1/matches", content=body, headers={"content-type": media_type})


def fields(document: Json) -> dict[str, str]:
    named = {error["field"]: error["message"] for error in document["errors"]}
    assert len(named) == len(document["errors"])
    return named


@pytest.mark.parametrize(
    ("metric", "field"),
    [
        ("euclidean", "metric"),
        (3, "metric"),
        ({}, "metric.name"),
        ({"name": "euclidean"}, "metric.name"),
        ({"name": ["diffusion"]}, "metric.name"),
        ({"name": "diffusion", "time": "soon"}, "metric.time"),
        ({"name": "geodesic", "time": 0.1}, "metric.time"),
        (["geodesic", "euclidean"], "metric.1"),
        (["geodesic", {"name": "diffusion", "time": -1}], "metric.1.time"),
        ([["geodesic"]], "metric.0"),
        ([], "metric"),
    ],
)
def test_a_structure_is_named_by_its_place(http: httpx2.Client, metric: Any, field: str) -> None:
    body = {"source": "a", "target": "b", "metric": metric}
    named = fields(problem(http.post("/v1/matches", json=body), 422, "invalid-request"))
    assert f"body.{field}" in named
    assert len(named) == 1
    if metric in ("euclidean", 3):
        assert "'geodesic', 'diffusion', 'commute_time'" in named["body.metric"]


def test_parameters_of_a_descriptor_are_named_by_their_place(http: httpx2.Client) -> None:
    descriptor = ["hks", {"name": "hks", "times": [0.1, 0.0]}]
    body: dict[str, Any] = {"source": "a", "target": "b", "descriptor": descriptor}
    named = fields(problem(http.post("/v1/matches", json=body), 422, "invalid-request"))
    assert named == {"body.descriptor.1.times.1": "Input should be greater than 0"}
    for times, said in ([1e-31], "greater than or equal to 1e-30"), (3, "a list"):
        body["descriptor"] = {"name": "hks", "times": times}
        named = fields(problem(http.post("/v1/matches", json=body), 422, "invalid-request"))
        assert list(named.values()) == [f"Input should be {said}"]


@pytest.mark.parametrize(
    ("landmarks", "field", "wanted"),
    [({1: 2}, "landmarks", "a list of pairs"), ([1], "landmarks.0", "a pair")],
)
def test_landmarks_are_pairs(http: httpx2.Client, landmarks: Any, field: str, wanted: str) -> None:
    body = {"source": "a", "target": "b", "landmarks": landmarks}
    named = fields(problem(http.post("/v1/matches", json=body), 422, "invalid-request"))
    said = f"Input should be {wanted} [vertex of the source, vertex of the target]"
    assert named == {f"body.{field}": said}


def test_messages_of_invalid_fields_are_for_users(http: httpx2.Client) -> None:
    body = {"source": "a", "target": "b", "metric": [], "pionts": 3}
    named = fields(problem(http.post("/v1/matches", json=body), 422, "invalid-request"))
    assert named["body.metric"] == "Input should have at least 1 item, not 0"
    assert named["body.pionts"].startswith("There is no such field")
    body = {"shapes": ["a"]}
    named = fields(problem(http.post("/v1/prototypes", json=body), 422, "invalid-request"))
    assert named == {"body.shapes": "Input should have at least 2 items, not 1"}


def test_our_own_words_come_without_those_of_others(http: httpx2.Client) -> None:
    body: dict[str, object] = {"source": "a", "target": "b", "objective": "linf", "points": 33}
    named = fields(problem(http.post("/v1/matches", json=body), 422, "invalid-request"))
    assert named["body.objective"].startswith('"linf" takes at most 32 points')
    body |= {"occlusion_cost": 1, "third_order": 0.1, "landmarks": [[1, 2]], "partial": "both"}
    named = fields(problem(http.post("/v1/matches", json=body), 422, "invalid-request"))
    assert "leave `occlusion_cost` out" in named["body.objective"]
    assert named["body.third_order"].startswith('"linf" has no third-order term')
    assert list(named)[2:] == ["body.partial", "body.landmarks"]


@pytest.mark.parametrize(
    "body",
    [
        {f"k{n}": 0 for n in range(50_000)},
        {"k" * 900_000: 0},
        {"metric": ["x"] * 90_000},
        {"landmarks": [[]] * 40_000},
        {"metric": {"name": "diffusion"} | {f"k{n}": 0 for n in range(50_000)}},
        {"\ud800": 0, "source": "\ud800", "metric": ["\ud800"]},
    ],
    ids=["many", "long", "list", "lists", "nested", "surrogates"],
)
def test_answers_are_short_whatever_is_asked(http: httpx2.Client, body: dict[str, Any]) -> None:
    answer = ask(http, json.dumps({"source": "a", "target": "b"} | body).encode())
    document = problem(answer, 422, "invalid-request")
    assert 1 <= len(document["errors"]) <= 20
    assert len(answer.content) < 10_000


def test_the_number_of_invalid_fields_is_reported(http: httpx2.Client) -> None:
    body = {"source": "a", "target": "b"} | {f"k{n}": 0 for n in range(21)}
    document = problem(http.post("/v1/matches", json=body), 422, "invalid-request")
    assert "20 of 21" in document["detail"]


@pytest.mark.parametrize("request_model", REQUESTS)
def test_null_stands_for_what_may_be_left_out(request_model: type[JobRequest]) -> None:
    (example, *_) = cast(Json, request_model.model_config["json_schema_extra"])["examples"]
    schema = request_model.model_json_schema()
    nulls = dict.fromkeys(schema["properties"].keys() - example.keys())
    asked = request_model.model_validate(example | nulls)
    assert asked == request_model.model_validate(example)
    assert asked.model_fields_set == example.keys()
    assert all({"type": "null"} in schema["properties"][name]["anyOf"] for name in nulls)
    for name in schema["required"]:
        with pytest.raises(ValidationError, match=name):
            request_model.model_validate(example | {name: None})


def test_every_invalid_item_of_a_list_is_reported(http: httpx2.Client) -> None:
    body: dict[str, Any] = {"source": "a", "target": "b", "metric": ["euclidean", "geodesic", 3]}
    body["landmarks"] = [[1, -2], [3, 4], [5, "x"], [-1, -2]]
    named = fields(problem(http.post("/v1/matches", json=body), 422, "invalid-request"))
    landmarks = [f"body.landmarks.{place}" for place in ("0.1", "2.1", "3.0", "3.1")]
    assert list(named) == ["body.metric.0", "body.metric.2", *landmarks]


def test_the_errors_of_the_longest_lists_take_no_time(http: httpx2.Client) -> None:
    body = {"shapes": [""] * 2000, "labels": [""] * 2000, "names": [""] * 2000}
    answer = http.post("/v1/dissimilarities", json=body)
    assert "20 of 6000" in problem(answer, 422, "invalid-request")["detail"]
    assert answer.elapsed.total_seconds() < 2.0


def test_fields_are_named_by_json_pointers_too(http: httpx2.Client) -> None:
    def pointers(answer: httpx2.Response) -> dict[str, str | None]:
        errors = problem(answer, 422, "invalid-request")["errors"]
        return {error["field"]: error["pointer"] for error in errors}

    body: dict[str, Any] = {"source": "a", "target": "b", "a.b/c~d": 0, "k" * 300: 0}
    body["metric"] = ["geodesic", {"name": "diffusion", "time": -1}]
    named = pointers(http.post("/v1/matches", json=body))
    assert named.pop(f"body.{'k' * 92}...") is None
    assert named == {"body.metric.1.time": "/metric/1/time", "body.a.b/c~d": "/a.b~1c~0d"}
    assert pointers(http.post("/v1/matches", json=[])) == {"body": ""}
    assert pointers(http.get("/v1/jobs?limit=0")) == {"query.limit": None}


@pytest.mark.parametrize("media_type", ["text/plain", "application/x-www-form-urlencoded"])
def test_json_that_is_sent_as_something_else(http: httpx2.Client, media_type: str) -> None:
    answer = ask(http, b'{"source": "a", "target": "b"}', media_type)
    detail = problem(answer, 415, "unsupported-format")["detail"]
    assert media_type in detail
    assert "application/json" in detail


@pytest.mark.parametrize(
    "media_type",
    ["application/json", "application/octet-stream", "application/x-www-form-urlencoded"],
)
@pytest.mark.parametrize("path", ["/v1/shapes", "/v1/prototype-archives", "/v1/attributes"])
def test_uploads_that_are_no_forms(http: httpx2.Client, path: str, media_type: str) -> None:
    answer = http.post(path, content=b"OFF\n3 1 0\n", headers={"content-type": media_type})
    detail = problem(answer, 415, "unsupported-format")["detail"]
    assert f"sent as {media_type}; send multipart/form-data" in detail


@pytest.mark.parametrize("path", ["/v1/shapes", "/v1/prototype-archives", "/v1/attributes"])
def test_files_in_gzip_are_told_to_be_unpacked(http: httpx2.Client, path: str) -> None:
    for name in ("cat2.off.gz", "cat2.ply"):
        answer = http.post(path, files={"file": (name, gzip.compress(b"OFF\n"))})
        refused = problem(answer, 415, "unsupported-format")
        assert "compressed by gzip; unpack it" in refused["detail"]
        assert fields(refused) == {"body.file": refused["detail"]}


@pytest.mark.parametrize(
    "body",
    [b"{", b'{"source": "a",}', b"{} {}", b"\0", b"\xff", b"[" * 90_000, b"9" * 5000],
    ids=["cut", "comma", "two", "zero", "bytes", "deep", "digits"],
)
def test_bodies_that_are_not_json_are_refused(http: httpx2.Client, body: bytes) -> None:
    document = problem(ask(http, body), 400, "bad-request")
    assert "send a JSON object" in document["detail"]


def test_where_json_breaks_off_is_said(http: httpx2.Client) -> None:
    document = problem(ask(http, b'{"source": }'), 400, "bad-request")
    assert "at character 11" in document["detail"]


@pytest.mark.parametrize(
    "form",
    [
        {"files": {"file": ("n" * 10_000 + ".off", b"OFF\n")}},
        {"files": {"file": MESH}, "data": {f"k{n}": "" for n in range(1001)}},
        {"files": [("file", MESH)] * 1001},
    ],
    ids=["name", "fields", "files"],
)
def test_forms_beyond_all_bounds(http: httpx2.Client, form: Any) -> None:
    document = problem(http.post("/v1/shapes", **form), 400, "bad-request")
    assert "with the mesh as `file`" in document["detail"]


def test_a_field_where_a_file_should_be(http: httpx2.Client) -> None:
    answer = http.post("/v1/shapes", files={"file": (None, "x")})
    named = fields(problem(answer, 422, "invalid-request"))
    assert "filename" in named["body.file"]


def test_bodies_of_very_many_values_are_refused_before_they_are_parsed(
    http: httpx2.Client,
) -> None:
    body = json.dumps({"source": "a", "target": "b", "landmarks": [[]] * 60_000}).encode()
    assert "100000 values" in problem(ask(http, body), 413, "upload-too-large")["detail"]


@pytest.mark.parametrize("request_model", REQUESTS)
def test_the_length_of_every_list_of_a_request_is_checked_before_its_items(
    request_model: type[JobRequest],
) -> None:
    within = list(schemas_within(request_model.__pydantic_core_schema__))
    lists = [one for one in within if is_list(one)]
    checked = [
        one["schema"]
        for one in within
        if one.get("type") == "function-before" and is_list(one["schema"])
    ]
    assert lists
    assert len(checked) == len(lists)
    assert all(one["max_length"] <= 2000 or one["fail_fast"] for one in checked)


def is_list(schema: dict[str, Any]) -> bool:
    return schema.get("type") == "tuple" and "variadic_item_index" in schema


def schemas_within(value: Any) -> Iterator[dict[str, Any]]:
    if isinstance(value, dict):
        yield value
    if isinstance(value, dict | list | tuple):
        for one in value.values() if isinstance(value, dict) else value:
            yield from schemas_within(one)


@pytest.mark.parametrize("encoding", ["gzip", "br", "gzip, deflate"])
def test_bodies_that_are_compressed_are_refused_with_the_reason(
    http: httpx2.Client, encoding: str
) -> None:
    body = gzip.compress(json.dumps({"source": "a", "target": "b"}).encode())
    headers = {"content-encoding": encoding, "content-type": "application/json"}
    refused = http.post("/v1/matches", content=body, headers=headers)
    assert repr(encoding) in problem(refused, 415, "encoded-body")["detail"]
    form = gzip.compress(b"--x\r\n")
    headers["content-type"] = "multipart/form-data; boundary=x"
    problem(http.post("/v1/shapes", content=form, headers=headers), 415, "encoded-body")
    # What says that it is not encoded is not.
    headers = {"content-encoding": "identity", "content-type": "application/json"}
    problem(http.post("/v1/matches", content=b"{}", headers=headers), 422, "invalid-request")


def test_without_a_body_it_does_not_matter_how_that_is_encoded(http: httpx2.Client) -> None:
    for length in ({}, {"content-length": "0"}, {"content-length": "00"}):
        answer = http.get("/v1/structures", headers={"content-encoding": "gzip"} | length)
        assert answer.status_code == 200, length
    pieces = iter([gzip.compress(b"{}")])
    answer = http.post("/v1/matches", content=pieces, headers={"content-encoding": "gzip"})
    problem(answer, 415, "encoded-body")


@pytest.mark.parametrize("path", ["/v1/shapes", "/v1/prototype-archives", "/v1/attributes"])
def test_a_form_has_no_other_parts(http: httpx2.Client, path: str) -> None:
    files = [("file", ("a.off", b"OFF")), ("mesh", ("b.off", b"OFF"))]
    refused = http.post(path, files=files, data={"nmae": "x", "k" * 300: "x"})
    named = fields(problem(refused, 422, "invalid-request"))
    assert list(named) == [f"body.{'k' * 92}...", "body.mesh", "body.nmae"]
    assert set(named.values()) == {"There is no such part of this form; it has file and name"}


@pytest.mark.parametrize("path", ["/v1/shapes", "/v1/prototype-archives"])
def test_a_form_has_each_part_once(http: httpx2.Client, path: str) -> None:
    files = [("file", ("a.off", b"OFF")), ("file", ("b.off", b"OFF"))]
    named = fields(problem(http.post(path, files=files), 422, "invalid-request"))
    assert list(named) == ["body.file"]
    assert "several" in named["body.file"]
    name = [("name", (None, "a")), ("name", (None, "b"))]
    refused = http.post(path, files=[*files[:1], *name])
    assert list(fields(problem(refused, 422, "invalid-request"))) == ["body.name"]
    long = http.post(path, files=files[:1], data={"name": "x" * 300})
    named = fields(problem(long, 422, "invalid-request"))
    assert named == {"body.name": "Input should have at most 200 characters, not 300"}


def test_a_form_that_is_cut_off_is_told(http: httpx2.Client) -> None:
    form = b'--x\r\nContent-Disposition: form-data; name="file"; filename="a.off"\r\n\r\nOFF\n'
    headers = {"content-type": "multipart/form-data; boundary=x"}
    for body in (form[:30], form[:60], b""):
        answer = http.post("/v1/shapes", content=body, headers=headers)
        refused = problem(answer, 422, "invalid-request")
        assert "or is truncated" in fields(refused)["body.file"]


def test_gzip_is_not_sent_to_clients_that_do_not_accept_it(http: httpx2.Client) -> None:
    for accepted in ("gzip", "br, gzip;q=0.5", "GZIP ; q=1"):
        answer = http.get("/page/style.css", headers={"accept-encoding": accepted})
        assert answer.headers["content-encoding"] == "gzip"
    for accepted in ("gzip;q=0", "gzip; q=0.000, br", "identity", "notgzip", ""):
        answer = http.get("/page/style.css", headers={"accept-encoding": accepted})
        assert "content-encoding" not in answer.headers
