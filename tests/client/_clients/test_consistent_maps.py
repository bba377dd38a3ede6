"""Consistent maps by the SDK and the command line, against the running service."""

import json
from pathlib import Path

import isomatch
import numpy as np
import pytest

from tests.client.command_line import run
from tests.client.shapes import blob_meshes, moved

FIRST, SECOND = blob_meshes()


@pytest.fixture(scope="module")
def third(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The first blob, its vertices in the opposite order."""
    file = tmp_path_factory.mktemp("third") / "c.off"
    last = len(FIRST.vertices) - 1
    mesh = FIRST.copy()
    mesh.vertices, mesh.faces = FIRST.vertices[::-1], last - FIRST.faces
    mesh.export(file)
    return file


def test_maps_are_arrays(
    client: isomatch.Client, blobs: tuple[Path, Path], third: Path, tmp_path: Path
) -> None:
    job = client.consistent_maps([client.upload(file) for file in (*blobs, third)])
    found = job.result()
    assert [(one.source_name, one.target_name) for one in found.pairs] == [
        ("a.off", "b.obj"), ("a.off", "c.off"), ("b.obj", "c.off")
    ]  # fmt: skip
    assert all(pair.fits for pair in found.pairs)
    assert all(shape.fits for shape in found.shapes)
    assert found.cycle_error is not None
    assert found.cycle_error < 0.02
    backwards = np.arange(len(FIRST.vertices))[::-1]
    size = np.sqrt(FIRST.area)
    apart = FIRST.vertices[found.map(2, 0)] - FIRST.vertices[backwards]
    assert np.linalg.norm(apart, axis=1).mean() < 0.02 * size
    apart = SECOND.vertices[found.map(0, 1)] - moved(FIRST.vertices)
    assert np.linalg.norm(apart, axis=1).mean() < 0.05 * size
    job.save(tmp_path / "maps.npz")
    with np.load(tmp_path / "maps.npz", allow_pickle=False) as arrays:
        np.testing.assert_array_equal(arrays["map_1_2"], found.map(1, 2))
    with pytest.raises(IndexError, match="3 shapes"):
        found.map(0, 3)
    with pytest.raises(ValueError, match="two different"):
        found.map(1, 1)
    with pytest.raises(ValueError, match="no arrays"):
        isomatch.ConsistentMaps.from_json(found.to_json()).map(0, 1)


def test_the_command_prints_the_pairs_and_writes_the_maps(
    url: str, blobs: tuple[Path, Path], third: Path, tmp_path: Path
) -> None:
    out = tmp_path / "maps.npz"
    done = run("maps", *blobs, third, "-o", out, url=url)
    assert done.returncode == 0, done.stderr
    (errors,) = [one for one in done.stdout.splitlines() if "mean cycle error: " in one]
    assert 0.0 < float(errors.split()[-1]) < 0.1
    (line,) = [line for line in done.stdout.splitlines() if "fits" in line and "c.off" in line]
    assert len(line.split()[1]) == 32
    with np.load(out, allow_pickle=False) as arrays:
        assert len(arrays.files) == 7
    done = run("maps", *blobs, "--json", url=url)
    assert done.returncode == 0, done.stderr
    (pair,) = json.loads(done.stdout)["pairs"]
    assert pair["mapped"]
    assert pair["cycle_error"] is None
