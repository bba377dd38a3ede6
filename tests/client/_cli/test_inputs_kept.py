"""Commands refuse to overwrite what they read, before anything is sent."""

from pathlib import Path

import isomatch
import pytest
import trimesh

from tests.client.command_line import run

NOWHERE = "http://127.0.0.1:9"
COMMANDS = [
    "match a.ply b.ply --dense -o a.ply",
    "match a.ply b.ply --dense -o sub/../b.ply",
    "match a.ply b.ply --dense -o link.ply",
    "match a.ply b.ply --dense -o hard.ply",
    "match a.ply b.ply -o . --dense --format ply",
    "match a.ply b.ply c.ply -o . --dense --format ply",
    "match a.png b.ply --picture a.png",
    "compare a.csv b.ply -o a.csv",
    "compare a.png b.ply --picture a.png",
    "maps a.npz b.ply -o a.npz",
    "prototype learn a.json b.ply -o a.json",
    "register mean.ply a.ply b.ply -o .",
    "register a.ply sub/b.ply sub/a.ply -o .",
    "register s.ply components.npz b.ply -o .",
    "landmarks a.ply landmarks.csv b.ply -o .",
    "landmarks a.ply b.mrk.json b.ply -o .",
    "landmarks a.ply a.csv b.ply -o . --format csv --template c.ply=b.csv",
    "transfer a.ply b.ply a.csv --what labels -o a.csv",
    "transfer 00000000000000000000000000000000 a.csv --what labels -o a.csv",
    "transfer a.ply b.ply --what colors -o b.ply",
]


@pytest.mark.parametrize("command", COMMANDS)
def test_no_command_overwrites_what_it_reads(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, command: str
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("sub").mkdir()
    names = "a.ply b.ply c.ply s.ply mean.ply a.csv b.csv a.png a.npz a.json landmarks.csv"
    for name in [*names.split(), "b.mrk.json", "components.npz", "sub/a.ply", "sub/b.ply"]:
        Path(name).write_text(name)
    Path("link.ply").symlink_to("a.ply")
    Path("hard.ply").hardlink_to("a.ply")
    before = {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()}
    done = run(*command.split(), url=NOWHERE)
    assert (done.returncode, done.stdout) == (2, ""), done.stderr
    said = " ".join(done.stderr.replace("│", " ").split())
    assert "is read by this command, and would be overwritten" in said
    assert {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()} == before


def test_names_that_the_service_tells_are_kept_too(
    url: str, blobs: tuple[Path, Path], tmp_path: Path
) -> None:
    """A specimen that is given by its id has the name of the file of the template."""
    template = tmp_path / "mine.ply"
    trimesh.creation.icosphere(subdivisions=2).export(template)
    before = template.read_bytes()
    with isomatch.Client(url) as client:
        specimen = client.upload(blobs[1].read_bytes() + b"# mine", "mine.obj", file_type="obj").id
    done = run("register", template, specimen, "-o", tmp_path, url=url)
    assert done.returncode == 2, done.stderr
    assert template.read_bytes() == before


def test_results_overwrite_other_files(url: str, blobs: tuple[Path, Path], tmp_path: Path) -> None:
    old = tmp_path / "old.json"
    old.write_text("of a run before")
    done = run("match", *blobs, "--points", "6", "--coarse-points", "6", "-o", old, url=url)
    assert done.returncode == 0, done.stderr
    assert isomatch.Match.from_json(old.read_bytes()).pairs.size
