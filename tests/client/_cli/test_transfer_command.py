"""``isomatch transfer`` against the running service, and what it refuses beforehand."""

import json
import re
from pathlib import Path
from typing import Any

import isomatch
import pytest
from isomatch._cli.transfer_checks import READ
from isomatch._operations.result_files import TRANSFER_FORMATS
from isomatch._results import KINDS, TransferKind
from pydantic import ValidationError

from broker.contracts import ATTRIBUTE_FORMATS, TransferPayload, exports_of
from service.transfers.schemas import TransferRequest
from tests.client.command_line import run

QUICK = ["--points", "6", "--coarse-points", "6"]


def test_a_file_of_values_is_missed_before_shapes_are_matched(
    url: str, blobs: tuple[Path, Path]
) -> None:
    done = run("transfer", *blobs, "nothing.csv", "--what", "scalars", url=url)
    assert done.returncode == 2
    assert "there is no file 'nothing.csv'" in done.stderr
    assert "succeeded" not in done.stderr


@pytest.mark.parametrize(
    ("what", "ending", "message"),
    [
        ("scalars", "tps", ".npz, .csv, .ply, .glb, .seg, .txt"),
        ("labels", "mrk.json", ".npz, .csv, .ply, .glb, .obj, .seg, .txt"),
        ("skinning", "obj", "files with skinning are .npz, .csv, .ply, .glb"),
        ("uv", "csv", "without a file of values"),
    ],
)
def test_files_that_hold_no_such_values_are_refused_before_anything_is_sent(
    blobs: tuple[Path, Path], tmp_path: Path, what: str, ending: str, message: str
) -> None:
    values = tmp_path / f"x.{ending}"
    values.touch()
    done = run("transfer", *blobs, values, "--what", what, url="http://127.0.0.1:9")
    assert (done.returncode, done.stdout) == (2, "")
    assert message in " ".join(done.stderr.replace("│", " ").split())


@pytest.mark.parametrize(
    ("what", "options"),
    [
        ("landmarks", {}),
        ("landmarks", {"--point": "17", "--on": "faces"}),
        ("scalars", {"--point": "17"}),
        ("labels", {"--influences": "4"}),
        ("texture", {"--name": "part"}),
        ("uv", {"--on": "vertices"}),
        ("skinning", {"--on": "faces"}),
    ],
)
def test_options_that_the_service_refuses_are_refused_before_anything_is_sent(
    blobs: tuple[Path, Path], what: str, options: dict[str, str]
) -> None:
    words = [word for option in options.items() for word in option]
    done = run("transfer", *blobs, "--what", what, *words, url="http://127.0.0.1:9")
    assert (done.returncode, done.stdout) == (2, "")
    assert "Invalid value for --" in done.stderr
    fields: dict[str, Any] = {
        "--point": lambda given: {"points": [int(given)]},
        "--name": lambda given: {"names": [given]},
        "--on": lambda given: {"on": given},
        "--influences": lambda given: {"influences": int(given)},
    }
    asked: dict[str, Any] = {"match": 32 * "0", "what": what}
    for option, given in options.items():
        asked |= fields[option](given)
    with pytest.raises(ValidationError, match="contradiction"):
        TransferRequest.model_validate(asked)


@pytest.mark.parametrize(
    ("point", "message"),
    [
        ("5:0.5,9:0.9,7:0.5", "sum 1"),
        ("5:1.5,9:-0.9,7:0.4", "must not be negative"),
        ("5:nan,9:0.5,7:0.5", "sum 1"),
        ("5:0.5,9:0.5", "a landmark is a vertex"),
        ("-3", "a landmark is a vertex"),
        ("nose", "a landmark is a vertex"),
        ("1_0", "a landmark is a vertex"),
        ("1_0:0.2,9:0.3,7:0.5", "a landmark is a vertex"),
        ("4:0.2,9:0.3,7:0.5_0", "a landmark is a vertex"),
    ],
)
def test_wrong_points_are_refused_before_anything_is_sent(
    blobs: tuple[Path, Path], point: str, message: str
) -> None:
    options = ("--what", "landmarks", f"--point={point}")
    done = run("transfer", *blobs, *options, url="http://127.0.0.1:9")
    assert (done.returncode, done.stdout) == (2, "")
    assert "Invalid value for --point" in done.stderr
    assert message in " ".join(done.stderr.replace("│", " ").split())


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--what", "colors"], "a.off has no colours"),
        (["--what", "colors", "--back"], "b.obj has no colours"),
        (["--what", "landmarks", "--point", "642"], "642 is no vertex of a.off, which has 642"),
        (["--what", "texture"], "a.off has no texture"),
        (["--what", "uv"], "a.off has no texture coordinates"),
        (["--what", "skinning"], "a.off has no skinning weights: give a file of them"),
        (["--what", "labels"], "a.off has no labels: give a file of them"),
    ],
)
def test_what_a_shape_does_not_have_is_missed_before_it_is_matched(
    url: str, blobs: tuple[Path, Path], options: list[str], message: str
) -> None:
    done = run("transfer", *blobs, *options, url=url)
    assert (done.returncode, done.stdout) == (1, "")
    assert message in done.stderr
    assert "succeeded" not in done.stderr


