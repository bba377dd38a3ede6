"""Registrations by the SDK and the command line, against the running service."""

import csv
import json
import re
from pathlib import Path
from typing import Any

import isomatch
import numpy as np
import pytest
import trimesh

from tests.client.command_line import run
from tests.client.shapes import blob_meshes

FIRST, SECOND = blob_meshes()


@pytest.fixture(scope="module")
def coarse(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A file of too few vertices, which cannot be registered."""
    file = tmp_path_factory.mktemp("coarse") / "coarse.off"
    triangle = trimesh.Trimesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    triangle.export(file)
    return file


def test_registered_templates_are_arrays_and_files(
    client: isomatch.Client, blobs: tuple[Path, Path], tmp_path: Path
) -> None:
    template, other = map(client.upload, blobs)
    job = client.register(template, [other, template])
    found = job.result()
    assert [one.registered for one in found.specimens] == [True, True]
    assert found.positions.shape == (2, len(FIRST.vertices), 3)
    np.testing.assert_array_equal(found.faces, FIRST.faces)
    np.testing.assert_allclose(found.positions[1], FIRST.vertices, atol=1e-6)
    assert found.mean.shape == FIRST.vertices.shape
    assert found.directions.shape == (1, *FIRST.vertices.shape)
    assert found.scores.shape == (2, 1)
    np.testing.assert_allclose(found.scores[:, 0], [one.scores[0] for one in found.specimens])
    job.save(tmp_path / "requested.npz")
    found.save(tmp_path / "held.NPZ")
    held, requested = (tmp_path / name for name in ("held.NPZ", "requested.npz"))
    assert held.read_bytes() == requested.read_bytes()
    with pytest.raises(ValueError, match=r"not held as \.ply: give \.json, or use job\.save"):
        found.save(tmp_path / "mean.ply")
    files = found.save_meshes(tmp_path / "out")
    assert [path.name for path in files] == [
        "b.ply",
        "a.ply",
        "mean.ply",
        "components.npz",
        "scores.csv",
    ]
    rows = list(csv.reader(files[-1].read_text().splitlines()))
    assert [row[0] for row in rows] == ["specimen", "b", "a"]
    assert rows[0][1:] == ["pc1", "confidence", "in_doubt", "reasons"]
    np.testing.assert_array_equal(
        [float(row[1]) for row in rows[1:]], [one.scores[0] for one in found.specimens]
    )
    opened: Any = trimesh.load(files[0], process=False)
    np.testing.assert_allclose(opened.vertices, found.positions[0])
    job.save_registered(tmp_path / "b.glb", 0)
    glb: Any = trimesh.load(tmp_path / "b.glb", force="mesh", process=False)
    np.testing.assert_allclose(glb.vertices, found.positions[0], atol=1e-5)
    said = str(found).splitlines()
    assert said[0].startswith("a.off registered to 2 of 2 specimens")
    assert said[1].startswith("  b.obj: distance at most ")
    with pytest.raises(ValueError, match="none of ply, obj, glb"):
        job.save_registered(tmp_path / "b.stl")
    with pytest.raises(ValueError, match="would be called 'same'"):
        found.save_meshes(tmp_path / "twice", ["same", "same"])
    with pytest.raises(ValueError, match="no arrays"):
        _ = isomatch.Registration.from_json(found.to_json()).positions


def test_the_command_writes_a_file_for_each_specimen(
    url: str, blobs: tuple[Path, Path], coarse: Path, tmp_path: Path
) -> None:
    out = tmp_path / "out"
    text = tmp_path / "letter.off"
    text.write_text("Dear reader,\n")
    done = run("register", blobs[0], blobs[1], text, coarse, "-o", out, url=url)
    assert done.returncode == 1, done.stderr
    assert f"isomatch: {text}: not an OFF file" in done.stderr
    assert "could not be registered" in " ".join(done.stdout.split())
    page, job_id = done.stderr.splitlines()[-1].split("#job=")
    assert page == f"in a browser: {url}/"
    with isomatch.Client(url) as client:
        assert client.job(job_id).kind == "registration"
    names = {path.name for path in out.iterdir()}
    assert names == {"b.ply", "mean.ply", "components.npz", "components.png", "scores.csv"}
    rows = (out / "scores.csv").read_text().splitlines()
    assert [row.split(",")[0] for row in rows] == ["specimen", "b", "coarse"]
    assert rows[0].endswith(",confidence,in_doubt,reasons")
    assert rows[1].split(",")[-2] in ("true", "false")
    assert re.fullmatch("coarse,+not registered: .+", rows[2].replace('"', ""))
    assert "letter.off" in done.stdout
    assert "not uploaded: not an OFF file" in " ".join(done.stdout.split())
    assert "distance" not in done.stdout
    opened: Any = trimesh.load(out / "b.ply", process=False)
    np.testing.assert_array_equal(opened.faces, FIRST.faces)
    done = run("register", blobs[0], blobs[1], text, "-o", out, "--json", url=url)
    assert (done.returncode, json.loads(done.stderr)["file"]) == (1, str(text))
    document = json.loads(done.stdout)
    assert document["specimens"][0]["flipped"] == 0
    assert [one["file"] for one in document["failures"]] == [str(text)]
    assert document["failures"][0]["detail"].startswith("not an OFF file")


def test_the_command_leaves_the_job_to_run(
    client: isomatch.Client, url: str, blobs: tuple[Path, Path], tmp_path: Path
) -> None:
    left = run("register", *blobs, "--no-wait", url=url)
    assert left.returncode == 0, left.stderr
    assert client.job(left.stdout.strip()).kind == "registration"
    client.job(left.stdout.strip()).cancel()
    unusable: list[list[str | Path]] = [["--no-wait", "-o", tmp_path], []]
    for wrong in unusable:
        refused = run("register", *blobs, *wrong, url=url)
        assert (refused.returncode, refused.stdout) == (2, "")
        assert "--output" in refused.stderr


def test_the_result_is_printed_and_written_again(
    client: isomatch.Client, url: str, blobs: tuple[Path, Path], tmp_path: Path
) -> None:
    template, other = map(client.upload, blobs)
    job = client.register(template, [other])
    done = run("jobs", "result", job.id, "--registered", file := tmp_path / "b.obj", url=url)
    assert done.returncode == 0, done.stderr
    opened: Any = trimesh.load(file, process=False)
    np.testing.assert_array_equal(opened.faces, FIRST.faces)
    for wrong, said in (
        (["--registered", tmp_path / "b.stl"], "PLY, OBJ or GLB"),
        (["--specimen", "1"], "it needs --registered FILE"),
    ):
        refused = run("jobs", "result", job.id, *wrong, url=url)
        assert refused.returncode == 2
        assert said in " ".join(refused.stderr.replace("│", " ").split())
    table = run("jobs", "result", job.id, "-o", tmp_path / "b.csv", url=url)
    there = "has no CSV file; it has `result`, which is JSON, result.ply, result.obj, result.glb,"
    assert (table.returncode, there in table.stderr) == (1, True)
    beyond = ("--registered", tmp_path / "c.ply", "--specimen", "1")
    assert run("jobs", "result", job.id, *beyond, url=url).returncode == 2
    (line,) = [line for line in done.stdout.splitlines() if "b.obj" in line]
    assert line.split()[:2] == ["b.obj", other.id]
    listed = run("jobs", "list", "--kind", "registration", url=url).stdout
    assert job.id in listed
    shown = " ".join(run("jobs", "show", job.id, url=url).stdout.split())
    assert f"of {template.id} -> 1 shape state" in shown
