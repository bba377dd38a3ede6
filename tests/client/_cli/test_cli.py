"""The command line against the running service."""

import contextlib
import io
import itertools
import json
import os
import pty
import re
import shlex
import signal
import socket
import subprocess
import sys
import threading
import time
from pathlib import Path

import isomatch
import pytest
from isomatch._cli.exit_codes import problem_document
from isomatch._cli.render import print_jobs
from isomatch._cli.uploads import named_upload
from rich.console import Console

from demo.stack import ROOT
from tests.client.command_line import COMMAND, run, run_process
from tests.client.shapes import LASTING

QUICK = ["--points", "6", "--coarse-points", "6"]
ENDLESS = [
    text for name, value in LASTING.items() for text in (f"--{name.replace('_', '-')}", str(value))
]


def test_match_prints_a_table_and_writes_files(
    url: str, blobs: tuple[Path, Path], tmp_path: Path
) -> None:
    files: list[str | Path] = ["-o", tmp_path / "out.json", "--picture", tmp_path / "out.png"]
    done = run_process("match", *blobs, *QUICK, *files, url=url)
    assert done.returncode == 0, done.stderr
    for word in ("source", "target", "cost", "second order", "lower bound", "gap", "certified"):
        assert word in done.stdout
    assert "succeeded" in done.stderr
    page, job_id = done.stderr.splitlines()[-1].split("#job=")
    assert page == f"in a browser: {url}/"
    with isomatch.Client(url) as client:
        assert client.job(job_id).state == "succeeded"
    match = isomatch.Match.from_json((tmp_path / "out.json").read_bytes())
    for source, target in match.pairs:
        assert any(
            {str(source), str(target)} <= set(line.split()) for line in done.stdout.splitlines()
        )
    assert (tmp_path / "out.png").read_bytes().startswith(b"\x89PNG")


def test_refined_points_are_printed(url: str, blobs: tuple[Path, Path], tmp_path: Path) -> None:
    out = tmp_path / "out.json"
    done = run("match", *blobs, *QUICK, "--refine", "gmds", "-o", out, url=url)
    assert done.returncode == 0, done.stderr
    refined = isomatch.Match.from_json(out.read_bytes()).refinement
    assert refined is not None
    assert f"stress {refined.stress:.3g}" in done.stdout
    for vertices, weights in zip(refined.refined_vertices, refined.refined_weights, strict=True):
        told = [f"{vertex}: {weight:.3f}" for vertex, weight in zip(vertices, weights, strict=True)]
        assert ", ".join(told) in done.stdout


def test_the_standard_output_is_json_alone(url: str, blobs: tuple[Path, Path]) -> None:
    options = ["--metric", "commute_time", "--descriptor", "none", "--largest-component"]
    done = run("match", *blobs, *QUICK, *options, "--json", url=url)
    assert done.returncode == 0, done.stderr
    parameters = json.loads(done.stdout)["parameters"]
    assert parameters["points"] == 6
    assert parameters["largest_component"] is True
    assert parameters["metric"] in ("commute_time", ["commute_time"])
    assert parameters["descriptor"] in ("none", ["none"])


def test_upload_and_shapes(url: str, blobs: tuple[Path, Path]) -> None:
    uploaded = json.loads(run("upload", *blobs, "--json", url=url).stdout)
    assert [shape["name"] for shape in uploaded] == ["a.off", "b.obj"]
    table = run("shapes", url=url)
    assert all(shape["id"] in table.stdout for shape in uploaded)
    listed = json.loads(run("shapes", "--json", url=url).stdout)
    assert {shape["id"] for shape in uploaded} <= {shape["id"] for shape in listed}


