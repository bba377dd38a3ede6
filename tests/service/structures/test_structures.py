"""``/v1/structures``: what can be chosen, and that all of it can be."""

from collections.abc import Callable

import httpx2
import numpy as np
import trimesh

from tests.service.conftest import Json, problem

Shapes = tuple[str, str]

QUICK = {"points": 8, "orientation": False}


def done(http: httpx2.Client, body: Json) -> Json:
    """The job of a match, when it has ended."""
    job: Json = http.post("/v1/matches", json=body).json()
    answer: Json = http.get(f"/v1/jobs/{job['id']}", params={"wait": 60}).json()
    return answer


def test_table_1(http: httpx2.Client) -> None:
    answer = http.get("/v1/structures")
    assert answer.status_code == 200
    table = {
        entry["name"]: tuple(entry["invariance"].values())
        for kind in ("metrics", "descriptors")
        for entry in answer.json()[kind]
    }
    assert (
        table.items()
        >= {
            "hks": ("yes", "approx", "no"),
            "si_hks": ("yes", "approx", "yes"),
            "geodesic": ("yes", "no", "no"),
            "diffusion": ("yes", "approx", "no"),
            "commute_time": ("yes", "approx", "yes"),
        }.items()
    )


def test_a_match_with_structures_of_ones_own(http: httpx2.Client, shapes: Shapes) -> None:
    asked = {
        "metric": [{"name": "diffusion", "time": 0.05}, "biharmonic"],
        "descriptor": {"name": "si_hks", "frequencies": 3},
    }
    job = done(http, {"source": shapes[0], "target": shapes[1], **QUICK, "points": 16} | asked)
    assert job["state"] == "succeeded", job["error"]
    result = http.get(f"/v1/jobs/{job['id']}/result").json()
    assert [level["metric"] for level in result["levels"]] == ["diffusion", "biharmonic"]
    assert {level["descriptor"] for level in result["levels"]} == {"si_hks"}
    assert {name: result["parameters"][name] for name in asked} == asked


def test_errors_of_a_job_name_the_field(http: httpx2.Client, shapes: Shapes) -> None:
    endless = {"name": "diffusion", "time": 1e9}
    for metric, field in (
        (endless, "body.metric.time"),
        ([endless], "body.metric.0.time"),
        (["geodesic", endless], "body.metric.1.time"),
    ):
        body = {"source": shapes[0], "target": shapes[1], **QUICK, "points": 16, "metric": metric}
        job = done(http, body)
        assert job["state"] == "failed"
        assert [error["field"] for error in job["error"]["errors"]] == [field]
        assert "vanish" in job["error"]["detail"]


def test_without_normalisation_distances_are_the_users(http: httpx2.Client, shapes: Shapes) -> None:
    body = {"source": shapes[0], "target": shapes[1], **QUICK, "metric": "geodesic"}
    found = []
    for normalise in (True, False):
        job = done(http, body | {"normalise": normalise})
        assert job["state"] == "succeeded", job["error"]
        found.append(http.get(f"/v1/jobs/{job['id']}/result").json())
    area = http.get(f"/v1/shapes/{shapes[0]}").json()["area"]
    unit, plain = (match["distortion"] for match in found)
    assert found[0]["correspondences"][0]["source"] == found[1]["correspondences"][0]["source"]
    # The second shape is the first one turned, so both have the same area.
    assert abs(plain["linf"] - unit["linf"] * area**0.5) < 1e-6 * area**0.5


def test_colours_that_are_not_there(http: httpx2.Client, shapes: Shapes) -> None:
    body = {"source": shapes[0], "target": shapes[1], **QUICK}
    for descriptor, field in (
        ("photometric", "body.descriptor"),
        (["none", {"name": "photometric", "radius": 0.1}], "body.descriptor.1"),
    ):
        asked = body | {"descriptor": descriptor}
        document = problem(http.post("/v1/matches", json=asked), 422, "invalid-request")
        assert [error["field"] for error in document["errors"]] == [field]
        assert "missing in source, target" in document["errors"][0]["message"]
    unweighed = body | {"descriptor": "photometric", "first_order_weight": 0.0}
    assert done(http, unweighed)["state"] == "succeeded"


def test_colours_are_compared(http: httpx2.Client, upload: Callable[..., Json]) -> None:
    """Two painted spheres, one turned: nothing but the paint tells which point is which."""
    ball = trimesh.creation.icosphere(subdivisions=3)
    paint = np.round(255 * (0.5 + 0.5 * np.sin(ball.vertices @ np.diag([1.0, 1.3, 1.7]))))
    ids = []
    for turned in (ball.vertices, ball.vertices[:, [1, 2, 0]]):
        mesh = trimesh.Trimesh(turned, ball.faces, vertex_colors=paint, process=False)
        shape = upload(mesh.export(file_type="ply"), "ball.ply")
        assert shape["has_colors"]
        ids.append(shape["id"])
    body = {
        "source": ids[0],
        "target": ids[1],
        **QUICK,
        "metric": "geodesic",
        "descriptor": {"name": "photometric", "radius": 0},
        "first_order_weight": 10,
    }
    job = done(http, body)
    assert job["state"] == "succeeded", job["error"]
    result = http.get(f"/v1/jobs/{job['id']}/result").json()
    pairs = [(pair["source"], pair["target"]) for pair in result["correspondences"]]
    colours = paint[[x for x, _ in pairs]] - paint[[y for _, y in pairs]]
    assert np.abs(colours).mean() < 30
