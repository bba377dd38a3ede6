"""Files of ``isomatch landmarks`` while its specimens come in."""

import csv
from pathlib import Path

import numpy as np
import pytest
from isomatch import CarriedLandmarks, read_landmarks, write_landmarks
from isomatch._cli.landmark_output import TABLE, LandmarkOutput
from isomatch._landmarks import LandmarkFormat

LABELS = ("tip", "root")


def carried(seed: int) -> CarriedLandmarks:
    rng = np.random.default_rng(seed)
    sure, trips, changes, spread, apart = rng.random((5, len(LABELS)))
    positions, probabilities = rng.random((len(LABELS), 3)), rng.random(1)
    return CarriedLandmarks(LABELS, positions, sure, trips, changes, spread, apart, probabilities)


FOUND = {name: carried(seed) for seed, name in enumerate("abc")}


def specimens_of(folder: Path) -> list[str]:
    rows = csv.DictReader((folder / TABLE).read_text().splitlines())
    return [row["specimen"] for row in rows if row["label"] == LABELS[0]]


@pytest.mark.parametrize("file_format", ["tps", "txt"])
def test_files_of_all_specimens_are_complete_after_each(
    file_format: LandmarkFormat, tmp_path: Path
) -> None:
    path, at_once = tmp_path / f"landmarks.{file_format}", tmp_path / f"all.{file_format}"
    for _ in range(2):
        output = LandmarkOutput(tmp_path, file_format, "LPS")
        for count, (name, found) in enumerate(FOUND.items(), start=1):
            output.add(name, found)
            assert [one.name for one in read_landmarks(path)] == list(FOUND)[:count]
            assert specimens_of(tmp_path) == list(FOUND)[:count]
        write_landmarks(at_once, [one.landmark_set(name) for name, one in FOUND.items()])
        assert path.read_bytes() == at_once.read_bytes()


def test_files_of_an_earlier_run_are_named(tmp_path: Path) -> None:
    LandmarkOutput(tmp_path, "mrk.json", "LPS").add("a", FOUND["a"])
    later = LandmarkOutput(tmp_path, "mrk.json", "LPS")
    assert later.outdated(["a", "c"]) == [tmp_path / "a.mrk.json", tmp_path / TABLE]
    later.add("b", FOUND["b"])
    assert later.outdated(["a", "c"]) == [tmp_path / "a.mrk.json"]


@pytest.mark.parametrize("file_format", ["tps", "txt", "mrk.json"])
def test_each_specimen_is_written_once(file_format: LandmarkFormat, tmp_path: Path) -> None:
    output = LandmarkOutput(tmp_path, file_format, "LPS")
    output.add("a", FOUND["a"])
    for file in tmp_path.iterdir():
        file.write_bytes(b"")
    output.add("b", FOUND["b"])
    earlier, later = (str(FOUND[name].positions[0, 0]) for name in "ab")
    assert later in (tmp_path / TABLE).read_text()
    assert not any(earlier in file.read_text() for file in tmp_path.iterdir())