def test_pipelines(url: str, blobs: tuple[Path, Path], tmp_path: Path) -> None:
    """Upload from a pipe, hand ids on, leave the job, and fetch its result."""
    with blobs[0].open("rb") as file:
        piped = ("upload", "-", "--file-type", "off", "-q")
        first = run_process(*piped, url=url, stdin=file).stdout.strip()
    second = run("upload", blobs[1], "--quiet", url=url).stdout.strip()
    left = run("match", first, second, "--points", "16", "--no-wait", url=url)
    assert left.returncode == 0, left.stderr
    job_id = left.stdout.strip()

    told = run("jobs", "follow", job_id, "--json", url=url)
    assert (told.returncode, told.stderr) == (0, "")
    states = [json.loads(line)["state"] for line in told.stdout.splitlines()]
    assert states[-1] == "succeeded"
    assert run("jobs", "follow", job_id, url=url).stdout.split()[1:3] == ["succeeded", "100%"]

    done = run("jobs", "result", job_id, "--json", url=url)
    assert (done.returncode, done.stderr) == (0, "")
    assert json.loads(done.stdout)["source"] == first
    other = tmp_path / "other.png"
    drawn = ("jobs", "result", job_id, "--json", "--picture", other, "--alternative")
    assert run(*drawn, "1", url=url).returncode == 0
    with isomatch.Client(url) as client:
        assert other.read_bytes() == client.job(job_id).picture(alternative=1)
    refused = run(*drawn, "32", url=url)
    assert (refused.returncode, json.loads(refused.stderr)["status"]) == (2, 422)
    assert job_id in run("jobs", "list", "--state", "succeeded", "-q", url=url).stdout.split()
    listed = json.loads(run("jobs", "list", "--json", url=url).stdout)
    assert job_id in {found["id"] for found in listed}
    assert job_id in run("jobs", "list", url=url).stdout
    shortened = json.loads(run("jobs", "show", job_id[:8], "--json", url=url).stdout)
    assert shortened["id"] == job_id
    unknown = run("jobs", "show", "0123456789", url=url)
    assert (unknown.returncode, "There is no job 0123456789" in unknown.stderr) == (1, True)
    assert "of which commands take the first 8 or more" in " ".join(unknown.stderr.split())
    full = run("jobs", "result", job_id, "-o", "/dev/full", url=url)
    assert full.returncode == 1
    assert f"isomatch jobs result {job_id}" in full.stderr
    (one,) = [job for job in listed if job["id"] == job_id]
    of_it = ["jobs", "list", "-q", "--of", one["source"]]
    assert job_id in run(*of_it, "--kind", "match", url=url).stdout.split()
    assert run(*of_it, "--kind", "prototype", url=url).stdout == ""
    assert f"{one['source']} -> {one['target']}" in run("jobs", "show", job_id, url=url).stdout
    shown = run("jobs", "show", job_id, url=url).stdout
    assert "succeeded" in shown
    assert "100%" in shown
    assert json.loads(run("jobs", "show", job_id, "--json", url=url).stdout)["id"] == job_id
    cancelled = run("jobs", "cancel", job_id, "nothing", url=url)
    assert cancelled.returncode == 1
    assert cancelled.stderr.splitlines()[0] == f"job {job_id} has succeeded already"
    assert first in run("shapes", "-q", url=url).stdout.split()


def test_jobs_are_listed_with_the_names_of_their_shapes(url: str, blobs: tuple[Path, Path]) -> None:
    printed = io.StringIO()
    with isomatch.Client(url) as client:
        first, second = (client.upload(path, f"named {path.name}") for path in blobs)
        match = client.match(first, second, points=8)
        batch = client.match_many(first, [second], points=8)
        compared = client.dissimilarities([first, second], points=8)
        records = [job.record for job in (match, batch, compared)]
        print_jobs(records, Console(file=printed, width=300))
        for job in (match, batch, compared):
            job.cancel()
    rows = [line for line in printed.getvalue().splitlines() if "named" in line]
    assert f" {first.name} -> {second.name} " in rows[0]
    assert f" {first.name} -> 1 shape " in rows[1]
    assert f" {first.name}, {second.name} " in rows[2]


