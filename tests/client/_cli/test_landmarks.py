"""``isomatch landmarks`` against the running service."""

import csv
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import httpx2
import isomatch
import numpy as np
import pytest
import trimesh

from tests.client._cli.test_cli import ENDLESS, QUICK
from tests.client.command_line import COMMAND, run
from tests.client.shapes import blob, moved

PLACES = blob(trimesh.creation.icosphere(subdivisions=1).vertices[::5])
GIVEN = isomatch.LandmarkSet.of(
    [(f"p{row}", None if row == 1 else place) for row, place in enumerate(PLACES.tolist())]
)
THERE = GIVEN.present
CLOSE = 0.2
"""Greatest distance from the truth; the blob has a diameter of about 4."""


@pytest.fixture
def template(tmp_path: Path) -> Path:
    """Landmarks of ``a.off``, as Slicer writes them."""
    path = tmp_path / "template.mrk.json"
    isomatch.write_landmarks(path, [GIVEN])
    return path


def geometries_sent(url: str) -> int:
    """How often the service has sent the geometry of a shape."""
    metrics = httpx2.get(f"{url}/metrics").text
    head, route = "isomatch_http_request_seconds_count{", 'route="/v1/shapes/{shape}/geometry"'
    found = [one for one in metrics.splitlines() if one.startswith(head) and route in one]
    return int(sum(float(one.rpartition(" ")[2]) for one in found))


def test_a_file_for_each_specimen_and_one_that_fails(
    url: str, blobs: tuple[Path, Path], template: Path, tmp_path: Path
) -> None:
    broken, out = tmp_path / "broken.ply", tmp_path / "out"
    broken.write_text("Dear reader,\n")
    before = geometries_sent(url)
    done = run("landmarks", blobs[0], template, broken, blobs[1], "-o", out, *QUICK, url=url)
    assert done.returncode == 1, done.stderr
    assert geometries_sent(url) == before + 1, "of the template, to check its landmarks"
    assert f"{broken}: not a" in done.stderr
    assert f"no landmarks for {broken}" in done.stderr.splitlines()[-1]
    assert f"2 of 2: {blobs[1]}" in done.stderr
    assert "specimen" in done.stdout
    none = run("landmarks", blobs[0], template, broken, "-o", out, *QUICK, url=url)
    assert (none.returncode, none.stdout) == (1, "")
    assert none.stderr.splitlines()[-1].endswith(f"; of an earlier run: {out / 'landmarks.csv'}")
    (link,) = [one for one in done.stderr.splitlines() if one.startswith("in a browser: ")]
    with isomatch.Client(url) as client:
        assert client.job(link.removeprefix(f"in a browser: {url}/#job=")).state == "succeeded"
    assert sorted(path.name for path in out.iterdir()) == ["b.mrk.json", "landmarks.csv"]
    (found,) = isomatch.read_landmarks(out / "b.mrk.json")
    assert (found.name, found.labels) == ("b", GIVEN.labels)
    assert found.present.tolist() == THERE.tolist()
    assert np.linalg.norm(found.positions - moved(PLACES), axis=1)[THERE].max() < CLOSE
    rows = list(csv.DictReader((out / "landmarks.csv").read_text().splitlines()))
    assert [row["label"] for row in rows] == list(GIVEN.labels)
    sure = [row["confidence"] for row in rows]
    assert sure[1] == ""
    assert found.descriptions[0] == f"confidence {float(sure[0]):.2f}"
    value, label = min(
        (float(row["confidence"]), row["label"]) for row in rows if row["confidence"]
    )
    heads, *_, line = [one for one in done.stdout.splitlines() if one.strip()]
    assert heads.split()[-4:] == ["mean", "confidence", "least", "confidence"]
    assert line.split()[:3] == ["b", str(sum(THERE)), str(len(THERE) - sum(THERE))]
    assert line.rstrip().endswith(f"{value:.2f} at {label}")


def test_several_templates_one_file_and_json(
    url: str, blobs: tuple[Path, Path], template: Path, tmp_path: Path
) -> None:
    other, out = tmp_path / "other.fcsv", tmp_path / "out"
    isomatch.write_landmarks(other, [isomatch.LandmarkSet(GIVEN.labels, moved(GIVEN.positions))])
    more = ["--template", f"{blobs[1]}={other}", "--format", "tps", "--json"]
    done = run("landmarks", blobs[0], template, *blobs, "-o", out, *more, *QUICK, url=url)
    assert (done.returncode, done.stderr) == (0, "")
    documents = json.loads(done.stdout)
    assert [one["specimen"] for one in documents] == ["a", "b"]
    assert documents[0]["landmarks"][1]["x"] is None
    assert documents[0]["landmarks"][0]["spread"] < CLOSE
    specimens = isomatch.read_landmarks(out / "landmarks.tps")
    assert [one.name for one in specimens] == ["a", "b"]
    for one, truth in zip(specimens, (PLACES, moved(PLACES)), strict=True):
        assert np.linalg.norm(one.positions - truth, axis=1)[THERE].max() < CLOSE