def test_values_that_do_not_fit_are_missed_before_shapes_are_matched(
    url: str, blobs: tuple[Path, Path], tmp_path: Path
) -> None:
    short, long, empty = (tmp_path / name for name in ("short.csv", "long.csv", "empty.npz"))
    short.write_text("height\n" + "1.5\n" * 10)
    long.write_text("height\n" + "1.5\n" * 642)
    empty.write_bytes(b"PK")
    for file, options, message in (
        (short, ["scalars"], "short.csv has 10 rows, but a.off has 642 vertices and 1,280 faces"),
        (long, ["scalars", "--name", "age"], "long.csv has nothing called 'age'; there are"),
        (empty, ["scalars"], f"isomatch: {empty}: "),
    ):
        done = run("transfer", *blobs, file, "--what", *options, url=url)
        assert (done.returncode, done.stdout) == (1, ""), done.stderr
        assert message in done.stderr
        assert "succeeded" not in done.stderr


def test_the_match_of_a_transfer_that_fails_is_kept(
    url: str, blobs: tuple[Path, Path], tmp_path: Path
) -> None:
    values = tmp_path / "heights.csv"
    values.write_text("height\n" + "1.5\n" * 642)
    done = run("transfer", *blobs, values, "--what", "vectors", url=url)
    assert (done.returncode, done.stdout) == (4, "")
    assert "vectors" in done.stderr
    match = re.search(r"kept: `isomatch transfer (\w+) ", done.stderr)
    assert match is not None
    again = run("transfer", match[1], values, "--what", "scalars", "--json", url=url)
    assert (again.returncode, json.loads(again.stdout)["match"]) == (0, match[1])
    wrong = run("transfer", match[1], values, "--what", "vectors", url=url)
    assert (wrong.returncode, "kept" in wrong.stderr) == (4, False)


def test_two_meshes_may_be_ids(url: str, blobs: tuple[Path, Path]) -> None:
    with isomatch.Client(url) as client:
        ids = [client.upload(file).id for file in blobs]
    done = run("transfer", *ids, "--what", "colors", url=url)
    assert (done.returncode, done.stdout) == (1, "")
    assert "a.off has no colours" in done.stderr


def test_two_meshes_are_matched_with_the_options_of_a_transfer(
    url: str, blobs: tuple[Path, Path]
) -> None:
    what = ("--what", "landmarks", "--point", "17")
    options = ("--partial", "none", "--landmark", "17:203", "--largest-component")
    done = run("transfer", *blobs, *what, *options, "--json", url=url)
    assert done.returncode == 0, done.stderr
    with isomatch.Client(url) as client:
        job = client.job(json.loads(done.stdout)["match"])
        found: isomatch.Match = job.result()
    asked: dict[str, Any] = {**found.parameters}
    assert [tuple(pair) for pair in asked["landmarks"]] == [(17, 203)]
    assert (asked["partial"], asked["largest_component"]) == ("none", True)
    again = run("transfer", job.id, *what, "--landmark", "17:203", url=url)
    assert again.returncode == 2
    assert "Invalid value for --landmark: the match is made already" in again.stderr


@pytest.mark.parametrize("what", KINDS)
def test_files_of_transfers_are_those_of_the_service(what: TransferKind) -> None:
    payload = TransferPayload(
        match="m", source="s", target="t", attributes=None, what=what, direction="source_to_target"
    )
    assert TRANSFER_FORMATS[what] == ("npz", *exports_of(payload))
    assert set(READ.get(what, ())) <= set(ATTRIBUTE_FORMATS)