def test_a_job_without_a_result(url: str, blobs: tuple[Path, Path]) -> None:
    left = run("match", *blobs, *ENDLESS, "--no-wait", "--json", url=url)
    job_id = json.loads(left.stdout)["id"]
    cancelled = run("jobs", "cancel", "nothing", job_id, "--json", url=url)
    assert cancelled.returncode == 1
    assert [job["id"] for job in json.loads(cancelled.stdout)] == [job_id]
    assert json.loads(cancelled.stderr)["file"] == "nothing"
    with isomatch.Client(url) as client:
        client.job(job_id).wait(timeout=240)
    assert run("jobs", "follow", job_id, url=url).returncode == 4
    done = run("jobs", "result", job_id, "--json", url=url)
    assert (done.returncode, done.stdout) == (4, "")
    problem = json.loads(done.stderr)
    assert problem["type"] == "urn:isomatch:client:job-cancelled"
    assert job_id in problem["detail"]


def test_prototypes_that_cannot_be_deleted_are_each_named(url: str) -> None:
    unknown = [f"p-{number:032x}" for number in range(2)]
    done = run("prototype", "delete", *unknown, url=url)
    assert done.returncode == 1
    assert [line.split(": ")[1] for line in done.stderr.splitlines()] == unknown


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
        ["jobs", "result", "nothing"],
    ]
    for command in commands:
        done = run(*command, url=url)
        refused_option = command[0] == "match" and len(command) > 3
        assert (done.returncode, done.stdout) == (2 if refused_option else 1, "")
        last = done.stderr.splitlines()[-1]
        assert last.startswith("isomatch: "), done.stderr
        assert "Traceback" not in done.stderr


def test_the_file_that_is_refused_is_named(
    url: str, blobs: tuple[Path, Path], tmp_path: Path
) -> None:
    text = tmp_path / "letter.off"
    text.write_text("Dear reader,\n")
    commands: list[list[str | Path]] = [
        ["compare", blobs[0], text, blobs[1]],
        ["match", text, blobs[1]],
    ]
    for command in commands:
        done = run(*command, url=url)
        assert (done.returncode, done.stdout) == (1, "")
        assert done.stderr.splitlines()[-1].startswith(f"isomatch: {text}: not an OFF file")
    done = run("upload", blobs[0], text, blobs[1], "--json", url=url)
    problem = json.loads(done.stderr)
    assert (problem["file"], problem["status"]) == (str(text), 422)
    # Others have their ids.
    assert (done.returncode, len(json.loads(done.stdout))) == (1, 2)
    missing = tmp_path / "missing.off"
    done = run("upload", "--quiet", missing, url=url)
    assert (done.returncode, done.stdout) == (1, "")
    assert done.stderr == f"isomatch: {missing}: No such file or directory\n"
    # The format is that of the file, whatever name it is given; a pipe has none.
    assert run("upload", blobs[0], "--name", "anything", url=url).returncode == 0
    assert "--file-type off" in run("upload", "-", url=url).stderr
    nameless = text.with_name("nameless")
    nameless.write_bytes(blobs[0].read_bytes())
    assert "--file-type off" in run("match", nameless, blobs[1], url=url).stderr
    with text.open("rb") as file:
        piped = run("upload", "-", "--file-type", "off", url=url, stdin=file)
    assert piped.stderr.startswith("isomatch: the standard input: not an OFF file")


def test_of_several_targets_one_is_refused_and_the_others_go_on(
    url: str, blobs: tuple[Path, Path], tmp_path: Path
) -> None:
    text, out = tmp_path / "letter.off", tmp_path / "out"
    text.write_text("Dear reader,\n")
    done = run("match", blobs[0], text, blobs[1], *QUICK, "-o", out, url=url)
    assert done.returncode == 1
    assert f"isomatch: {text}: not an OFF file" in done.stderr
    assert [file.name for file in out.iterdir()] == [f"{blobs[1].stem}.json"]


def test_refusals_are_problem_documents_with_json(url: str, blobs: tuple[Path, Path]) -> None:
    done = run("match", *blobs, "--points", "2", "--json", url=url)
    assert (done.returncode, done.stdout) == (2, "")
    problem = json.loads(done.stderr)
    assert (problem["type"], problem["status"]) == ("urn:isomatch:problem:invalid-request", 422)
    assert [wrong["field"] for wrong in problem["errors"]] == ["body.points"]


