"""Transfers through the whole chain: attribute files in, files in every format out."""

import csv
import io
import zipfile
from typing import Any, get_args

import httpx2
import numpy as np
import pytest
import trimesh
from scipy.spatial import KDTree

from broker.contracts import ATTRIBUTE_FORMATS as CONTRACT_FORMATS
from broker.contracts import MatchResult, TransferKind
from broker.store import DEFAULT_KEYS
from solver.arrays import FloatArray
from solver.mesh import read_mesh, textured_surface, triangle_areas
from solver.transfer import KINDS, Attribute
from solver.transfer.files import (
    ATTRIBUTE_FORMATS,
    WrittenSurface,
    read_attributes,
    write_npz,
    write_surface,
)
from tests.service.conftest import Api, Json, Upload, problem
from tests.service.matching import matched
from tests.solver import shapes
from tests.solver.mesh import mesh_files
from tests.solver.mesh.mesh_files import file_of
from tests.solver.mesh.textures.textured_files import (
    MTL,
    image_file,
    ramp,
    textured_glb,
    textured_obj,
    zipped,
    zipped_obj,
)
from tests.worker.figures import blob_file
from tests.workers import nothing_is_left

MESH = shapes.blob(3)
OTHER, TRUTH = shapes.permuted(shapes.moved(MESH, 4), seed=23)
"""Vertex i of the one is vertex TRUTH[i] of the other."""

