"""Landmarks in space, transferred by the service: placed, carried, and measured."""

import io
from typing import Any

import httpx2
import numpy as np
import pytest
from pydantic import ValidationError

from broker.contracts import GivenLandmark, SurfacePoint, TransferPayload
from solver.mesh import TriangleMesh
from tests.service.conftest import Json, Upload, problem
from tests.service.matches.test_partial import whole_and_part
from tests.service.matching import matched
from tests.service.transfers.test_transfers import MESH as BODY
from tests.service.transfers.test_transfers import OTHER, TRUTH, arrays_of, carried
from tests.solver.mesh.mesh_files import file_of

LABELS = ("tip", "side", "lost", "tip")
AT = (5, 70, 300)
"""Vertices that the landmarks are at which are not missing."""


@pytest.fixture(scope="module")
def pair(upload: Upload) -> tuple[str, str]:
    return upload(file_of(BODY), "body.ply")["id"], upload(file_of(OTHER), "other.ply")["id"]


@pytest.fixture(scope="module")
def match(http: httpx2.Client, pair: tuple[str, str]) -> str:
    found: str = matched(http, pair, points=12, dense=True)["id"]
    return found


def given(mesh: TriangleMesh, vertices: Any = AT) -> list[Json]:
    """Landmarks at vertices, and a missing one."""
    places: list[Any] = mesh.vertices[list(vertices)].tolist()
    places.insert(2, None)
    return [
        {"label": label, "position": place} for label, place in zip(LABELS, places, strict=True)
    ]


def landmarks_of(http: httpx2.Client, match: str, **asked: Any) -> tuple[list[Json], Json]:
    """The landmarks of a transfer, and its result."""
    job = carried(http, match, what="landmarks", **asked)
    assert job["state"] == "succeeded", job["error"]
    result = http.get(job["links"]["result"]).json()
    return result["landmarks"], result


def test_positions_are_carried_with_a_confidence(http: httpx2.Client, match: str) -> None:
    job = carried(http, match, what="landmarks", landmarks=given(BODY))
    result = http.get(job["links"]["result"]).json()
    found = result["landmarks"]
    assert [one["label"] for one in found] == list(LABELS)
    assert result["warnings"] == ["2 landmarks are called 'tip'; only their order tells them apart"]
    probability = result["confidence"]["probability"]
    there = [found[place] for place in (0, 1, 3)]
    for vertex, one in zip(AT, there, strict=True):
        np.testing.assert_allclose(one["position"], OTHER.vertices[TRUTH[vertex]], atol=1e-3)
        places = OTHER.vertices[one["vertices"]]
        np.testing.assert_allclose(one["weights"] @ places, one["position"], atol=1e-6)
        np.testing.assert_allclose(one["on_source"]["position"], BODY.vertices[vertex], atol=1e-6)
        # The target is a rigid copy.
        assert one["round_trip"] < 1e-3
        assert one["distortion"] < 0.01
        assert one["from_surface"] < 1e-6
        assert 0.9 * probability < one["confidence"] < probability
    assert found[2] == {"label": "lost"} | dict.fromkeys(set(found[2]) - {"label"})
    # What earlier versions have is in it, too.
    image = {key: there[0][key] for key in ("vertices", "weights", "position")}
    assert result["points"][0] == image
    assert result["points"][2] is None
    arrays = arrays_of(http, job)
    assert arrays["vertices"].tolist()[0] == there[0]["vertices"]
    assert arrays["labels"].tolist() == list(LABELS)
    assert np.isnan(arrays["positions"]).any(axis=1).tolist() == [False, False, True, False]
    for name in ("confidence", "round_trip", "distortion", "from_surface"):
        expected = [np.nan if one[name] is None else one[name] for one in found]
        np.testing.assert_array_equal(arrays[name], expected)
    source = http.get(f"/v1/transfers/{job['id']}/source.npz").content
    with np.load(io.BytesIO(source)) as placed:
        main = placed["vertices"][np.arange(4), np.nan_to_num(placed["weights"]).argmax(axis=1)]
        assert main.tolist() == [5, 70, -1, 300]


def test_points_of_the_surface_have_the_same_measures(http: httpx2.Client, match: str) -> None:
    (by_vertex, *_), _ = landmarks_of(http, match, points=[5])
    (in_space, *_), _ = landmarks_of(http, match, landmarks=given(BODY))
    assert by_vertex["label"] is None
    assert by_vertex["from_surface"] is None
    np.testing.assert_allclose(by_vertex["position"], in_space["position"], atol=1e-6)
    for name in ("confidence", "round_trip", "distortion"):
        np.testing.assert_allclose(by_vertex[name], in_space[name], atol=1e-6)


def test_landmarks_of_the_target_are_carried_back(http: httpx2.Client, match: str) -> None:
    back = given(OTHER, TRUTH[list(AT)])
    found, _ = landmarks_of(http, match, landmarks=back, direction="target_to_source")
    for vertex, place in zip(AT, (0, 1, 3), strict=True):
        np.testing.assert_allclose(found[place]["position"], BODY.vertices[vertex], atol=1e-3)
        assert found[place]["confidence"] > 0.5