@pytest.mark.parametrize(
    ("command", "message"),
    [
        (["match"], "Missing argument"),
        (["shapes", "--colour"], "No such option: --colour"),
        (["match", __file__, "nothing.off"], "'nothing.off' is neither a file nor the id"),
        (["compare", __file__, __file__, "-o", "-"], "use --json for a result as JSON there"),
    ],
)
def test_wrong_usage_is_a_problem_document_with_json(command: list[str], message: str) -> None:
    done = run(*command, "--json", url="http://127.0.0.1:9")
    assert (done.returncode, done.stdout) == (2, "")
    problem = json.loads(done.stderr)
    assert (problem["type"], problem["title"]) == ("urn:isomatch:client:wrong-usage", "Wrong usage")
    assert message in problem["detail"]


def test_shapes_and_results_are_deleted(url: str, blobs: tuple[Path, Path], tmp_path: Path) -> None:
    mine = tmp_path / "mine.off"
    mine.write_bytes(blobs[0].read_bytes() + b"# mine\n")
    shape = run("upload", mine, "-q", url=url).stdout.strip()
    done = run("match", shape, blobs[1], *QUICK, "--json", url=url)
    assert done.returncode == 0, done.stderr
    (job,) = run("jobs", "list", "--of", shape, "-q", url=url).stdout.split()
    deleted = run("jobs", "delete", job[:8], "nothing", url=url)
    assert (deleted.returncode, deleted.stdout) == (1, "")
    assert deleted.stderr.splitlines()[0] == f"the result of job {job} is deleted"
    assert run("jobs", "result", job, url=url).returncode == 1
    deleted = run("shapes", "delete", "0" * 32, shape, url=url)
    assert (deleted.returncode, deleted.stdout) == (1, "")
    assert f"shape {shape} is deleted" in deleted.stderr
    assert shape not in run("shapes", "-q", url=url).stdout.split()


def test_an_address_with_a_path_is_explained(url: str) -> None:
    done = run("shapes", "--url", f"{url}/docs", url=url)
    assert done.returncode != 0
    assert "is /docs part of the address? --url is that of the service alone" in done.stderr


def test_a_slash_or_a_folder_that_exists_takes_a_file_for_each_target(
    url: str, blobs: tuple[Path, Path], tmp_path: Path
) -> None:
    for name in ("new/", "there"):
        (tmp_path / "there").mkdir(exist_ok=True)
        done = run("match", *blobs, *QUICK, "-o", f"{tmp_path}/{name}", url=url)
        assert done.returncode == 0, done.stderr
        assert [file.name for file in (tmp_path / name).iterdir()] == ["b.json"]


@pytest.mark.parametrize(
    ("command", "message"),
    [
        ("match {0} {1} {0} -o x.json", "name a folder, as in --output x --format json"),
        ("match {0} {1} -o -", "use --json for a result as JSON there"),
        ("match {0} {1} --picture -", "pictures are PNG files"),
        ("compare {0} {1} -o new/", "'new/' is a folder; name a file"),
        ("prototype download p-0 new/", "'new/' is a folder; name a file"),
        ("register {0} {1} -o -", "use --json"),
    ],
)
def test_outputs_that_are_no_place_for_results_are_refused(
    blobs: tuple[Path, Path],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    command: str,
    message: str,
) -> None:
    monkeypatch.chdir(tmp_path)
    done = run(*command.format(*blobs).split(), url="http://127.0.0.1:9")
    assert (done.returncode, done.stdout) == (2, "")
    assert message in " ".join(done.stderr.replace("│", " ").split())
    assert list(tmp_path.iterdir()) == []


def test_errors_of_the_client_have_titles_in_words() -> None:
    titles = {
        OSError(28, "No space left on device"): "OS error",
        FileNotFoundError(2, "No such file"): "File not found error",
        isomatch.WaitTimeout("a job", 1.0): "Wait timeout",
    }
    for error, title in titles.items():
        document = problem_document(error, "message")
        assert (document["title"], document["detail"]) == (title, "message")
        assert document["type"].rsplit(":", 1)[1] == title.lower().replace(" ", "-")


