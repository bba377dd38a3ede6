"""Registrations through the whole chain: shapes in, registered templates and statistics out."""

import io
from typing import Any

import httpx2
import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

from solver.arrays import FloatArray
from solver.mesh import read_mesh, triangle_mesh
from tests.service.batches.test_batches import SLOW, awaited, batch
from tests.service.conftest import Json, Upload, problem
from tests.service.matching import matched
from tests.solver import shapes
from tests.solver.mesh import mesh_files
from tests.solver.mesh.mesh_files import file_of
from tests.worker.figures import blob_file

TEMPLATE = shapes.blob(3)
PLACES = [TEMPLATE.vertices @ Rotation.from_rotvec([0.3 * k, 1.0, -k]).as_matrix() + k
          for k in range(3)]  # fmt: skip
PLACES[2] = 1.5 * PLACES[2]
"""Moved copies of the template, the last one larger."""

COLORS = (TEMPLATE.vertices - TEMPLATE.vertices.min(axis=0)) / np.ptp(TEMPLATE.vertices, axis=0)
"""Of the template's vertices."""


def colored() -> bytes:
    """The template as OBJ, with colours."""
    rows = np.hstack([TEMPLATE.vertices, COLORS])
    lines = ["v " + " ".join(f"{x:.17g}" for x in row) for row in rows]
    lines += ["f " + " ".join(map(str, corners + 1)) for corners in TEMPLATE.faces]
    return "\n".join([*lines, ""]).encode()


def uploaded_specimens(upload: Upload) -> list[str]:
    """Ids of the copies, each with vertices in an order of its own."""
    ids = []
    for seed, places in enumerate(PLACES):
        other, _ = shapes.permuted(triangle_mesh(places, TEMPLATE.faces), seed=seed + 40)
        ids.append(upload(file_of(other), f"specimen{seed}.ply")["id"])
    return ids


def too_coarse() -> bytes:
    """A shape that is stored, but has too few vertices to be registered."""
    return file_of(shapes.triangle())


def ended(http: httpx2.Client, answer: httpx2.Response) -> Json:
    assert answer.status_code == 202, answer.text
    job: Json = answer.json()
    for _ in range(20):
        job = http.get(f"/v1/jobs/{job['id']}", params={"wait": 30}).json()
        if job["ended"]:
            return job
    raise AssertionError(job)


@pytest.fixture(scope="module")
def given(upload: Upload) -> tuple[str, list[str]]:
    template = upload(colored(), "template.obj")["id"]
    return template, [*uploaded_specimens(upload), upload(too_coarse(), "coarse.ply")["id"]]


@pytest.fixture(scope="module")
def job(http: httpx2.Client, given: tuple[str, list[str]]) -> Json:
    template, specimens = given
    names = [f"specimen{number}.ply" for number in range(3)]
    body = {
        "template": template,
        "template_name": "template.ply",
        "shapes": specimens,
        "names": [*names, None],
    }
    found = ended(http, http.post("/v1/registrations", json=body))
    assert found["state"] == "succeeded", found
    return found


@pytest.fixture(scope="module")
def result(http: httpx2.Client, job: Json) -> Json:
    found: Json = http.get(job["links"]["result"]).json()
    return found


def positions_of(answer: httpx2.Response, file_type: str) -> FloatArray:
    assert answer.status_code == 200, answer.text
    return read_mesh(answer.content, file_type).vertices


def test_the_report_names_every_specimen(result: Json, given: tuple[str, list[str]]) -> None:
    template, specimens = given
    assert [one["shape"] for one in result["specimens"]] == specimens
    assert [one["registered"] for one in result["specimens"]] == [True, True, True, False]
    assert "could not be registered" in result["specimens"][3]["reason"]
    assert result["specimens"][3]["scores"] == []
    for one in result["specimens"][:3]:
        assert one["flipped"] == 0
        assert not one["reflected"]
        assert one["max_distance"] <= 0.005
        assert one["confidence"]["probability"] > 0.9
    assert (result["template"], result["vertices"], result["faces"]) == (
        template,
        TEMPLATE.n_vertices,
        TEMPLATE.n_faces,
    )


def test_specimens_that_may_be_parts_are_named(
    http: httpx2.Client, given: tuple[str, list[str]], result: Json, upload: Upload
) -> None:
    assert result["warnings"] == []
    template, specimens = given
    lower = TEMPLATE.vertices[TEMPLATE.faces].mean(axis=1)[:, 1] < 0.2
    part = triangle_mesh(TEMPLATE.vertices, TEMPLATE.faces[lower])
    whole, half = specimens[0], upload(file_of(part), "half.ply")["id"]
    body = {"template": template, "shapes": [whole, half]}
    found = ended(http, http.post("/v1/registrations", json=body))
    warned = http.get(found["links"]["result"]).json()
    assert [one["registered"] for one in warned["specimens"]] == [True, True]
    (said,) = [one for one in warned["warnings"] if "long boundary" in one]
    assert "'half.ply'" in said
    assert "specimen0" not in said


