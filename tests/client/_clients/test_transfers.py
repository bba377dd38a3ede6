"""Transfers and files of results by the SDK and the command line, against the running service."""

import csv
import json
import re
from pathlib import Path
from typing import Any

import isomatch
import numpy as np
import pytest
import trimesh

from demo.stack import ROOT
from tests.client.command_line import run
from tests.client.shapes import blob_meshes

FIRST, SECOND = blob_meshes()
PARTS = np.where(FIRST.vertices[:, 2] > 0.3, "top", "bottom")


@pytest.fixture(scope="module")
def job_id(stack: Any, blobs: tuple[Path, Path]) -> str:
    """A match of the two blobs with a map of all vertices."""
    with isomatch.Client(stack.url) as client:
        job = client.match(*map(client.upload, blobs), points=16, dense=True)
        return job.wait().id


@pytest.fixture
def parts(tmp_path: Path) -> Path:
    file = tmp_path / "parts.csv"
    file.write_text("part\n" + "\n".join(PARTS) + "\n")
    return file


def table(file: Path) -> list[list[str]]:
    return list(csv.reader(file.read_text().splitlines()))


def test_files_and_arrays_give_the_same(
    client: isomatch.Client, job_id: str, parts: Path, tmp_path: Path
) -> None:
    job = client.transfer(job_id, parts, what="labels")
    result = job.result()
    assert (result.rows, result.source_name) == (len(SECOND.vertices), "a.off")
    assert [one.name for one in result.attributes] == ["part"]
    job.save(tmp_path / "parts.npz")
    with np.load(tmp_path / "parts.npz") as arrays:
        labels = arrays["part"]
    found: isomatch.Match = client.job(job_id).result()
    np.testing.assert_array_equal(found.transfer(PARTS, "labels"), labels)
    # Away from the border, the label is that of the point that corresponds.
    height = found.transfer(FIRST.vertices, "vectors")[:, 2]
    sure = np.abs(height - 0.3) > 0.3
    np.testing.assert_array_equal(labels[sure], np.where(height > 0.3, "top", "bottom")[sure])
    with pytest.raises(ValueError, match="save it as PLY"):
        result.plot()


def test_uploaded_attributes_can_be_carried_again(
    client: isomatch.Client, job_id: str, parts: Path
) -> None:
    uploaded = client.upload_attributes(parts, "segments")
    assert (uploaded.name, uploaded.rows) == ("segments", len(PARTS))
    one = client.transfer(job_id, uploaded, what="labels").result()
    two = client.transfer(client.job(job_id), uploaded.id, what="labels", names=["part"]).result()
    assert one.attributes == two.attributes
    client.delete_attributes(uploaded)
    with pytest.raises(isomatch.UnknownAttributes):
        client.transfer(job_id, uploaded, what="labels")


def test_a_result_stands_for_its_job(client: isomatch.Client, job_id: str) -> None:
    match: isomatch.Match = client.job(job_id).result()
    assert client.job(match) == client.job(job_id)
    assert client.transfer(match, {"part": PARTS}, what="labels").result().match == job_id
    with pytest.raises(ValueError, match="does not name its job: give its id"):
        client.job(match.model_copy(update={"job": None}))
    with pytest.raises(TypeError, match=r"a Match is a result: give what client\.upload"):
        client.geometry(match)  # type: ignore[arg-type]


def test_labels_of_faces(client: isomatch.Client, job_id: str, tmp_path: Path) -> None:
    """An array by name, onto faces and onto vertices; and a file from the command line."""
    parts = np.where(FIRST.vertices[FIRST.faces].mean(axis=1)[:, 2] > 0.3, 1, 2)
    job = client.transfer(job_id, {"part": parts}, what="labels")
    result = job.result()
    assert (result.on, result.rows) == ("faces", len(SECOND.faces))
    assert str(result) == f"<Transfer of labels (part) to {len(SECOND.faces)} faces>"
    job.save(tmp_path / "parts.npz")
    with np.load(tmp_path / "parts.npz") as arrays:
        labels = arrays["part"]
    found: isomatch.Match = client.job(job_id).result()
    height = found.transfer(FIRST.vertices, "vectors")[:, 2][SECOND.faces].mean(axis=1)
    sure = np.abs(height - 0.3) > 0.3
    np.testing.assert_array_equal(labels[sure], np.where(height > 0.3, 1, 2)[sure])
    onto = client.transfer(job_id, {"part": parts}, what="labels", on="vertices").result()
    assert (onto.on, onto.rows) == ("vertices", len(SECOND.vertices))
    with pytest.raises(ValueError, match=r"Client\.transfer carries values of faces"):
        found.transfer(parts, "labels")
    with pytest.raises(ValueError, match="'part' is an array of objects"):
        client.transfer(job_id, {"part": np.array([{}, []], dtype=object)}, what="labels")