def test_refusals_name_the_options(url: str, blobs: tuple[Path, Path]) -> None:
    wrong = ("--points", "2", "--first-order-weight", "-1")
    said = run("match", *blobs, *wrong, url=url).stderr
    assert "--points: " in said
    assert "--first-order-weight: " in said
    said = run("match", *blobs, "--landmark", "0:999999", url=url).stderr
    assert "--landmark (0.1): 999999 is no vertex of target" in said
    done = run("compare", *blobs, "--labels", "a,b,c", url=url)
    assert (done.returncode, done.stdout) == (2, "")
    assert "--labels: " in done.stderr


def test_wrong_usage(url: str, tmp_path: Path) -> None:
    odd = ["match", __file__, __file__, "--metric", "diffusion:time"]
    nowhere = tmp_path / "no" / "such" / "folder.json"
    for command in (
        ["match"],
        odd,
        ["match", tmp_path / "a.off", tmp_path / "b.off"],
        ["match", __file__, "p-" + 32 * "0"],
        ["match", __file__, __file__, "-o", nowhere],
        ["match", __file__, __file__, "--picture", nowhere.with_suffix(".png")],
        ["match", __file__, __file__, "--picture", tmp_path / "match.jpg"],
        ["match", __file__, __file__, "--picture", tmp_path / "match.png", "--view", "up"],
        ["jobs", "result", "nothing", "--alternative", "1"],
        ["jobs", "list", "--of", "a.off"],
        ["jobs", "list", "--state", "done"],
        ["jobs", "list", "--kind", "maps"],
    ):
        done = run(*command, url=url)
        assert (done.returncode, done.stdout) == (2, "")
    for address in (
        "localhost",
        "ftp://host",
        "http://",
        "http://a b",
        "http://host:99999",
        "http://host:x",
    ):
        done = run("shapes", url=address)
        assert (done.returncode, done.stdout) == (2, "")
        assert "--url" in done.stderr
    assert run_process("frobnicate", url=url).returncode == 2
    assert run("--version", url=url).stdout.split() == ["isomatch", isomatch.__version__]
    shown = run("--help", url=url)
    assert shown.returncode == 0
    for word in ("serve", "upload", "match", "compare", "jobs", "Exit codes", "130"):
        assert word in shown.stdout


def test_what_cannot_be_written_is_refused_before_anything_is_sent(
    tmp_path: Path,
) -> None:
    mesh, other, some_id = tmp_path / "a.off", tmp_path / "b.off", 32 * "0"
    locked, taken = tmp_path / "locked", tmp_path / "taken"
    locked.mkdir()
    for file in (mesh, other, locked / "old.png"):
        file.touch(0o400)
    locked.chmod(0o500)
    (taken / "a.mrk.json").mkdir(parents=True)
    taken.with_suffix(".png").mkdir()
    files: list[list[str | Path]] = [
        ["match", mesh, mesh, "-o"],
        ["match", mesh, mesh, "--picture"],
        ["compare", mesh, mesh, "-o"],
        ["compare", mesh, mesh, "--picture"],
        ["maps", mesh, mesh, mesh, "-o"],
        ["transfer", mesh, mesh, "--what", "uv", "-o"],
        ["transfer", mesh, mesh, "--what", "skinning", "-o"],
        ["prototype", "learn", mesh, mesh, "-o"],
        ["prototype", "download", f"p-{some_id}"],
        ["jobs", "result", some_id, "-o"],
        ["jobs", "result", some_id, "--picture"],
    ]
    folders: list[list[str | Path]] = [
        ["match", mesh, mesh, other, "-o"],
        ["landmarks", mesh, mesh, mesh, "-o"],
        ["register", mesh, mesh, "-o"],
    ]
    refused = [
        (files, [tmp_path / "no" / "a.png", mesh / "a.png", taken.with_suffix(".png")]),
        (folders, [tmp_path / "no" / "where", mesh]),
        (folders[1:2], [taken]),
    ]
    if sys.platform == "linux":
        refused += [(files, [Path("/proc/a.png")]), (folders, [Path("/proc"), Path("/proc/new")])]
    if os.name == "posix" and os.geteuid() != 0:  # root may write everywhere
        refused += [
            (files, [locked / "old.png", locked / "new.png"]),
            (folders, [locked, locked / "new"]),
        ]
    for commands, wrong in refused:
        for command, path in itertools.product(commands, wrong):
            if path.is_dir() and command is files[0]:
                continue  # a folder of matches
            done = run(*command, path, url="http://127.0.0.1:9")
            assert (done.returncode, done.stdout) == (2, ""), (command, path, done.stderr)
            said = " ".join(done.stderr.replace("│", " ").split())
            assert re.search(
                "no folder|(is|not) a folder|cannot be written: |would be overwritten", said
            ), said
    assert sorted(tmp_path.iterdir()) == [mesh, other, locked, taken, taken.with_suffix(".png")]
    formats = [
        (0, "a.zip", ".json, .npz, .csv, .ply, .obj, .glb or .png"),
        (0, "a.vtk", ".json, .npz, .csv, .ply, .obj, .glb or .png"),
        (2, "a.ply", ".json, .npz, .csv or .png"),
        (4, "a.csv", ".json or .npz"),
        (5, "a.ply", ".json, .npz, .csv, .obj, .glb or .zip"),
        (5, "a.seg", ".json, .npz, .csv, .obj, .glb or .zip"),
        (6, "a.obj", ".json, .npz, .csv, .ply or .glb"),
        (6, "a.zip", ".json, .npz, .csv, .ply or .glb"),
        (7, "a.npz", "give .json"),
        (9, "a.xlsx", ".json, .npz, .csv, .ply, .obj, .glb, .zip or .png"),
    ]
    for place, name, there in formats:
        done = run(*files[place], tmp_path / name, url="http://127.0.0.1:9")
        assert done.returncode == 2
        said = " ".join(done.stderr.replace("│", " ").split())
        assert f"this result has no {Path(name).suffix} file: give" in said
        assert there in said