def test_specimens_in_other_units_are_named(
    http: httpx2.Client, given: tuple[str, list[str]], upload: Upload
) -> None:
    template, specimens = given
    other = triangle_mesh(1000.0 * TEMPLATE.vertices, TEMPLATE.faces)
    shapes_given = [specimens[0], upload(file_of(other), "millimetres.ply")["id"]]
    for scale in (False, True):
        body = {"template": template, "shapes": shapes_given, "scale": scale}
        found = ended(http, http.post("/v1/registrations", json=body))
        warnings = http.get(found["links"]["result"]).json()["warnings"]
        said = [one for one in warnings if "times as large as 'specimen0.ply'" in one]
        assert len(said) == (not scale)
        assert all("'millimetres.ply' is 1e+03 times" in one for one in said)


def test_a_template_of_too_few_vertices_is_named(
    http: httpx2.Client, given: tuple[str, list[str]]
) -> None:
    template, (*_, coarse) = given
    body = {"template": coarse, "shapes": [template]}
    failed = ended(http, http.post("/v1/registrations", json=body))
    assert failed["error"]["type"].endswith("unusable-mesh")
    assert failed["error"]["errors"] == [
        {
            "field": "body.template",
            "message": "it has fewer than 4 vertices, too few to be registered",
            "pointer": "/template",
        }
    ]


def test_registered_templates_have_the_vertices_of_the_template(
    http: httpx2.Client, job: Json, result: Json
) -> None:
    for place, truth in enumerate(PLACES):
        path = f"/v1/jobs/{job['id']}/registered.ply"
        answer = http.get(path, params={"specimen": place})
        mesh = read_mesh(answer.content, "ply")
        np.testing.assert_array_equal(mesh.faces, TEMPLATE.faces)
        size = np.sqrt(triangle_mesh(truth, TEMPLATE.faces).area)
        np.testing.assert_allclose(mesh.vertices, truth, atol=1e-3 * size)
        assert mesh.colors is not None
        np.testing.assert_allclose(mesh.colors, COLORS, atol=1 / 255)


@pytest.mark.parametrize("file_type", ["ply", "obj", "glb"])
def test_other_formats_are_opened_elsewhere(http: httpx2.Client, job: Json, file_type: str) -> None:
    answer = http.get(f"/v1/jobs/{job['id']}/registered.{file_type}", params={"specimen": 1})
    assert answer.status_code == 200, answer.text
    opened: Any = trimesh.load(io.BytesIO(answer.content), file_type, force="mesh", process=False)
    np.testing.assert_allclose(opened.vertices, PLACES[1], atol=0.01)
    mean = http.get(f"/v1/jobs/{job['id']}/result.{file_type}")
    assert positions_of(mean, file_type).shape == TEMPLATE.vertices.shape


def test_arrays_are_the_statistics_of_the_positions(
    http: httpx2.Client, job: Json, result: Json
) -> None:
    with np.load(io.BytesIO(http.get(job["links"]["arrays"]).content)) as arrays:
        found = dict(arrays)
    assert found["positions"].shape == (3, TEMPLATE.n_vertices, 3)
    np.testing.assert_array_equal(found["faces"], TEMPLATE.faces)
    listed = [one["scores"] for one in result["specimens"][:3]]
    np.testing.assert_allclose(found["scores"], listed)
    # Copies differ by size alone, which is one component.
    assert found["explained"][0] > 0.999
    aligned = found["mean"] + np.einsum("mc,cvd->mvd", found["scores"], found["components"])
    for one, given in zip(aligned, found["positions"], strict=True):
        apart, known = (np.linalg.norm(p - p.mean(axis=0), axis=1) for p in (one, given))
        np.testing.assert_allclose(apart, known, atol=1e-9)


def test_rows_of_vertices_that_no_face_uses(
    http: httpx2.Client, given: tuple[str, list[str]], upload: Upload
) -> None:
    """They are those of the first used vertex."""
    vertices = np.concatenate([np.full((2, 3), 50.0), TEMPLATE.vertices, np.full((1, 3), 60.0)])
    data = mesh_files.ply(vertices, (TEMPLATE.faces + 2).tolist(), "ascii")
    body = {"template": upload(data, "unused.ply")["id"], "shapes": given[1][:1]}
    found = ended(http, http.post("/v1/registrations", json=body))
    with np.load(io.BytesIO(http.get(found["links"]["arrays"]).content)) as arrays:
        positions, mean, faces = arrays["positions"], arrays["mean"], arrays["faces"]
    np.testing.assert_array_equal(faces, TEMPLATE.faces + 2)
    assert positions.shape == (1, TEMPLATE.n_vertices + 3, 3)
    for rows in (positions[0], mean):
        np.testing.assert_array_equal(rows[[0, 1, -1]], rows[[2, 2, 2]])
    np.testing.assert_allclose(positions[0, 2:-1], PLACES[0], atol=0.01)