def test_landmarks(client: isomatch.Client, job_id: str, tmp_path: Path) -> None:
    found: isomatch.Match = client.job(job_id).result()
    job = client.transfer(job_id, what="landmarks", points=[17, 203])
    result = job.result()
    assert result.points is not None
    assert found.dense is not None
    there = [one for one in result.points if one is not None]
    job.save(tmp_path / "landmarks.csv")
    header, *rows = table(tmp_path / "landmarks.csv")
    assert header[-2:] == ["weight3", "confidence"]
    assert result.landmarks is not None
    assert [float(row[-1]) for row in rows] == [one.confidence for one in result.landmarks]
    np.testing.assert_array_equal(there[0].vertices, found.dense.image_faces[17])
    back = client.transfer(
        job_id, what="landmarks", direction="target_to_source", points=there
    ).result()
    assert back.points is not None
    for vertex, point in zip((17, 203), back.points, strict=True):
        assert point is not None
        place = np.array(point.weights) @ FIRST.vertices[list(point.vertices)]
        assert np.linalg.norm(place - FIRST.vertices[vertex]) < 0.2


def test_files_that_are_refused(client: isomatch.Client, job_id: str) -> None:
    with pytest.raises(isomatch.UnprocessableAttributes, match="both numbers and text"):
        client.upload_attributes(b"a\n1\nx\n", file_type="csv")
    with pytest.raises(isomatch.UnsupportedFormat):
        client.upload_attributes(b"1 2 3", file_type="xyz")
    with pytest.raises(isomatch.InvalidRequest, match="has 2 rows"):
        client.transfer(job_id, client.upload_attributes(b"a\n1\n2\n", file_type="csv"),
                        what="scalars")  # fmt: skip
    with pytest.raises(TypeError, match="attributes are a path"):
        client.upload_attributes(7)  # type: ignore[arg-type]
    with pytest.raises(isomatch.InvalidRequest, match="match: There is no job no-such-job"):
        client.transfer("no-such-job", what="colors")
    with pytest.raises(TypeError, match=r"landmark as a vertex, or a point .* not 0\.5"):
        client.transfer(job_id, what="landmarks", points=[0.5])  # type: ignore[list-item]
    one = client.upload_attributes(b"a\n" + b"1\n" * len(PARTS), file_type="csv")
    with pytest.raises(isomatch.InvalidRequest, match="'b' is not in the file, which has a"):
        client.transfer(job_id, one, what="scalars", names=["b"])
    job = client.transfer(job_id, one, what="colors")
    with pytest.raises(isomatch.JobFailed, match="has no colors"):
        job.result()


def test_a_match_is_saved_in_every_format(
    client: isomatch.Client, job_id: str, tmp_path: Path
) -> None:
    job = client.job(job_id)
    for ending in ("json", "npz", "csv", "ply", "obj", "glb", "png"):
        job.save(tmp_path / f"match.{ending}")
    named = set(re.findall(r"`(\w+)`", (ROOT / "docs" / "api.md").read_text()))
    with np.load(tmp_path / "match.npz") as arrays:
        assert "inverse_source" in arrays.files
        assert set(arrays.files) <= named
    pairs = table(tmp_path / "match.csv")
    assert pairs[0] == ["source", "target", "cost"]
    assert [[int(a), int(b)] for a, b, _ in pairs[1:]] == job.result().pairs.tolist()
    for ending in ("ply", "obj"):
        seen: Any = trimesh.load(tmp_path / f"match.{ending}", process=False, force="mesh")
        np.testing.assert_allclose(seen.vertices, SECOND.vertices, atol=1e-5)
        assert len(np.unique(seen.visual.vertex_colors, axis=0)) > 100
    scene: Any = trimesh.load(tmp_path / "match.glb")
    assert set(scene.geometry) == {"source", "target"}
    document = json.loads((tmp_path / "match.json").read_bytes())
    assert (document["source_name"], document["target_name"]) == ("a.off", "b.obj")
    with pytest.raises(ValueError, match="'txt' is none of"):
        job.save(tmp_path / "match.txt")


