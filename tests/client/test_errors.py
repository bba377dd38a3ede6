"""What the running service refuses, as exceptions."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import isomatch
import numpy as np
import pytest
from isomatch._problem import FieldProblem, Problem

from tests.client.shapes import LASTING
from tests.worker.figures import blob, off

UNKNOWN = "0" * 32
TRUNCATED = b"OFF\n4 4 0\n0 0 0\n1 0 0\n"
NOT_FINITE = b"OFF\n3 1 0\n0 0 0\n1 nan 0\n0 1 0\n3 0 1 2\n"
NO_FACES = b"OFF\n3 0 0\n0 0 0\n1 0 0\n0 1 0\n"
OUT_OF_RANGE = b"OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 7\n"
FLAT = b"OFF\n3 1 0\n0 0 0\n1 0 0\n2 0 0\n3 0 1 2\n"


@pytest.mark.parametrize(
    "data",
    [b"", b"Dear reader,\n", TRUNCATED, NOT_FINITE, NO_FACES, OUT_OF_RANGE, FLAT],
    ids=["empty", "text", "truncated", "nan", "no faces", "index out of range", "no area"],
)
def test_an_unusable_mesh(client: isomatch.Client, data: bytes) -> None:
    with pytest.raises(isomatch.UnprocessableShape) as refusal:
        client.upload(data, file_type="off")
    assert refusal.value.status == 422
    assert refusal.value.detail == str(refusal.value)
    assert "\n" not in str(refusal.value)


def test_an_unsupported_format(client: isomatch.Client, tmp_path: Path) -> None:
    path = tmp_path / "shape.docx"
    path.write_bytes(b"PK")
    with pytest.raises(isomatch.UnsupportedFormat, match="off"):
        client.upload(path)


def test_unknown_ids(client: isomatch.Client) -> None:
    with pytest.raises(isomatch.NotFound, match=UNKNOWN) as refusal:
        client.shape(UNKNOWN)
    assert (refusal.value.status, refusal.value.problem.status) == (404, 404)
    assert refusal.value.type.startswith("urn:isomatch:problem:")
    with pytest.raises(isomatch.NotFound):
        client.job("nothing")
    with pytest.raises(isomatch.UnknownShape, match=UNKNOWN) as unknown:
        client.match(UNKNOWN, UNKNOWN)
    assert [wrong.field for wrong in unknown.value.errors] == ["body.source", "body.target"]


def test_a_file_that_is_not_uploaded(client: isomatch.Client) -> None:
    for given in ("shapes/a.off", Path("a.off")):
        with pytest.raises(ValueError, match=r"a\.off' is no id: give what client\.upload returns"):
            client.match(given, UNKNOWN)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="is no id"):
        client.match_many(UNKNOWN, ["a.off"])
    with pytest.raises(TypeError, match=r"NoneType has no id: give what client\.upload returns"):
        client.match(None, UNKNOWN)  # type: ignore[arg-type]


@pytest.mark.parametrize("given", [None, 5, np.eye(3)], ids=["None", "int", "ndarray"])
def test_what_has_no_id(client: isomatch.Client, given: Any) -> None:
    calls: list[Callable[[Any], object]] = [
        lambda one: client.match(one, UNKNOWN),
        client.shape,
        client.geometry,
        client.delete_shape,
        client.delete_attributes,
        client.prototype,
        client.job,
    ]
    for call in calls:
        with pytest.raises(TypeError, match=r"has no id: give what client\.upload returns"):
            call(given)


def test_one_instead_of_a_list(
    client: isomatch.Client, pair: tuple[isomatch.Shape, isomatch.Shape]
) -> None:
    calls: list[tuple[str, Callable[[Any], object]]] = [
        ("shapes", client.dissimilarities),
        ("shapes", client.consistent_maps),
        ("shapes", client.learn_prototype),
        ("shapes", lambda one: client.match_many(pair[1], one)),
        ("shapes", lambda one: client.register(pair[1], one)),
        ("labels", lambda one: client.dissimilarities(pair, one)),
        ("templates", lambda one: client.landmarks(one, pair[1])),
        ("names", lambda one: client.transfer(UNKNOWN, what="scalars", names=one)),
        ("landmarks", lambda one: client.transfer(UNKNOWN, what="landmarks", points=one)),
    ]
    for entries, call in calls:
        for given in (pair[0], UNKNOWN, 5):
            message = f"give a list of {entries}, not {type(given).__name__}"
            with pytest.raises(TypeError, match=message):
                call(given)
    # Any other iterable is as good as a list.
    client.dissimilarities(iter(pair)).cancel()


def test_a_bad_parameter(client: isomatch.Client) -> None:
    with pytest.raises(isomatch.InvalidRequest) as refusal:
        client.match(UNKNOWN, UNKNOWN, points=2, metric="euclidean")
    fields = [wrong.field for wrong in refusal.value.errors]
    assert "body.points" in fields
    assert any(field.startswith("body.metric") for field in fields)
    assert str(refusal.value).startswith("The request is not valid: ")
    assert "points: " in str(refusal.value)


def test_field_errors_are_not_repeated(
    client: isomatch.Client, pair: tuple[isomatch.Shape, isomatch.Shape], tmp_path: Path
) -> None:
    # The last vertex of the file is in no face.
    vertices, faces = blob(2)
    mesh = tmp_path / "loose.off"
    mesh.write_bytes(off(np.concatenate([vertices, [[0.0, 0.0, 0.0]]]), faces))
    loose = [(0, len(vertices))]
    job = client.match(pair[0], client.upload(mesh), points=6, landmarks=loose)
    with pytest.raises(isomatch.JobFailed, match="not part of the target's surface") as failure:
        job.result()
    assert str(failure.value).count("landmarks.0.1") == 1


def test_field_errors_that_the_detail_has_are_left_out() -> None:
    said = "PLY has no texture coordinates"
    errors = (FieldProblem(field="path.format", message=said),)
    detail = f"format: {said}"
    assert Problem(title="Invalid", status=422, detail=detail, errors=errors).summary == detail
    other = FieldProblem(field="body.points", message="too few")
    several = Problem(title="Invalid", status=422, detail=detail, errors=(*errors, other))
    assert several.summary == f"{detail}: points: too few"


def test_the_result_of_an_unfinished_job(
    client: isomatch.Client, pair: tuple[isomatch.Shape, isomatch.Shape]
) -> None:
    job = client.match(*pair, **LASTING).cancel()
    job.wait(timeout=240)
    with pytest.raises(isomatch.Conflict):
        job.picture()


def test_every_refusal_is_an_isomatch_error() -> None:
    tree = [value for value in vars(isomatch).values() if isinstance(value, type)]
    errors = [kind for kind in tree if issubclass(kind, Exception)]
    assert len(errors) >= 19
    assert all(issubclass(kind, isomatch.IsomatchError) for kind in errors)
    drawn = isomatch._errors.__doc__ or ""
    assert all(kind.__name__ in drawn for kind in errors)


@pytest.mark.parametrize(
    ("timeout", "kind"), [(float("nan"), ValueError), (-1, ValueError), ("5", TypeError)]
)
def test_timeouts_of_waits(
    client: isomatch.Client,
    pair: tuple[isomatch.Shape, isomatch.Shape],
    timeout: Any,
    kind: type[Exception],
) -> None:
    """Refused whether or not the job has ended."""
    job = client.match(*pair, points=8)
    for _ in range(2):
        for wait in (job.wait, job.result):
            with pytest.raises(kind, match="timeout must be"):
                wait(timeout=timeout)
        job.wait(timeout=240)
    with pytest.raises(kind, match="timeout must be"):
        client.upload(TRUNCATED, file_type="off", timeout=timeout)


def test_a_shape_that_is_listed_twice_is_named(
    client: isomatch.Client, pair: tuple[isomatch.Shape, isomatch.Shape]
) -> None:
    one, other = (
        renamed(shape, name) for shape, name in zip(pair, ("a.off", "b.off"), strict=True)
    )
    with pytest.raises(isomatch.InvalidRequest) as refusal:
        client.dissimilarities([one, other, renamed(one, "c.off"), one])
    assert {wrong.field: wrong.message for wrong in refusal.value.errors} == {
        "body.shapes.2": "'c.off' is the same as shapes.0 ('a.off'); give each once",
        "body.shapes.3": "this shape is the same as shapes.0 ('a.off'); give each once",
    }


def renamed(shape: isomatch.Shape, name: str) -> isomatch.Shape:
    """The shape as uploaded under another name."""
    return shape.model_copy(update={"name": name})