def test_without_size_nothing_varies(http: httpx2.Client, given: tuple[str, list[str]]) -> None:
    template, specimens = given
    body = {"template": template, "shapes": specimens[:3], "scale": True}
    found = ended(http, http.post("/v1/registrations", json=body))
    result = http.get(found["links"]["result"]).json()
    total = sum(one["variance"] for one in result["components"])
    assert total < 1e-4 * TEMPLATE.area
    assert all(one["registered"] for one in result["specimens"])


def test_the_picture_is_a_picture(http: httpx2.Client, job: Json) -> None:
    answer = http.get(job["links"]["picture"])
    assert answer.headers["content-type"] == "image/png"
    assert answer.content.startswith(b"\x89PNG")


def test_the_source_of_a_dense_match_is_registered_to_its_target(
    http: httpx2.Client, given: tuple[str, list[str]]
) -> None:
    template, specimens = given
    match = matched(http, (template, specimens[1]), points=12, dense=True)
    answer = http.get(f"/v1/jobs/{match['id']}/registered.glb")
    np.testing.assert_allclose(positions_of(answer, "glb"), PLACES[1], atol=0.01)
    colors = read_mesh(answer.content, "glb").colors
    assert colors is not None
    np.testing.assert_allclose(colors, COLORS, atol=1 / 255)
    sparse = matched(http, (template, specimens[1]), points=12)
    refused = http.get(f"/v1/jobs/{sparse['id']}/registered.glb")
    assert "`dense`" in problem(refused, 409, "job-without-result")["detail"]


def test_templates_that_there_are_not_are_refused(http: httpx2.Client, job: Json) -> None:
    path = f"/v1/jobs/{job['id']}/registered.ply"
    named = http.head(path, params={"specimen": 2}).headers["content-disposition"]
    assert 'filename="template-on-specimen2.ply"' in named
    failed = problem(http.get(path, params={"specimen": 3}), 409, "job-without-result")
    assert "could not be registered" in failed["detail"]
    wrong = problem(http.get(path, params={"specimen": 4}), 422, "invalid-request")
    assert wrong["errors"][0]["field"] == "query.specimen"


def test_repeated_specimens_and_missing_names_are_refused(
    http: httpx2.Client, given: tuple[str, list[str]]
) -> None:
    template, specimens = given
    body = {"template": template, "shapes": [specimens[0], specimens[0]]}
    wrong = problem(http.post("/v1/registrations", json=body), 422, "invalid-request")
    assert wrong["errors"][0]["field"] == "body.shapes.1"
    body = {"template": template, "shapes": specimens[:2], "names": ["one"]}
    wrong = problem(http.post("/v1/registrations", json=body), 422, "invalid-request")
    assert wrong["errors"][0]["field"] == "body.names"


def test_a_cancelled_registration_ends(http: httpx2.Client, given: tuple[str, list[str]]) -> None:
    template, specimens = given
    body = {"template": template, "shapes": specimens[:3], "largest_component": True}
    queued = http.post("/v1/registrations", json=body)
    http.delete(f"/v1/jobs/{queued.json()['id']}")
    assert ended(http, queued)["state"] == "cancelled"


def test_deleted_specimens_are_named_as_deleted(
    http: httpx2.Client, given: tuple[str, list[str]], upload: Upload
) -> None:
    template, specimens = given
    coarse = specimens[-1]
    gone = [upload(blob_file(2, seed=seed))["id"] for seed in (90, 91)]
    lasting = [upload(blob_file(4, seed=seed))["id"] for seed in (92, 93, 94)]
    # Both workers are busy, so that no registration is begun when its specimens are deleted.
    busy = batch(http, {"source": lasting[0], "targets": lasting[1:], **SLOW})
    awaited(http, busy, lambda now: [one.state for one in now.matches] == ["running"] * 2)
    asked = [gone, [coarse, gone[1]], [coarse]]
    queued = [
        http.post("/v1/registrations", json={"template": template, "shapes": ids}) for ids in asked
    ]
    for shape in gone:
        assert http.delete(f"/v1/shapes/{shape}").status_code == 204
    http.delete(busy["links"]["self"])
    jobs = [ended(http, answer) for answer in queued]
    assert [job["state"] for job in jobs] == ["failed"] * 3
    problems = [job["error"] for job in jobs]
    slugs = [one["type"].rsplit(":", 1)[-1] for one in problems]
    assert slugs == ["shape-deleted", "shape-deleted", "unusable-mesh"]
    for shape, stated in zip(gone, problems, strict=False):
        assert shape in stated["detail"]
