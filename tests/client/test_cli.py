"""The command line, as a shell runs it, against the running service."""

import json
import os
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path

import isomatch
import pytest

COMMAND = [sys.executable, "-m", "isomatch.cli"]
QUICK = ["--points", "6", "--coarse-points", "6"]


def run(*arguments: str | Path, url: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [*COMMAND, *map(str, arguments)],
        env={**os.environ, "ISOMATCH_URL": url, "NO_COLOR": "1", "COLUMNS": "100"},
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )


def test_match_prints_a_table_and_writes_files(
    url: str, blobs: tuple[Path, Path], tmp_path: Path
) -> None:
    files: list[str | Path] = ["-o", tmp_path / "out.json", "--picture", tmp_path / "out.png"]
    done = run("match", *blobs, *QUICK, *files, url=url)
    assert done.returncode == 0, done.stderr
    for word in ("source", "target", "cost", "second order", "lower bound", "gap", "certified"):
        assert word in done.stdout
    assert "succeeded" in done.stderr
    match = isomatch.Match.from_json((tmp_path / "out.json").read_bytes())
    for source, target in match.pairs:
        assert any(
            {str(source), str(target)} <= set(line.split()) for line in done.stdout.splitlines()
        )
    assert (tmp_path / "out.png").read_bytes().startswith(b"\x89PNG")


def test_points_between_vertices_are_printed(
    url: str, blobs: tuple[Path, Path], tmp_path: Path
) -> None:
    out = tmp_path / "out.json"
    done = run("match", *blobs, *QUICK, "--refine", "gmds", "-o", out, url=url)
    assert done.returncode == 0, done.stderr
    refined = isomatch.Match.from_json(out.read_bytes()).refinement
    assert refined is not None
    assert f"stress {refined.stress:.3g}" in done.stdout
    for vertices, weights in zip(refined.refined_vertices, refined.refined_weights, strict=True):
        told = [f"{vertex}: {weight:.3f}" for vertex, weight in zip(vertices, weights, strict=True)]
        assert ", ".join(told) in done.stdout


def test_json_is_all_there_is_on_the_standard_output(url: str, blobs: tuple[Path, Path]) -> None:
    options = ["--metric", "commute_time", "--descriptor", "none", "--largest-component"]
    done = run("match", *blobs, *QUICK, *options, "--json", url=url)
    assert done.returncode == 0, done.stderr
    parameters = json.loads(done.stdout)["parameters"]
    assert parameters["points"] == 6
    assert parameters["largest_component"] is True
    assert parameters["metric"] in ("commute_time", ["commute_time"])
    assert parameters["descriptor"] in ("none", ["none"])


def test_the_small_commands(url: str, blobs: tuple[Path, Path]) -> None:
    uploaded = json.loads(run("upload", *blobs, "--json", url=url).stdout)
    assert [shape["name"] for shape in uploaded] == ["a.off", "b.obj"]
    table = run("shapes", url=url)
    assert all(shape["id"] in table.stdout for shape in uploaded)
    listed = json.loads(run("shapes", "--json", url=url).stdout)
    assert {shape["id"] for shape in uploaded} <= {shape["id"] for shape in listed}

    with isomatch.Client(url) as client:
        job = client.match(uploaded[0]["id"], uploaded[1]["id"], points=6, coarse_points=6)
    done = run("result", job.id, "--json", url=url)
    assert json.loads(done.stdout)["source"] == uploaded[0]["id"]
    assert job.id in run("jobs", "--state", "succeeded", url=url).stdout
    assert job.id in {found["id"] for found in json.loads(run("jobs", "--json", url=url).stdout)}
    assert f"job {job.id} is succeeded" in run("cancel", job.id, url=url).stderr


def test_structures_are_listed_and_chosen(url: str, blobs: tuple[Path, Path]) -> None:
    table = run("structures", url=url)
    assert table.returncode == 0, table.stderr
    assert "commute_time" in table.stdout
    assert "time=0.01 (area)" in table.stdout
    listed = json.loads(run("structures", "--json", url=url).stdout)
    assert "diffusion" in {metric["name"] for metric in listed["metrics"]}
    options = ["--metric", "diffusion:time=0.02", "--descriptor", "hks:times=0.1,1", "--json"]
    done = run("match", *blobs, *QUICK, *options, "--no-normalise", url=url)
    parameters = json.loads(done.stdout)["parameters"]
    assert parameters["metric"] == [{"name": "diffusion", "time": 0.02}]
    assert parameters["descriptor"] == [{"name": "hks", "times": [0.1, 1.0]}]
    assert parameters["normalise"] is False


def test_refusals_are_one_line(url: str, blobs: tuple[Path, Path], tmp_path: Path) -> None:
    text = tmp_path / "letter.off"
    text.write_text("Dear reader,\n")
    commands: list[list[str | Path]] = [
        ["match", blobs[0], text],
        ["match", *blobs, "--points", "2"],
        ["match", *blobs, "--metric", "euclidean"],
        ["match", *blobs, "--metric", "diffusion:time=soon"],
        ["result", "nothing"],
        ["match", *blobs, *QUICK, "-o", tmp_path / "no" / "such" / "folder.json"],
    ]
    for command in commands:
        done = run(*command, url=url)
        assert (done.returncode, done.stdout) == (1, "")
        last = done.stderr.splitlines()[-1]
        assert last.startswith("isomatch: "), done.stderr
        assert "Traceback" not in done.stderr


def test_wrong_usage(url: str, tmp_path: Path) -> None:
    odd = ["match", __file__, __file__, "--metric", "diffusion:time"]
    for command in (
        ["match"],
        odd,
        ["match", tmp_path / "a.off", tmp_path / "b.off"],
        ["frobnicate"],
    ):
        done = run(*command, url=url)
        assert (done.returncode, done.stdout) == (2, "")
    assert run("--help", url=url).returncode == 0


def test_no_service() -> None:
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        port = listener.getsockname()[1]
    done = run("shapes", url=f"http://127.0.0.1:{port}")
    assert (done.returncode, done.stdout) == (1, "")
    assert done.stderr.count("\n") == 1
    assert "make serve" in done.stderr
    assert run("shapes", url="localhost").returncode == 1


@pytest.mark.skipif(sys.platform == "win32", reason="no SIGINT to send")
def test_interrupting_cancels_the_job(url: str, blobs: tuple[Path, Path]) -> None:
    with isomatch.Client(url) as client:
        before = {job.id for job in client.jobs()}
        process = subprocess.Popen(
            [*COMMAND, "match", *map(str, blobs), "--points", "256", "--url", url],
            stderr=subprocess.PIPE,
            text=True,
        )
        with process:
            new: set[str] = set()
            while not new and process.poll() is None:
                time.sleep(0.1)
                new = {job.id for job in client.jobs()} - before
            process.send_signal(signal.SIGINT)
            _, said = process.communicate(timeout=30)
        assert process.returncode == 130, said
        (job_id,) = new
        assert f"job {job_id} cancelled" in said
        assert client.job(job_id).wait(timeout=30).state == "cancelled"
