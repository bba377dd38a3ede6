"""Names of shapes in results: those of the uploads that the request is made of."""

import csv
import json
from pathlib import Path

import isomatch
import pytest

from tests.client.command_line import run

QUICK = ["--points", "6", "--coarse-points", "6"]


@pytest.fixture(scope="module")
def second_names(blobs: tuple[Path, Path], tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    """The files of the blobs under other names, once their bytes are stored under the first."""
    folder = tmp_path_factory.mktemp("second")
    files = [folder / f"second-{file.name}" for file in blobs]
    for file, stored in zip(files, blobs, strict=True):
        file.write_bytes(stored.read_bytes())
    return files


@pytest.fixture
def again(
    client: isomatch.Client, blobs: tuple[Path, Path], second_names: list[Path]
) -> list[isomatch.Shape]:
    for file in blobs:
        client.upload(file)
    return [client.upload(file) for file in second_names]


def test_dissimilarities_have_the_names_of_the_uploads(
    client: isomatch.Client, again: list[isomatch.Shape], tmp_path: Path
) -> None:
    job = client.dissimilarities(again, points=4)
    assert job.result().names == ("second-a.off", "second-b.obj")
    job.save(tmp_path / "matrix.csv")
    with (tmp_path / "matrix.csv").open(newline="") as file:
        assert next(csv.reader(file)) == ["", "second-a.off", "second-b.obj"]
    by_ids = client.dissimilarities([again[0].id, again[1]], points=4).result()
    assert by_ids.names == ("a.off", "second-b.obj")


def test_registrations_have_the_names_of_the_uploads(
    client: isomatch.Client, again: list[isomatch.Shape], tmp_path: Path
) -> None:
    job = client.register(again[0], again[1:])
    found = job.result()
    assert (found.template_name, found.specimens[0].name) == ("second-a.off", "second-b.obj")
    assert found.save_meshes(tmp_path)[0].name == "second-b.ply"
    job.save_registered(tmp_path / "registered.obj")
    assert "second-b.obj" in (tmp_path / "registered.obj").read_text()
    by_ids = client.register(again[0].id, [again[1].id]).result()
    assert (by_ids.template_name, by_ids.specimens[0].name) == ("a.off", "b.obj")


def test_consistent_maps_have_the_names_of_the_uploads(
    client: isomatch.Client, again: list[isomatch.Shape]
) -> None:
    found = client.consistent_maps(again).result()
    assert [one.name for one in found.shapes] == ["second-a.off", "second-b.obj"]
    assert (found.pairs[0].source_name, found.pairs[0].target_name) == (
        "second-a.off",
        "second-b.obj",
    )


@pytest.mark.usefixtures("again")
def test_commands_name_the_files_that_they_are_given(url: str, second_names: list[Path]) -> None:
    matched = json.loads(run("match", *second_names, *QUICK, "--json", url=url).stdout)
    assert (matched["source_name"], matched["target_name"]) == ("second-a.off", "second-b.obj")
    batch = json.loads(
        run("match", *second_names, second_names[0], *QUICK, "--json", url=url).stdout
    )
    assert batch["source_name"] == "second-a.off"
    maps = json.loads(run("maps", *second_names, "--json", url=url).stdout)
    assert [one["name"] for one in maps["shapes"]] == ["second-a.off", "second-b.obj"]
    compared = run("compare", *second_names, "--points", "4", url=url)
    assert "second-a" in compared.stdout