def test_files_of_results_that_are_not_awaited_are_refused(tmp_path: Path) -> None:
    mesh, other, file = tmp_path / "a.off", tmp_path / "b.off", tmp_path / "file"
    for one in (mesh, other):
        one.touch()
    commands: list[list[str | Path]] = [
        ["match", mesh, other, "-o", file.with_suffix(".json")],
        ["match", mesh, other, "--picture", file.with_suffix(".png")],
        ["match", mesh, mesh, other, "-o", file],
        ["compare", mesh, other, "-o", file.with_suffix(".csv")],
        ["compare", mesh, other, "--picture", file.with_suffix(".png")],
        ["maps", mesh, other, "-o", file.with_suffix(".npz")],
        ["transfer", mesh, other, "--what", "colors", "-o", file.with_suffix(".ply")],
        ["prototype", "learn", mesh, other, "-o", file.with_suffix(".json")],
    ]
    for command in commands:
        done = run(*command, "--no-wait", url="http://127.0.0.1:9")
        assert (done.returncode, done.stdout) == (2, ""), (command, done.stderr)
        assert "`isomatch jobs result ID --" in " ".join(done.stderr.replace("│", " ").split())
    assert not file.exists()


@pytest.mark.skipif(sys.platform == "win32", reason="no pseudo-terminals")
def test_colours_follow_no_color(url: str) -> None:
    def said(**environment: str) -> bytes:
        ours, theirs = pty.openpty()
        inherited = {k: v for k, v in os.environ.items() if k != "NO_COLOR"}
        with subprocess.Popen(
            [*COMMAND, "--help"],
            env={**inherited, "TERM": "xterm-256color", **environment},
            stdout=theirs,
            stderr=theirs,
        ) as process:
            os.close(theirs)
            text = b""
            with contextlib.suppress(OSError):  # what Linux says at the end of a terminal
                while piece := os.read(ours, 65536):
                    text += piece
            os.close(ours)
        assert process.returncode == 0
        return text

    colour = re.compile(rb"\x1b\[[0-9;]*3[0-7]")
    assert colour.search(said())
    assert not colour.search(said(NO_COLOR="1"))


def test_a_closed_output_pipe(url: str, blobs: tuple[Path, Path]) -> None:
    program = f"{shlex.join(COMMAND)} structures --json --url {url} | head -c 20"
    done = subprocess.run(["bash", "-c", program], capture_output=True, text=True, check=False)
    assert (len(done.stdout), done.stderr) == (20, "")


