"""Batches by both clients and the command line, against the running service."""

import json
from pathlib import Path

import anyio
import isomatch
import pytest

from tests.client.command_line import run
from tests.client.shapes import LASTING

Pair = tuple[isomatch.Shape, isomatch.Shape]


def test_matches_as_they_end(client: isomatch.Client, pair: Pair, tmp_path: Path) -> None:
    source, target = pair
    batch = client.match_many(source, [target, source.id], points=8, orientation=False)
    found = {job.target: job.result() for job in batch.ended_matches()}
    assert set(found) == {source.id, target.id}
    assert all(isinstance(one, isomatch.Match) for one in found.values())
    result = batch.result()
    assert isinstance(result, isomatch.Batch)
    assert (result.succeeded, result.source_name) == (2, source.name)
    assert [one.target_name for one in result.matches] == [target.name, source.name]
    assert batch.matches().matches == result.matches
    for match in result.matches:
        assert match.job is not None
        assert match.summary is not None
        assert client.job(match.job).batch == batch.id
        assert match.summary.energy == found[match.target].energy
    batch.save(tmp_path / "batch.json")
    assert isomatch.Batch.from_json((tmp_path / "batch.json").read_bytes()) == result
    with pytest.raises(ValueError, match="draw its matches"):
        result.plot()
    alone = client.match(source, target, points=8, orientation=False)
    with pytest.raises(isomatch.Conflict):
        alone.matches()
    alone.wait()


def test_the_asynchronous_client_finds_the_same(url: str, pair: Pair) -> None:
    async def asked() -> tuple[isomatch.Batch, set[str]]:
        async with isomatch.AsyncClient(url) as client:
            batch = await client.match_many(pair[0], [pair[1]], points=8, orientation=False)
            ended = {job.id async for job in batch.ended_matches()}
            assert (await batch.matches()).ended == 1
            return await batch.result(), ended

    result, ended = anyio.run(asked)
    assert ended == {one.job for one in result.matches}
    assert result.succeeded == 1


def test_a_match_that_waits_is_cancelled_alone(client: isomatch.Client, pair: Pair) -> None:
    # More matches than there are workers.
    batch = client.match_many(pair[0], [pair[1]] * 6, **LASTING)
    waiting = batch.matches().matches[-1].job
    assert waiting is not None
    assert client.job(waiting).cancel().wait().state == "cancelled"
    states = [match.state for match in batch.matches().matches]
    assert states[-1] == "cancelled"
    assert "cancelled" not in states[:-1]
    batch.cancel().wait()


def test_matches_that_still_run_when_their_batch_is_cancelled(
    client: isomatch.Client, url: str, pair: Pair
) -> None:
    batch = client.match_many(pair[0], [pair[1]] * 4, **LASTING)
    matches = batch.matches().matches
    for _ in client.job(matches[0].job).events():
        if client.job(matches[0].job).state == "running":
            break
    batch.cancel()
    assert {job.id: job.state for job in batch.ended_matches()} == {
        match.job: "cancelled" for match in matches
    }

    async def asked() -> set[str]:
        async with isomatch.AsyncClient(url) as other:
            same = await other.job(batch.id)
            return {job.id async for job in same.ended_matches()}

    assert anyio.run(asked) == {match.job for match in matches}


def test_a_cancelled_batch(client: isomatch.Client, pair: Pair) -> None:
    batch = client.match_many(pair[0], [pair[1]], **LASTING)
    assert batch.cancel().wait().state == "cancelled"
    assert [job.state for job in batch.ended_matches()] == ["cancelled"]
    with pytest.raises(isomatch.JobCancelled):
        batch.result()
    with pytest.raises(TypeError, match="match_many"):
        client.match_many(pair[0], [pair[1]], pionts=8)  # type: ignore[call-arg]


def test_the_command_writes_a_file_for_each_target(
    url: str, blobs: tuple[Path, Path], tmp_path: Path
) -> None:
    folder = tmp_path / "results"
    options: list[str | Path] = ["--points", "8", "--dense", "-o", folder, "--format", "ply"]
    done = run("match", blobs[0], *blobs, *options, url=url)
    assert done.returncode == 0, done.stderr
    assert sorted(file.name for file in folder.iterdir()) == ["a.ply", "b.ply"]
    assert (folder / "b.ply").read_bytes().startswith(b"ply")
    assert "2 of 2" in done.stdout
    again = run("match", blobs[0], *blobs, "--points", "8", "--json", "-o", folder, url=url)
    matches = json.loads(again.stdout)["matches"]
    assert json.loads((folder / "b.json").read_bytes())["target"] == matches[1]["target"]
    job = json.loads(run("jobs", "list", "--kind", "batch", "--json", url=url).stdout)[0]["id"]
    assert "succeeded" in run("jobs", "result", job, url=url).stdout


def test_what_cannot_be_written_is_refused_before_the_job_starts(
    url: str, blobs: tuple[Path, Path], tmp_path: Path
) -> None:
    (tmp_path / "file").write_text("")
    (tmp_path / "there" / "b.json").mkdir(parents=True)
    other = tmp_path / "a.off"
    other.write_bytes(blobs[0].read_bytes())
    refused: list[tuple[list[str | Path], str]] = [
        ([blobs[1], "-o", tmp_path / "file"], "not a folder"),
        ([blobs[1], "-o", tmp_path / "no" / "where"], "no folder"),
        ([blobs[1], "-o", tmp_path / "there"], "is a folder"),
        ([other, "-o", tmp_path], "called 'a'"),
        ([blobs[1], "-o", tmp_path, "--format", "xml"], "none of"),
        ([blobs[1], "-o", tmp_path, "--format", "glb"], "--dense"),
        ([blobs[1], "--format", "json"], "--output"),
        ([blobs[1], "--picture", tmp_path / "a.png"], "--format"),
    ]
    for options, word in refused:
        done = run("match", blobs[0], blobs[0], *options, url="http://127.0.0.1:9")
        assert done.returncode == 2, done.stderr
        assert word in " ".join(done.stderr.replace("│", " ").split()), done.stderr


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no device that is full")
@pytest.mark.parametrize("options", [[], ["--json"]])
def test_a_file_that_cannot_be_written_is_reported(
    url: str, blobs: tuple[Path, Path], tmp_path: Path, options: list[str]
) -> None:
    full = tmp_path / "b.json"
    full.symlink_to("/dev/full")
    done = run("match", blobs[0], *blobs, "--points", "8", "-o", tmp_path, *options, url=url)
    assert done.returncode == 1
    if options:
        job = json.loads(done.stdout)["matches"][1]["job"]
        document = json.loads(done.stderr)
        assert (document["type"], document["job"]) == ("urn:isomatch:client:os-error", job)
        assert document["file"] == str(full)
    else:
        assert f"isomatch: {full}: " in done.stderr