def test_landmarks_far_from_the_surface_are_left_out(http: httpx2.Client, match: str) -> None:
    landmarks = given(BODY)
    landmarks[1]["position"] = [50.0, 0.0, 0.0]
    del landmarks[3]["label"]
    landmarks[3]["position"] = [0.0, 0.0, 60.0]
    found, result = landmarks_of(http, match, landmarks=landmarks)
    (warning,) = result["warnings"]
    assert warning.startswith("2 of 3 landmarks are far from the surface, number 3 by ")
    assert "'side' by " in warning
    assert [one["on_source"] is None for one in found] == [False, True, True, True]
    assert found[1]["from_surface"] is None


def test_landmarks_of_another_unit_or_coordinate_system_are_refused(
    http: httpx2.Client, match: str
) -> None:
    for factors, words in (
        ([1000.0, 1000.0, 1000.0], "3 of 3 landmarks are far from the surface"),
        ([-1.0, -1.0, 1.0], "none with x and y negated"),
    ):
        landmarks = given(BODY)
        for one in landmarks:
            if one["position"] is not None:
                one["position"] = (np.array(one["position"]) * factors).tolist()
        job = carried(http, match, what="landmarks", landmarks=landmarks)
        assert job["state"] == "failed"
        assert job["error"]["type"].endswith(":misplaced-landmarks")
        assert words in job["error"]["detail"]
        assert job["error"]["errors"][0]["field"] == "body.landmarks"


HERE = {"position": [0.0, 0.0, 1.0]}


@pytest.mark.parametrize(
    ("asked", "field"),
    [
        ({"landmarks": [HERE], "points": [5]}, "landmarks"),
        ({"landmarks": [HERE], "what": "labels"}, "landmarks"),
        ({"landmarks": [{"position": None}]}, "landmarks"),
        ({"landmarks": []}, "points"),
        ({"landmarks": [HERE] * 10_001}, "landmarks"),
        ({"landmarks": [HERE, {"label": "a"}]}, "landmarks.1.position"),
        ({"landmarks": [{"position": [0.0, 1.0]}]}, "landmarks.0.position"),
        ({"landmarks": [{"position": [0.0, 1.0, 1e39]}]}, "landmarks.0.position.2"),
        ({"landmarks": [{"position": [0.0, 1.0, "1"]}]}, "landmarks.0.position.2"),
        ({"landmarks": [HERE | {"label": 201 * "a"}]}, "landmarks.0.label"),
        ({"landmarks": [HERE | {"label": "a\nb"}]}, "landmarks.0.label"),
        ({"landmarks": [HERE | {"name": "a"}]}, "landmarks.0.name"),
        ({"landmarks": 5}, "landmarks"),
    ],
)
def test_what_is_no_landmark_is_refused(
    http: httpx2.Client, match: str, asked: Json, field: str
) -> None:
    body = {"match": match, "what": "landmarks", **asked}
    refused = problem(http.post("/v1/transfers", json=body), 422, "invalid-request")
    assert f"body.{field}" in [one["field"] for one in refused["errors"]]


def test_landmarks_that_a_part_lacks_are_missing_and_named(
    http: httpx2.Client, upload: Upload
) -> None:
    whole, part = whole_and_part()
    ids = upload(file_of(whole), "m.ply")["id"], upload(file_of(part), "m.ply")["id"]
    foot, head = (whole.vertices[place(whole.vertices[:, 1])] for place in (np.argmin, np.argmax))
    match = matched(http, ids, points=12, dense=True, partial="target")["id"]
    asked = [{"label": "foot", "position": foot.tolist()}, {"position": head.tolist()}]
    (low, high), result = landmarks_of(http, match, landmarks=asked)
    assert result["warnings"][-1] == (
        "1 of 2 landmarks are missing, as they have no partner or are not part of the mapped"
        " surface: number 1"
    )
    assert high["on_source"] is not None
    assert [high[name] for name in ("position", "confidence", "round_trip")] == 3 * [None]
    # The part is the same surface at another scale, which is no distortion.
    assert low["distortion"] < 0.1
    distance = np.linalg.norm(np.array(low["position"]) - 2.0 * foot)
    assert distance < 0.05 * np.sqrt(part.area)


def test_records_of_landmarks_in_space_are_left_to_versions_that_know_them() -> None:
    class Earlier(TransferPayload):
        points: tuple[SurfacePoint, ...] = ()

    ends = {"match": "m", "source": "a", "target": "b", "attributes": None}
    how = {"what": "landmarks", "direction": "source_to_target"}
    point = {"vertices": [1, 2, 3], "weights": [0.2, 0.3, 0.5]}
    before = Earlier.model_validate({**ends, **how, "points": [point]})
    stored = before.model_dump(mode="json", exclude={"landmarks"})
    now = TransferPayload.model_validate(stored)
    assert (now.points, now.landmarks) == (before.points, ())
    assert Earlier.model_validate_json(now.model_dump_json()).points == before.points
    landmark = GivenLandmark(label="tip", position=(0.0, 1.0, 2.0))
    new = TransferPayload.model_validate({**ends, **how, "points": None, "landmarks": [landmark]})
    assert TransferPayload.model_validate_json(new.model_dump_json()) == new
    with pytest.raises(ValidationError):
        Earlier.model_validate_json(new.model_dump_json())