def test_serve(tmp_path: Path) -> None:
    # The client alone can be imported: elsewhere a service could be found, and would start.
    alone = {**os.environ, "PYTHONPATH": str(ROOT / "client")}

    def served(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
        return subprocess.run(
            [*COMMAND, "serve", *arguments],
            cwd=folder,
            env=alone,
            capture_output=True,
            text=True,
            timeout=240,
            check=False,
        )

    away = served(tmp_path)
    assert (away.returncode, away.stdout) == (1, "")
    assert "make serve" in away.stderr
    here = served(ROOT, "--port", "-1")
    assert here.returncode == 2  # the application itself refuses such a port
    assert "PORT" in here.stderr


def test_a_waiting_upload_is_reported(capsys: pytest.CaptureFixture[str]) -> None:
    before = set(threading.enumerate())

    def until_reported() -> None:
        for thread in set(threading.enumerate()) - before:
            if isinstance(thread, threading.Timer):
                thread.join()

    with named_upload("a.off", as_json=False, after=0.01):
        until_reported()
    assert "a.off is not read yet" in capsys.readouterr().err
    with named_upload("a.off", as_json=True, after=0.01):
        until_reported()
    with named_upload("a.off", as_json=False, after=30.0):
        pass
    assert capsys.readouterr().err == ""


def test_no_service() -> None:
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        port = listener.getsockname()[1]
    done = run_process("shapes", url=f"http://127.0.0.1:{port}")
    assert (done.returncode, done.stdout) == (3, "")
    assert done.stderr.count("\n") == 1
    assert "isomatch serve" in done.stderr
    as_json = run("shapes", "--json", url=f"http://127.0.0.1:{port}")
    assert (as_json.returncode, as_json.stdout) == (3, "")
    assert json.loads(as_json.stderr)["type"] == "urn:isomatch:client:connection-failed"


@pytest.mark.skipif(sys.platform == "win32", reason="no SIGINT to send")
def test_an_interrupt_while_the_command_starts_is_silent() -> None:
    interrupted = """
import signal, sys
class Interrupt:
    def find_spec(self, name, path, target=None):
        if name == "isomatch.cli":
            signal.raise_signal(signal.SIGINT)
sys.meta_path.insert(0, Interrupt())
import isomatch_command
isomatch_command.main()
"""
    done = subprocess.run(
        [sys.executable, "-c", interrupted], capture_output=True, text=True, timeout=60
    )
    assert (done.returncode, done.stdout, done.stderr) == (-signal.SIGINT, "", "")


@pytest.mark.skipif(sys.platform == "win32", reason="no SIGINT to send")
def test_interrupting_jobs_follow_leaves_the_job(url: str, blobs: tuple[Path, Path]) -> None:
    with isomatch.Client(url) as client:
        job = client.match(*map(client.upload, blobs), **LASTING)
        process = subprocess.Popen(
            [*COMMAND, "jobs", "follow", job.id, "--url", url],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        with process:
            assert process.stdout is not None
            process.stdout.readline()
            process.send_signal(signal.SIGINT)
            _, said = process.communicate(timeout=240)
        assert process.returncode == 130, said
        assert f"job {job.id} continues" in said
        assert not job.refresh().finished
        job.cancel().wait(timeout=240)


@pytest.mark.skipif(sys.platform == "win32", reason="no SIGINT to send")
def test_interrupting_match_cancels_the_job(url: str, blobs: tuple[Path, Path]) -> None:
    with isomatch.Client(url) as client:
        before = {job.id for job in client.jobs()}
        process = subprocess.Popen(
            [*COMMAND, "match", *map(str, blobs), *ENDLESS, "--url", url],
            stderr=subprocess.PIPE,
            text=True,
        )
        with process:
            new: set[str] = set()
            while not new and process.poll() is None:
                time.sleep(0.1)
                new = {job.id for job in client.jobs()} - before
            process.send_signal(signal.SIGINT)
            _, said = process.communicate(timeout=240)
        assert process.returncode == 130, said
        (job_id,) = new
        assert f"job {job_id} cancelled" in said
        assert client.job(job_id).wait(timeout=240).state == "cancelled"