def test_pictures_from_other_sides(client: isomatch.Client, job_id: str, tmp_path: Path) -> None:
    job = client.job(job_id)
    sides: tuple[Any, ...] = ("front", "back", "left", "top")
    pictures = {side: job.picture(view=side) for side in sides}
    assert pictures["front"] == job.picture()
    assert len(set(pictures.values())) == len(sides)
    job.save_picture(tmp_path / "left.png", view="left")
    assert (tmp_path / "left.png").read_bytes() == pictures["left"]
    with pytest.raises(isomatch.InvalidRequest, match="view"):
        job.picture(view="inside")  # type: ignore[arg-type]


def test_bytes_uploaded_under_a_second_name_keep_it_for_that_upload(
    client: isomatch.Client, blobs: tuple[Path, Path]
) -> None:
    first = client.upload(blobs[0])
    again = client.upload(blobs[0], "the second name")
    assert (first.id, first.name) == (again.id, "a.off")
    assert again.name == "the second name"
    match = client.match(first, again, points=8, eigenpairs=30).result()
    assert (match.source_name, match.target_name) == ("a.off", "the second name")
    job = client.match(first, again, points=8, dense=True).wait()
    back = client.transfer(job, what="landmarks", points=[3], direction="target_to_source").result()
    assert (back.source_name, back.target_name) == ("the second name", "a.off")


def test_transfer_command(url: str, blobs: tuple[Path, Path], job_id: str, parts: Path) -> None:
    out = parts.with_name("out.csv")
    done = run("transfer", *blobs, parts, "--what", "labels", "-o", out, url=url)
    assert done.returncode == 0, done.stderr
    assert "labels" in done.stdout
    rows = table(out)
    assert rows[0] == ["vertex", "part"]
    assert len(rows) == 1 + len(SECOND.vertices)
    assert {row[1] for row in rows[1:]} == {"top", "bottom"}
    surface = parts.with_name("out.ply")
    again = run("transfer", job_id, parts, "--what", "labels", "-o", surface, url=url)
    assert again.returncode == 0, again.stderr
    assert surface.read_bytes().startswith(b"ply")
    file = parts.with_name("parts.seg")
    file.write_text("3\n" * len(FIRST.faces))
    for on in ([], ["--on", "vertices"]):
        done = run("transfer", job_id, file, "--what", "labels", *on, "-o", out, url=url)
        assert done.returncode == 0, done.stderr
        rows = table(out)
        assert rows[0] == ["vertex" if on else "face", "label"]
        assert len(rows) == 1 + len(SECOND.vertices if on else SECOND.faces)
    points = ["--what", "landmarks", "--point", "17", "--point", "4:0.2,9:0.3,7:0.5", "--json"]
    told = json.loads(run("transfer", job_id, *points, url=url).stdout)
    assert len(told["points"]) == 2
    nowhere = run("transfer", job_id, "--what", "landmarks", "--point", "99999", url=url)
    assert "--point (0): 99999 is no vertex" in " ".join(nowhere.stderr.split())


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["JOB", "PARTS", "--what", "hair"], "one of scalars"),
        (["JOB", "PARTS", "--what", "labels", "--on", "edges"], "'vertices', 'faces'"),
        (["JOB", "nothing.csv", "--what", "labels"], "nothing.csv"),
        (["JOB", "--what", "landmarks", "--point", "4:0.2,9:0.3"], "a landmark is"),
        (["A", "B", "PARTS", "PARTS", "--what", "labels"], "at most one file"),
    ],
)
def test_wrong_usage(
    url: str, blobs: tuple[Path, Path], job_id: str, parts: Path,
    arguments: list[str], message: str,
) -> None:  # fmt: skip
    named = {"JOB": job_id, "PARTS": str(parts), "A": str(blobs[0]), "B": str(blobs[1])}
    done = run("transfer", *(named.get(one, one) for one in arguments), url=url)
    assert done.returncode == 2
    assert message in " ".join(done.stderr.split())


def test_surfaces_of_a_match_need_its_dense_map(url: str, blobs: tuple[Path, Path]) -> None:
    done = run("match", *blobs, "-o", blobs[0].with_name("out.glb"), url=url)
    assert done.returncode == 2
    assert "add --dense" in " ".join(done.stderr.replace("│", " ").split())


def test_a_matrix_as_csv(url: str, blobs: tuple[Path, Path], tmp_path: Path) -> None:
    done = run("compare", *blobs, "--points", "4", "-o", tmp_path / "matrix.csv", url=url)
    assert done.returncode == 0, done.stderr
    rows = table(tmp_path / "matrix.csv")
    assert rows[0] == ["", "a.off", "b.obj"]
    assert [row[0] for row in rows[1:]] == ["a.off", "b.obj"]
    assert float(rows[1][2]) == float(rows[2][1]) >= float(rows[1][1]) == 0.0