COUNT = MESH.n_vertices
LABELS = np.array(["head", "arm", "leg"])[(np.arange(COUNT) // 7) % 3]
COLORS = np.random.default_rng(0).integers(0, 256, size=(COUNT, 3)) / 255.0


@pytest.fixture(scope="module")
def pair(upload: Upload) -> tuple[str, str]:
    colored = WrittenSurface.of(MESH, [Attribute("colors", COLORS)])
    source = upload(write_surface(colored, "ply"), "body.ply")["id"]
    return source, upload(file_of(OTHER), "other.ply")["id"]


@pytest.fixture(scope="module")
def match(http: httpx2.Client, pair: tuple[str, str]) -> str:
    found: str = matched(http, pair, points=12, dense=True)["id"]
    return found


def send(http: httpx2.Client, data: bytes, name: str = "values.csv") -> httpx2.Response:
    return http.post("/v1/attributes", files={"file": (name, data)})


def table(**columns: Any) -> bytes:
    stream = io.StringIO()
    writer = csv.writer(stream)
    writer.writerow(columns)
    writer.writerows(zip(*columns.values(), strict=True))
    return stream.getvalue().encode()


def archive(**arrays: Any) -> bytes:
    return write_npz([Attribute(name, np.asarray(values)) for name, values in arrays.items()])


def carried(http: httpx2.Client, match: str, **asked: Any) -> Json:
    """The job of a transfer that has ended."""
    answer = http.post("/v1/transfers", json={"match": match, **asked})
    assert answer.status_code == 202, answer.text
    job: Json = answer.json()
    ended: Json = http.get(job["links"]["self"], params={"wait": 60}).json()
    return ended


def arrays_of(http: httpx2.Client, job: Json) -> dict[str, Any]:
    assert job["state"] == "succeeded", job["error"]
    data = http.get(job["links"]["arrays"]).content
    return {one.name: one.values for one in read_attributes(data, "npz")}


def export(http: httpx2.Client, job: Json, ending: str) -> httpx2.Response:
    """The result in a format, which is listed with the job if it can be made."""
    link = f"{job['links']['self']}/result.{ending}"
    answer = http.get(link)
    assert (link in job["links"]["exports"]) == answer.is_success
    return answer


def test_labels_of_a_table(http: httpx2.Client, match: str, pair: tuple[str, str]) -> None:
    answer = send(http, table(part=LABELS), "segments.csv")
    assert answer.status_code == 201
    uploaded = answer.json()
    assert (uploaded["name"], uploaded["rows"]) == ("segments.csv", COUNT)
    described: Json = {"name": "part", "type": "text", "columns": [], "on": None, "rows": COUNT}
    assert uploaded["attributes"] == [described]
    assert http.get(f"/v1/attributes/{uploaded['id']}").json() == uploaded
    job = carried(http, match, attributes=uploaded["id"], what="labels")
    assert (job["source"], job["target"], job["kind"]) == (*pair, "transfer")
    assert job["parameters"] == {"what": "labels"}
    np.testing.assert_array_equal(arrays_of(http, job)["part"][TRUTH], LABELS)
    result = http.get(job["links"]["result"]).json()
    assert (result["source_name"], result["target_name"]) == ("body.ply", "other.ply")
    assert (result["rows"], result["warnings"]) == (COUNT, [])
    exported = http.get(job["links"]["exports"][0])
    assert 'filename="labels-body-to-other.csv"' in exported.headers["content-disposition"]
    rows = list(csv.reader(io.StringIO(exported.text)))
    assert rows[0] == ["vertex", "part"]
    assert [row[1] for row in rows[1:]] == arrays_of(http, job)["part"].tolist()


def test_a_transfer_has_the_confidence_of_its_match(
    http: httpx2.Client, upload: Upload, match: str
) -> None:
    cube = shapes.cube(8)
    symmetric = [upload(file_of(one), "cube.ply")["id"] for one in (cube, shapes.moved(cube, 3))]
    unsure = matched(http, (symmetric[0], symmetric[1]), points=12, dense=True)["id"]
    doubt = "the match is in doubt: what it carries may lie in wrong places"
    for job, warnings in ((match, []), (unsure, [doubt])):
        known = http.get(f"/v1/jobs/{job}/result").json()["confidence"]
        assert (known["probability"] < 0.5) == bool(warnings)
        moved = carried(http, job, what="landmarks", points=[0])
        result = http.get(moved["links"]["result"]).json()
        assert (result["confidence"], result["warnings"]) == (known, warnings)


def test_values_that_are_missing_are_no_rows_without_partner(
    http: httpx2.Client, match: str
) -> None:
    heights = np.where(np.arange(COUNT) < 9, np.nan, 1.0)
    texts = np.where(np.arange(COUNT) % 2, "arm", "")
    stream = io.BytesIO()
    full = np.ones(COUNT)
    np.savez(stream, height=heights, part=np.full(COUNT, -1), name=texts, full=full, depth=heights)
    uploaded = send(http, stream.getvalue(), "gaps.npz").json()["id"]
    for what, warnings in (
        ("labels", []),
        (
            "scalars",
            ["9 vertices have no value of 'height', 'depth': what they correspond to has none"],
        ),
    ):
        job = carried(
            http,
            match,
            attributes=uploaded,
            what=what,
            names=["part", "name"] if what == "labels" else ["height", "depth", "full"],
        )
        assert http.get(job["links"]["result"]).json()["warnings"] == warnings


def test_there_and_back_loses_nothing_on_a_copy(http: httpx2.Client, match: str) -> None:
    height = MESH.vertices[:, 1]
    first = send(http, archive(height=height), "h.npz").json()["id"]
    there = carried(http, match, attributes=first, what="scalars")
    data = http.get(there["links"]["exports"][1]).content
    second = send(http, data, "there.ply").json()["id"]
    back = carried(http, match, attributes=second, what="scalars", direction="target_to_source")
    np.testing.assert_allclose(arrays_of(http, back)["height"], height, atol=1e-3)
    assert (back["source"], back["target"]) == (there["target"], there["source"])


def test_what_is_carried_has_a_row_for_each_vertex_of_the_file(
    http: httpx2.Client, upload: Upload
) -> None:
    """Also for the last ones, if no face uses them; so it can be carried again, onto faces, too."""
    places = np.r_[OTHER.vertices, OTHER.vertices + 1.0]
    unused = upload(mesh_files.ply(places, OTHER.faces.tolist(), "ascii"), "unused.ply")["id"]
    match = matched(http, (unused, unused), points=12, dense=True)["id"]
    given = send(http, archive(part=np.arange(2 * COUNT)), "part.npz").json()["id"]
    job = carried(http, match, attributes=given, what="labels")
    expected = np.where(np.arange(2 * COUNT) < COUNT, np.arange(2 * COUNT), -1)
    np.testing.assert_array_equal(arrays_of(http, job)["part"], expected)
    result = http.get(job["links"]["result"]).json()
    assert result["warnings"] == [
        f"{COUNT} vertices of the file are not part of the mapped surface"
    ]
    again = send(http, export(http, job, "csv").content, "again.csv").json()["id"]
    for on, rows in (("vertices", 2 * COUNT), ("faces", OTHER.n_faces)):
        job = carried(http, match, attributes=again, what="labels", on=on)
        assert len(arrays_of(http, job)["part"]) == rows


def test_colours_of_the_shape_itself_in_every_format(http: httpx2.Client, match: str) -> None:
    job = carried(http, match, what="colors")
    np.testing.assert_allclose(arrays_of(http, job)["colors"][TRUTH], COLORS, atol=1e-3)
    refused = problem(export(http, job, "zip"), 409, "job-without-result")
    assert "choose one of NPZ, CSV, PLY, OBJ, GLB" in refused["detail"]
    for link in job["links"]["exports"][1:4]:
        answer = http.get(link)
        kind = link.rpartition(".")[2]
        assert answer.headers["content-type"].startswith("model/")
        found = read_mesh(answer.content, kind)
        assert found.colors is not None
        np.testing.assert_allclose(found.colors[TRUTH], COLORS, atol=3e-3)
        np.testing.assert_allclose(found.vertices, OTHER.vertices, atol=1e-5)
        seen: Any = trimesh.load(io.BytesIO(answer.content), file_type=kind, force="mesh")
        assert len(seen.faces) == OTHER.n_faces


def test_exports_have_names_that_the_archive_has_for_its_own(
    http: httpx2.Client, match: str
) -> None:
    heights = MESH.vertices[:, 1].tolist()
    uploaded = send(http, table(joint_names=heights, depth=heights)).json()["id"]
    job = carried(http, match, attributes=uploaded, what="scalars")
    assert [*arrays_of(http, job)] == ["joint_names_", "depth"]
    for file_type in ("csv", "ply"):
        found = read_attributes(export(http, job, file_type).content, file_type)
        assert [one.name for one in found] == ["joint_names", "depth"]
        np.testing.assert_allclose(found[0].values[TRUTH], heights, atol=1e-3)


def test_skinning_weights_as_a_skinned_surface(http: httpx2.Client, match: str) -> None:
    weights = np.random.default_rng(1).random((COUNT, 3))
    skin = Attribute("weights", weights, ("hip", "knee", "foot"), parents=(-1, 0, 1))
    data = write_surface(WrittenSurface.of(MESH, [skin]), "glb")
    uploaded = send(http, data, "rig.glb").json()
    assert uploaded["attributes"][0]["columns"] == ["hip", "knee", "foot"]
    job = carried(http, match, attributes=uploaded["id"], what="skinning")
    shares = weights / weights.sum(axis=1, keepdims=True)
    np.testing.assert_allclose(arrays_of(http, job)["weights"][TRUTH], shares, atol=1e-3)
    refused = problem(export(http, job, "obj"), 409, "job-without-result")
    assert "OBJ cannot hold skinning; choose one of NPZ, CSV, PLY, GLB" in refused["detail"]
    (found,) = read_attributes(export(http, job, "glb").content, "glb")
    assert (found.columns, found.parents) == (skin.columns, skin.parents)
    np.testing.assert_allclose(found.values.sum(axis=1), 1.0, atol=1e-6)
    few = carried(
        http, match, attributes=uploaded["id"], what="skinning", names=["foot", "hip"], influences=1
    )
    assert set(arrays_of(http, few)["weights"].ravel()) == {0.0, 1.0}
    (chosen,) = read_attributes(export(http, few, "glb").content, "glb")
    assert chosen.parents == (1, -1)
    # The other way, onto a surface with colours, which stay.
    onto = {"attributes": uploaded_weights(http, weights), "direction": "target_to_source"}
    colored = export(http, carried(http, match, what="skinning", **onto), "glb").content
    kept = {one.name: one.values for one in read_attributes(colored, "glb")}
    np.testing.assert_allclose(kept["weights"], shares[TRUTH], atol=1e-3)
    np.testing.assert_allclose(kept["colors"][:, :3], COLORS, atol=3e-3)


def uploaded_weights(http: httpx2.Client, weights: FloatArray) -> str:
    """Id of a file of skinning weights."""
    found: str = send(http, archive(weights=weights), "weights.npz").json()["id"]
    return found


def test_landmarks(http: httpx2.Client, match: str) -> None:
    corners = MESH.faces[40].tolist()
    points = [5, {"vertices": corners, "weights": [0.2, 0.3, 0.5]}]
    job = carried(http, match, what="landmarks", points=points)
    first, second = http.get(job["links"]["result"]).json()["points"]
    assert max(zip(first["weights"], first["vertices"], strict=True))[1] == TRUTH[5]
    assert set(second["vertices"]) == set(TRUTH[corners].tolist())
    shares = dict(zip(second["vertices"], second["weights"], strict=True))
    found = [shares[vertex] for vertex in TRUTH[corners].tolist()]
    np.testing.assert_allclose(found, [0.2, 0.3, 0.5], atol=1e-2)
    for one in first, second:
        place = one["weights"] @ OTHER.vertices[one["vertices"]]
        np.testing.assert_allclose(one["position"], place, atol=1e-5)
    assert http.get(job["links"]["exports"][0]).text.count("\n") == 3
    for ending in ("ply", "obj", "glb", "zip"):
        refused = problem(export(http, job, ending), 409, "job-without-result")
        assert "choose one of NPZ, CSV" in refused["detail"]


def test_landmarks_at_no_vertex_are_refused_and_those_without_an_image_missing(
    http: httpx2.Client, match: str, upload: Upload
) -> None:
    inside = {"vertices": [1, COUNT, 2], "weights": [0.2, 0.3, 0.5]}
    asked = {"match": match, "what": "landmarks", "points": [5, inside, 10**6]}
    refused = problem(http.post("/v1/transfers", json=asked), 422, "invalid-request")
    assert refused["errors"] == [
        {
            "field": f"body.points.{place}",
            "message": f"{vertex} is no vertex of the match's source, whose file has vertices 0 to"
            f" {COUNT - 1}",
            "pointer": f"/points/{place}",
        }
        for place, vertex in ((1, COUNT), (2, 10**6))
    ]
    data = mesh_files.ply(
        np.r_[OTHER.vertices, OTHER.vertices + 1.0], OTHER.faces.tolist(), "ascii"
    )
    unused = upload(data, "unused.ply")["id"]
    again = matched(http, (unused, unused), points=12, dense=True)["id"]
    job = carried(http, again, what="landmarks", points=[COUNT, 5])
    result = http.get(job["links"]["result"]).json()
    missing, found = result["points"]
    assert missing is None
    assert max(zip(found["weights"], found["vertices"], strict=True))[1] == 5
    assert "1 of 2 landmarks are missing" in result["warnings"][0]
    assert "points 0, counted" in result["warnings"][0]
    arrays = arrays_of(http, job)
    assert arrays["vertices"][0].tolist() == [-1, -1, -1]
    assert np.isnan(arrays["weights"]).tolist() == [[True] * 3, [False] * 3]
    assert export(http, job, "csv").text.splitlines()[1] == ",,,,,,"
    alone = carried(http, again, what="landmarks", points=[COUNT])
    assert http.get(alone["links"]["result"]).json()["points"] == [None]


def test_a_texture_as_colours_and_as_an_image(http: httpx2.Client, upload: Upload) -> None:
    shares = (MESH.vertices[:, :2] - MESH.vertices[:, :2].min()) / np.ptp(MESH.vertices[:, :2])
    data = textured_glb(MESH.vertices, MESH.faces, 0.1 + 0.8 * shares, image_file(ramp()))
    pair = upload(data, "textured.glb")["id"], upload(file_of(OTHER), "other.ply")["id"]
    match = matched(http, pair, points=10, dense=True)["id"]
    job = carried(http, match, what="texture")
    expected = ((0.1 + 0.8 * shares) * 256 - 0.5) / 255.0
    colors = arrays_of(http, job)["colors"][TRUTH]
    np.testing.assert_allclose(colors[:, :2], expected, atol=4e-3)
    baked = http.get(job["links"]["exports"][3]).content
    seen: Any = trimesh.load(io.BytesIO(baked), file_type="glb", force="mesh")
    assert seen.visual.material.baseColorTexture.size[0] > 64
    for written, file_type in (
        (baked, "glb"),
        (export(http, job, "zip").content, "zip"),
    ):
        found = read_mesh(written, file_type)
        assert found.colors is not None
        same = KDTree(OTHER.vertices[TRUTH]).query(found.vertices)[1]
        assert np.abs(found.colors[:, :2] - expected[same]).mean() < 0.05
    failed = carried(http, match, what="texture", direction="target_to_source")
    assert failed["error"]["errors"][0]["field"] == "body.what"


def test_texture_coordinates_with_and_without_the_image(
    http: httpx2.Client, upload: Upload
) -> None:
    low = MESH.vertices[:, :2].min(axis=0)
    shares = 0.1 + 0.8 * (MESH.vertices[:, :2] - low) / np.ptp(MESH.vertices[:, :2], axis=0)
    upwards = shares * [1.0, -1.0] + [0.0, 1.0]
    target = upload(file_of(OTHER), "other.ply")["id"]
    files = {
        "textured.glb": textured_glb(MESH.vertices, MESH.faces, shares, image_file(ramp())),
        "textured.zip": zipped_obj(MESH.vertices, MESH.faces, upwards, image_file(ramp())),
        "bare.obj": textured_obj(MESH.vertices, MESH.faces, upwards),
    }
    for name, data in files.items():
        match = matched(http, (upload(data, name)["id"], target), points=10, dense=True)["id"]
        job = carried(http, match, what="uv")
        result = http.get(job["links"]["result"]).json()
        assert (result["on"], result["rows"]) == ("corners", 3 * OTHER.n_faces)
        arrays = arrays_of(http, job)
        np.testing.assert_array_equal(arrays["vertex"].reshape(-1, 3), OTHER.faces)
        expected = np.empty_like(upwards)
        expected[TRUTH] = upwards
        np.testing.assert_allclose(arrays["uv"], expected[OTHER.faces.ravel()], atol=5e-3)
        table, ply, obj, glb, packed = (
            export(http, job, ending) for ending in ("csv", "ply", "obj", "glb", "zip")
        )
        assert table.text.startswith("corner,vertex,uv.u,uv.v,texture\n0,")
        assert "cannot hold uv" in problem(ply, 409, "job-without-result")["detail"]
        seen: Any = trimesh.load(io.BytesIO(obj.content), file_type="obj", force="mesh")
        assert len(seen.faces) == OTHER.n_faces
        assert seen.visual.uv.shape == (len(seen.vertices), 2)
        shown: Any = trimesh.load(io.BytesIO(glb.content), file_type="glb", force="mesh")
        assert len(shown.faces) == OTHER.n_faces
        if name != "bare.obj":
            assert shown.visual.material.baseColorTexture.size == (256, 256)
            for written, file_type in ((glb.content, "glb"), (packed.content, "zip")):
                found = read_mesh(written, file_type)
                assert found.colors is not None
                same = KDTree(OTHER.vertices[TRUTH]).query(found.vertices)[1]
                apart = found.colors[:, :2] - (256 * shares[same] - 0.5) / 255.0
                assert np.abs(apart).mean() < 0.02
        if name == "textured.glb":
            weights = np.random.default_rng(2).random((COUNT, 2))
            onto = {
                "attributes": uploaded_weights(http, weights),
                "direction": "target_to_source",
            }
            skinned = export(http, carried(http, match, what="skinning", **onto), "glb").content
            (skin,) = read_attributes(skinned, "glb")
            np.testing.assert_allclose(skin.values.sum(axis=1), 1.0, atol=1e-6)
            kept, given = (textured_surface(one, "glb") for one in (skinned, data))
            assert kept is not None
            assert given is not None
            np.testing.assert_allclose(kept[1].coordinates, given[1].coordinates, atol=1e-6)
            np.testing.assert_array_equal(kept[1].textures[0].pixels, given[1].textures[0].pixels)
        with zipfile.ZipFile(io.BytesIO(packed.content)) as parts:
            images = ["texture0.png"] if name != "bare.obj" else []
            assert sorted(parts.namelist()) == ["other.mtl", "other.obj", *images]
            assert len(read_mesh(parts.read("other.obj"), "obj").faces) == OTHER.n_faces
    failed = carried(http, match, what="uv", direction="target_to_source")
    assert failed["error"]["errors"][0]["field"] == "body.what"


@pytest.mark.parametrize(
    ("asked", "field"),
    [
        ({"what": "landmarks"}, "body.points"),
        ({"what": "uv", "names": ["a"]}, "body.names"),
        ({"what": "uv", "on": "faces"}, "body.on"),
        ({"what": "texture", "names": ["a"]}, "body.names"),
        ({"what": "labels", "points": [1]}, "body.points"),
        ({"what": "landmarks", "points": [1], "names": ["a"]}, "body.names"),
        ({"what": "labels", "influences": 2}, "body.influences"),
        ({"what": "labels", "on": "edges"}, "body.on"),
        ({"what": "skinning", "on": "faces"}, "body.on"),
        ({"what": "texture", "on": "faces"}, "body.on"),
        ({"what": "textures"}, "body.what"),
        ({"what": "labels", "direction": "back"}, "body.direction"),
        ({"what": "landmarks", "points": [-1]}, "body.points.0"),
        (
            {"what": "landmarks", "points": [3, {"vertices": [0, 1, 2], "weights": [1, 1, 1]}]},
            "body.points.1",
        ),
        ({"what": "labels", "names": ["a", "b", "a"]}, "body.names"),
        ({}, "body.what"),
        ({"what": "labels", "attributes": 7}, "body.attributes"),
        ({"what": "labels", "colour": 7}, "body.colour"),
    ],
)
def test_requests_that_contradict_themselves(
    http: httpx2.Client, match: str, asked: Json, field: str
) -> None:
    answer = http.post("/v1/transfers", json={"match": match, **asked})
    found = problem(answer, 422, "invalid-request")
    assert found["errors"][0]["field"].startswith(field)


def test_files_that_do_not_fit(http: httpx2.Client, match: str) -> None:
    short = send(http, table(a=range(10))).json()["id"]
    asked = {"match": match, "attributes": short, "what": "scalars"}
    answer = problem(http.post("/v1/transfers", json=asked), 422, "invalid-request")
    assert answer["errors"][0]["field"] == "body.attributes"
    has = f"body.ply has {COUNT:,} vertices and {MESH.n_faces:,} faces"
    assert has in answer["errors"][0]["message"]
    assert "was taken for the names" not in answer["errors"][0]["message"]
    for count in (COUNT, MESH.n_faces):
        nameless = send(http, "\n".join(f"part{row % 9}" for row in range(count)).encode())
        wrong = {"match": match, "attributes": nameless.json()["id"], "what": "labels"}
        answer = problem(http.post("/v1/transfers", json=wrong), 422, "invalid-request")
        said = answer["errors"][0]["message"]
        assert said.endswith("the first line, 'part0', was taken for the names of the columns")
    long = send(http, table(a=range(3 * COUNT))).json()["id"]
    asked["attributes"] = long
    problem(http.post("/v1/transfers", json=asked), 422, "invalid-request")


def test_rows_of_corners_are_refused_with_both_numbers(http: httpx2.Client, match: str) -> None:
    uploaded = send(http, table(a=np.arange(3 * MESH.n_faces) % 3)).json()["id"]
    asked = {"match": match, "attributes": uploaded, "what": "labels"}
    refused = problem(http.post("/v1/transfers", json=asked), 422, "invalid-request")
    assert refused["errors"] == [
        {
            "field": "body.attributes",
            "message": f"it has {3 * MESH.n_faces:,} rows, but body.ply has {COUNT:,} vertices and"
            f" {MESH.n_faces:,} faces; give a row for each vertex, or for each face",
            "pointer": "/attributes",
        }
    ]


def test_a_single_row_is_named_in_the_singular(http: httpx2.Client, match: str) -> None:
    asked = {"match": match, "attributes": send(http, table(a=[5])).json()["id"], "what": "labels"}
    refused = problem(http.post("/v1/transfers", json=asked), 422, "invalid-request")
    assert refused["errors"][0]["message"].startswith("it has 1 row, but body.ply has")


FACE_LABELS = (MESH.vertices[MESH.faces].mean(axis=1)[:, 2] > 0.1).astype(np.int64) + 3


def faces_of_other() -> np.ndarray:
    """(F,) the face of the one shape that each face of the other is."""
    places = {tuple(sorted(row)): number for number, row in enumerate(TRUTH[MESH.faces].tolist())}
    return np.array([places[tuple(sorted(row))] for row in OTHER.faces.tolist()])


@pytest.mark.parametrize(
    ("name", "data"),
    [
        ("parts.seg", "\n".join(map(str, FACE_LABELS.tolist())).encode()),
        ("parts.csv", table(label=FACE_LABELS)),
        ("parts.npz", archive(label=FACE_LABELS)),
    ],
)
def test_labels_of_faces(http: httpx2.Client, match: str, name: str, data: bytes) -> None:
    uploaded = send(http, data, name).json()
    job = carried(http, match, attributes=uploaded["id"], what="labels")
    result = http.get(job["links"]["result"]).json()
    assert (result["on"], result["rows"]) == ("faces", OTHER.n_faces)
    found = arrays_of(http, job)["label"]
    assert (found == FACE_LABELS[faces_of_other()]).mean() > 0.99
    rows = list(csv.reader(io.StringIO(http.get(job["links"]["exports"][0]).text)))
    assert rows[0] == ["face", "label"]
    assert [int(row[1]) for row in rows[1:]] == found.tolist()


def test_labels_of_faces_in_files_of_surfaces_and_back(http: httpx2.Client, match: str) -> None:
    first = send(http, archive(part=FACE_LABELS), "p.npz").json()["id"]
    there = carried(http, match, attributes=first, what="labels")
    ply, obj, glb = (http.get(link).content for link in there["links"]["exports"][1:4])
    seen: Any = trimesh.load(io.BytesIO(ply), file_type="ply", process=False)
    labels = seen.metadata["_ply_raw"]["face"]["data"]["part"].ravel()
    np.testing.assert_array_equal(labels, arrays_of(http, there)["part"])
    assert {line for line in obj.decode().splitlines() if line[0] == "g"} == {
        "g part_3",
        "g part_4",
    }
    assert len(read_mesh(glb, "glb").faces) == OTHER.n_faces
    second = send(http, ply, "there.ply").json()["id"]
    back = carried(http, match, attributes=second, what="labels", direction="target_to_source")
    assert (arrays_of(http, back)["part"] == FACE_LABELS).mean() > 0.99


def test_values_of_faces_onto_vertices_and_the_reverse(http: httpx2.Client, match: str) -> None:
    height = MESH.vertices[:, 2]
    of_faces = send(http, archive(z=height[MESH.faces].mean(axis=1)), "f.npz").json()["id"]
    job = carried(http, match, attributes=of_faces, what="scalars", on="vertices")
    assert http.get(job["links"]["result"]).json()["on"] == "vertices"
    shares = np.repeat(triangle_areas(MESH.vertices, MESH.faces), 3)
    sums = np.bincount(MESH.faces.ravel(), shares * height[MESH.faces].mean(axis=1).repeat(3))
    cells = sums / np.bincount(MESH.faces.ravel(), shares)
    np.testing.assert_allclose(arrays_of(http, job)["z"][TRUTH], cells, atol=0.02)
    of_vertices = send(http, archive(z=height), "v.npz").json()["id"]
    job = carried(http, match, attributes=of_vertices, what="scalars", on="faces")
    moved = np.linalg.lstsq(np.c_[OTHER.vertices[TRUTH], np.ones(COUNT)], height, rcond=None)[0]
    expected = (np.c_[OTHER.vertices, np.ones(COUNT)] @ moved)[OTHER.faces].mean(axis=1)
    np.testing.assert_allclose(arrays_of(http, job)["z"], expected, atol=0.02)


@pytest.mark.parametrize(
    ("data", "what", "message"),
    [
        (archive(a=np.full(MESH.n_faces, np.inf)), "scalars", "of face 0 is infinite"),
        (archive(weights=np.ones((MESH.n_faces, 2))), "skinning", "of vertices, not of faces"),
        (archive(a=np.full(MESH.n_faces, "arm")), "scalars", "the file has no scalars"),
        (table(face=range(COUNT), a=range(COUNT)), "labels", f"{COUNT} rows of faces"),
    ],
    ids=["infinite", "skinning", "text", "too few faces"],
)
def test_values_of_faces_that_do_not_fit(
    http: httpx2.Client, match: str, data: bytes, what: str, message: str
) -> None:
    name = "a.npz" if data.startswith(b"PK") else "a.csv"
    uploaded = send(http, data, name).json()["id"]
    failed = carried(http, match, attributes=uploaded, what=what)
    assert failed["error"]["status"] == 422
    assert message in failed["error"]["detail"]


def quads(cells: int = 8) -> tuple[np.ndarray, list[list[int]]]:
    """The blob as a cube of squares, blown up."""
    steps = np.linspace(-1.0, 1.0, cells + 1)
    v, u = (one.ravel() for one in np.meshgrid(steps, steps))
    one = np.ones_like(u)
    sides = [(v, u, -one), (u, v, one), (-one, v, u), (one, u, v), (u, -one, v), (v, one, u)]
    soup = np.concatenate([np.stack(axes, axis=1) for axes in sides])
    places, inverse = np.unique(np.round(soup, 6), axis=0, return_inverse=True)
    row = cells + 1
    first = np.add.outer(np.arange(cells) * row, np.arange(cells)).ravel()
    side = np.stack([first, first + 1, first + row + 1, first + row], axis=1)
    faces = np.concatenate([side + number * row * row for number in range(6)])
    directions = places / np.linalg.norm(places, axis=1, keepdims=True)
    return shapes.with_bumps(directions), inverse.reshape(-1)[faces].tolist()


def polygons(vertices: np.ndarray, faces: list[list[int]], parts: list[int]) -> bytes:
    """PLY as text, with the property ``part`` of the faces."""
    lines = mesh_files.ply(vertices, faces, "ascii").decode().splitlines()
    place = lines.index("end_header")
    first = place + 1 + len(vertices)
    rows = [f"{row} {part}" for row, part in zip(lines[first:], parts, strict=True)]
    header = [*lines[:place], "property int part", "end_header"]
    return "\n".join([*header, *lines[place + 1 : first], *rows, ""]).encode()


def test_segmentations_of_polygons(http: httpx2.Client, upload: Upload) -> None:
    """A face of the file is a row, whatever triangles it was cut into, in the shape's own file."""
    vertices, faces = quads()
    parts = [*range(len(faces))]
    source = upload(polygons(vertices, faces, parts), "box.ply")
    assert (source["file_vertices"], source["file_faces"]) == (len(vertices), len(faces))
    assert source["faces"] == 2 * len(faces)
    target = upload(polygons(vertices + 3.0, faces[::-1], parts), "moved.ply")
    match = matched(http, (source["id"], target["id"]), points=8, eigenpairs=30, dense=True)["id"]
    job = carried(http, match, what="labels")
    found = arrays_of(http, job)["part"]
    assert found.shape == (len(faces),)
    assert (found == parts[::-1]).mean() > 0.95


@pytest.mark.parametrize(
    ("asked", "field"),
    [
        ({"what": "colors"}, "body.what"),
        ({"what": "labels", "names": ["half"]}, "body.names"),
    ],
)
def test_what_a_file_does_not_have(
    http: httpx2.Client, match: str, asked: Json, field: str
) -> None:
    uploaded = send(http, table(a=range(COUNT), half=[0.5] * COUNT)).json()["id"]
    failed = carried(http, match, attributes=uploaded, **asked)
    assert failed["state"] == "failed"
    assert failed["error"]["status"] == 422
    assert failed["error"]["errors"][0]["field"] == field


def test_labels_of_an_obj_in_a_zip(
    http: httpx2.Client, upload: Upload, pair: tuple[str, str]
) -> None:
    lines = textured_obj(MESH.vertices, MESH.faces, MESH.vertices[:, :2]).decode().splitlines()
    faces = [place for place, line in enumerate(lines) if line.startswith("f ")]
    for at, name in ((faces[len(faces) // 2], "g hind"), (faces[0], "g front")):
        lines.insert(at, name)
    obj = "\n".join(lines).encode()
    files = {"skin.obj": obj, "skin.mtl": MTL, "skin.png": image_file(ramp())}
    packed = upload(zipped(files), "packed.zip")["id"]
    match = matched(http, (packed, pair[1]), points=12, dense=True)["id"]
    found = arrays_of(http, carried(http, match, what="labels"))
    assert set(found["group"]) == {"front", "hind"}


@pytest.mark.parametrize("what", ["scalars", "skinning"])
def test_names_that_a_file_does_not_have_are_refused_at_once(
    http: httpx2.Client, match: str, what: str
) -> None:
    uploaded = send(http, table(a=range(COUNT))).json()["id"]
    asked = {"match": match, "what": what, "attributes": uploaded, "names": ["a", "b", "c"]}
    refused = problem(http.post("/v1/transfers", json=asked), 422, "invalid-request")
    assert [error["field"] for error in refused["errors"]] == ["body.names.1", "body.names.2"]
    assert refused["errors"][0]["message"] == "'b' is not in the file, which has a"


def test_a_shape_without_attributes_of_its_own_is_refused_at_once(
    http: httpx2.Client, match: str, upload: Upload
) -> None:
    off = upload(blob_file(2, seed=92))["id"]
    for job, what, reason in (
        (match, "colors", "the shape has no colours"),
        (matched(http, (off, off), points=8, dense=True)["id"], "scalars", "off files have none"),
    ):
        asked = {"match": job, "what": what, "direction": "target_to_source"}
        refused = problem(http.post("/v1/transfers", json=asked), 422, "invalid-request")
        (error,) = refused["errors"]
        assert error["field"] == "body.attributes"
        assert error["message"] == f"{reason}; upload a file of attributes"


def at_match(message: str) -> Json:
    return {"field": "body.match", "message": message, "pointer": "/match"}


def test_matches_that_cannot_be_carried_along(
    http: httpx2.Client, api: Api, pair: tuple[str, str]
) -> None:
    answer = http.post("/v1/transfers", json={"match": "no-such", "what": "colors"})
    refused = problem(answer, 422, "invalid-request")
    assert refused["errors"] == [at_match("There is no job no-such.")]
    sparse = matched(http, pair, points=12)["id"]
    answer = http.post("/v1/transfers", json={"match": sparse, "what": "colors"})
    refused = problem(answer, 422, "invalid-request")
    assert refused["errors"][0] == at_match(
        "it has no map of all vertices; match again with `dense`"
    )
    job = http.get(f"/v1/jobs/{sparse}").json()
    assert export(http, job, "csv").is_success
    refused = problem(export(http, job, "glb"), 409, "job-without-result")
    assert "match again with `dense`" in refused["detail"]
    dense = matched(http, pair, points=11, dense=True)["id"]
    other = carried(http, dense, what="colors")["id"]
    refused = problem(
        http.post("/v1/transfers", json={"match": other, "what": "colors"}), 422, "invalid-request"
    )
    assert "job of no match" in refused["errors"][0]["message"]
    api.store.client.delete(DEFAULT_KEYS.job_result(dense))
    answer = http.post("/v1/transfers", json={"match": dense, "what": "colors"})
    assert problem(answer, 410, "result-expired")["errors"][0]["field"] == "body.match"


def test_a_match_of_a_deleted_shape_is_named(http: httpx2.Client, upload: Upload) -> None:
    shape = upload(blob_file(2, seed=91))["id"]
    match = matched(http, (shape, shape), points=8, dense=True)["id"]
    http.delete(f"/v1/shapes/{shape}")
    answer = http.post("/v1/transfers", json={"match": match, "what": "colors"})
    refused = problem(answer, 422, "unknown-shape")
    assert refused["errors"] == [at_match(f"there is no shape {shape}")]


def test_files_are_the_same_by_their_bytes_and_can_be_deleted(
    http: httpx2.Client, match: str
) -> None:
    data = table(a=range(COUNT), b=range(COUNT))
    first, again = send(http, data, "one.csv"), send(http, data, "two.csv")
    assert (first.status_code, again.status_code) == (201, 200)
    assert first.json()["id"] == again.json()["id"]
    assert again.json()["name"] == "two.csv"
    path = f"/v1/attributes/{first.json()['id']}"
    assert http.delete(path).status_code == 204
    problem(http.get(path), 404, "attributes-not-found")
    problem(http.delete(path), 404, "attributes-not-found")
    asked = {"match": match, "attributes": first.json()["id"], "what": "labels"}
    refused = problem(http.post("/v1/transfers", json=asked), 422, "unknown-attributes")
    assert refused["errors"][0]["field"] == "body.attributes"


@pytest.mark.parametrize(
    ("name", "data", "message"),
    [
        ("a.npz", b"cos\nsystem\n(S'touch /tmp/owned'\ntR.", "not an archive"),
        ("a.csv", b"a\n1\nx\n", "both numbers and text"),
        ("a.ply", b"ply\nformat ascii 1.0\nelement vertex 9999999999\n", "header does not end"),
        ("a.glb", b"glTF", "not a GLB file"),
        ("a.seg", b"1\ninf\n", "row 1 is 'inf'"),
        ("a.txt", b"\xff\xfe\x00", "UTF-8"),
        ("a.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "no attributes"),
    ],
)
def test_hostile_files_are_refused_and_leave_nothing(
    http: httpx2.Client, api: Api, name: str, data: bytes, message: str
) -> None:
    assert message in problem(send(http, data, name), 422, "unusable-attributes")["detail"]
    nothing_is_left(api.store, "candidate", ":a-")


def test_unknown_formats_are_refused(http: httpx2.Client) -> None:
    refused = problem(send(http, b"1 2 3", "values.xyz"), 415, "unsupported-format")
    assert ".npz" in refused["detail"]


def test_repeated_requests_are_one_job(http: httpx2.Client, match: str) -> None:
    asked = {"match": match, "what": "colors"}
    headers = {"Idempotency-Key": "transfer-once"}
    first, second = (
        http.post("/v1/transfers", json=asked, headers=headers).json()["id"] for _ in range(2)
    )
    assert first == second
    listed = http.get("/v1/jobs", params={"kind": "transfer"}).json()["items"]
    assert [one["id"] for one in listed].count(first) == 1


def test_contract_and_solver_agree_on_kinds_and_formats() -> None:
    assert CONTRACT_FORMATS == ATTRIBUTE_FORMATS
    schema = MatchResult.model_json_schema()
    assert "inverse" in schema["$defs"]["DenseCorrespondence"]["properties"]
    assert {*KINDS, "landmarks", "texture", "uv"} == set(get_args(TransferKind))


def source_arrays(http: httpx2.Client, job: Json) -> httpx2.Response:
    return http.get(f"/v1/transfers/{job['id']}/source.npz")


def test_what_was_carried_is_known_on_the_source(http: httpx2.Client, match: str) -> None:
    file = send(http, table(part=LABELS, height=MESH.vertices[:, 2], other=np.arange(COUNT)))
    attributes = file.json()["id"]
    job = carried(http, match, attributes=attributes, what="scalars", names=["height"])
    answer = source_arrays(http, job)
    assert answer.status_code == 200, answer.text
    (height,) = read_attributes(answer.content, "npz")
    assert height.name == "height"
    np.testing.assert_allclose(height.values, MESH.vertices[:, 2], atol=1e-6)
    # From the other shape's side, and of the shape's own file.
    backwards = carried(http, match, what="colors", direction="source_to_target")
    (colors,) = read_attributes(source_arrays(http, backwards).content, "npz")
    np.testing.assert_allclose(colors.values, COLORS, atol=1e-6)
    points = [17, {"vertices": MESH.faces[5].tolist(), "weights": [0.25, 0.5, 0.25]}]
    marked = carried(http, match, what="landmarks", points=points)
    with np.load(io.BytesIO(source_arrays(http, marked).content)) as arrays:
        assert arrays["vertices"].tolist() == [[17, 17, 17], MESH.faces[5].tolist()]
        assert arrays["weights"].tolist() == [[1, 0, 0], [0.25, 0.5, 0.25]]
    assert http.delete(f"/v1/attributes/{attributes}").status_code == 204
    assert source_arrays(http, job).content == answer.content
    again = carried(
        http, match, attributes=send(http, table(part=LABELS)).json()["id"], what="labels"
    )
    http.delete(f"/v1/attributes/{send(http, table(part=LABELS)).json()['id']}")
    problem(source_arrays(http, again), 410, "attributes-deleted")


def test_other_jobs_have_no_values_of_a_source(http: httpx2.Client, match: str) -> None:
    refused = problem(source_arrays(http, {"id": match}), 409, "job-without-result")
    assert refused["detail"] == "A job of kind 'match' carries no values."
    problem(source_arrays(http, {"id": "none"}), 404, "job-not-found")