def test_meshes_in_other_coordinates(
    url: str, blobs: tuple[Path, Path], template: Path, tmp_path: Path
) -> None:
    ras, out = tmp_path / "ras.fcsv", tmp_path / "out"
    isomatch.write_landmarks(ras, [GIVEN], "RAS")
    options: list[str | Path] = ["-o", out, "--coordinates", "RAS", "--format", "fcsv"]
    done = run("landmarks", blobs[0], ras, blobs[1], *options, *QUICK, url=url)
    assert done.returncode == 0, done.stderr
    assert "far from the surface" not in done.stderr
    (found,) = isomatch.read_landmarks(out / "b.fcsv", "RAS")
    assert np.linalg.norm(found.positions - moved(PLACES), axis=1)[THERE].max() < CLOSE
    before = (out / "landmarks.csv").read_bytes()
    table = tmp_path / "negated.csv"
    isomatch.write_landmarks(table, [GIVEN.flipped()])
    wrong = {
        ("LPS", ras): "give --coordinates RAS",
        ("RAS", template): "give --coordinates LPS",
        ("RAS", table): f"negate x and y in {table}",
    }
    for (system, file), advice in wrong.items():
        asked: list[str | Path] = ["-o", out, "--coordinates", system]
        flipped = run("landmarks", blobs[0], file, blobs[1], *asked, *QUICK, url=url)
        assert (flipped.returncode, flipped.stdout) == (1, "")
        assert "far from the surface" in flipped.stderr
        assert advice in flipped.stderr
    assert (out / "landmarks.csv").read_bytes() == before


def test_landmarks_that_are_all_far_are_refused_before_anything_is_matched(
    url: str, blobs: tuple[Path, Path], tmp_path: Path
) -> None:
    millimetres, out = tmp_path / "millimetres.fcsv", tmp_path / "out"
    thousand = isomatch.LandmarkSet(GIVEN.labels, GIVEN.positions * 1000.0)
    isomatch.write_landmarks(millimetres, [thousand])
    done = run("landmarks", blobs[0], millimetres, blobs[1], "-o", out, *QUICK, url=url)
    assert (done.returncode, done.stdout) == (1, "")
    count = int(THERE.sum())
    assert f"isomatch: {blobs[0]}: {count} of {count} landmarks are far" in done.stderr
    assert "check the unit of length and the coordinate system (LPS or RAS)" in done.stderr
    assert not out.exists()


def test_wrong_usage(url: str, blobs: tuple[Path, Path], template: Path, tmp_path: Path) -> None:
    a, b = blobs
    out = tmp_path / "out"
    partial = run("landmarks", a, template, b, "-o", out, "--partial", "yes", url=url)
    assert (partial.returncode, "--partial: " in partial.stderr) == (2, True)
    out.rmdir()
    for arguments in (
        [a, template, "-o", out],
        [a, template, b],
        [a, tmp_path / "none.fcsv", b, "-o", out],
        [a, template, b, "-o", template],
        [a, template, b, "-o", tmp_path / "no" / "folder"],
        [a, template, b, b, "-o", out],
        [a, template, b, "-o", out, "--template", b],
        [a, template, b, "-o", out, "--format", "xyz"],
        [a, template, b, "-o", out, "--simplify", "500"],
    ):
        assert run("landmarks", *arguments, url=url).returncode == 2, arguments
    assert not out.exists()
    unreadable = tmp_path / "two.tps"
    unreadable.write_text("LM3=1\n1 2\n")
    done = run("landmarks", a, unreadable, b, "-o", out, url=url)
    assert (done.returncode, done.stdout) == (1, "")
    assert done.stderr.startswith(f"isomatch: {unreadable}: line 2: two coordinates")
    for names, message in (
        (("x", "y"), f"there is no specimen called '{a.stem}', only 'x', 'y'"),
        ((a.stem, a.stem), f"2 specimens are called '{a.stem}'"),
    ):
        unreadable.write_text("".join(f"LM3=1\n1 2 3\nID={name}\n" for name in names))
        done = run("landmarks", a, unreadable, b, "-o", out, url=url)
        assert done.returncode == 1
        assert done.stderr.startswith(f"isomatch: {unreadable}: {message}")
    unreadable.write_text("LM3=1\n1 2 3\n")
    done = run("landmarks", a, template, b, "-o", out, "--template", f"{b}={unreadable}", url=url)
    assert f"{template} and {unreadable} do not have the same landmarks" in done.stderr


@pytest.mark.skipif(sys.platform == "win32", reason="no SIGINT to send")
def test_interrupting_cancels_all_matches(
    url: str, blobs: tuple[Path, Path], template: Path, tmp_path: Path
) -> None:
    out = tmp_path / "out"
    with isomatch.Client(url) as client:
        before = {job.id for job in client.jobs()}
        arguments = ["landmarks", blobs[0], template, *blobs, "-o", out, *ENDLESS]
        process = subprocess.Popen(
            [*COMMAND, *map(str, arguments), "--url", url],
            stderr=subprocess.PIPE,
            text=True,
            env={**os.environ, "COLUMNS": "100"},
        )
        with process:
            new: set[str] = set()
            while len(new) < 2 and process.poll() is None:
                time.sleep(0.1)
                new = {job.id for job in client.jobs()} - before
            process.send_signal(signal.SIGINT)
            _, said = process.communicate(timeout=240)
        assert process.returncode == 130, said
        assert len(new) == 2
        assert {client.job(one).wait(timeout=240).state for one in new} == {"cancelled"}
