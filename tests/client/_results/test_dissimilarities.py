"""Collections through the client and the command line, against the running service."""

import json
from pathlib import Path

import isomatch
import numpy as np
import pytest
from isomatch._cli.uploads import class_of
from pydantic import ValidationError

from tests.client.command_line import run
from tests.client.shapes import CLASSES
from tests.worker.collections import class_files

QUICK = ["--eigenpairs", "40"]


@pytest.fixture(scope="module")
def meshes(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    """Six files, two of each class, named like ``box0.off``."""
    folder = tmp_path_factory.mktemp("classes")
    paths = []
    for number, (name, data) in enumerate(class_files()):
        paths.append(folder / f"{name}{number % 2}.off")
        paths[-1].write_bytes(data)
    return paths


def test_a_collection(client: isomatch.Client, meshes: list[Path], tmp_path: Path) -> None:
    shapes = [client.upload(mesh) for mesh in meshes]
    labels = [mesh.stem[:-1] for mesh in meshes]
    job = client.dissimilarities(shapes, labels, eigenpairs=40, points=6)
    found = job.result(progress=True, timeout=240)
    assert job.kind == "dissimilarities"
    assert found.shapes == tuple(shape.id for shape in shapes)
    assert found.labels == tuple(labels)
    assert found.matrix.shape == (6, 6)
    assert found.matrix.dtype == np.float64
    assert (found.matrix == found.matrix.T).all()
    assert found.certified
    assert (found.lower_bound_matrix <= found.matrix).all()
    assert found.nearest.shape == (6, 5)
    assert (found.nearest[:, 0] == [1, 0, 3, 2, 5, 4]).all()
    assert found.mean_average_precision == found.precision_at_1 == 1.0
    shown = "<Dissimilarities of 6 shapes, certified, mean average precision 1.000>"
    assert repr(found) == str(found) == shown
    job.save_arrays(tmp_path / "matrix.npz")
    with np.load(tmp_path / "matrix.npz", allow_pickle=False) as arrays:
        assert arrays["matrix"] == pytest.approx(found.matrix, rel=1e-8)
    assert job.picture().startswith(b"\x89PNG")
    known = job.partial()
    assert (known.pairs_done, known.pairs) == (15, 15)
    assert known.matrix == pytest.approx(found.matrix, rel=1e-8)
    found.save(tmp_path / "found.json")
    again = isomatch.Dissimilarities.from_json((tmp_path / "found.json").read_bytes())
    assert (again.matrix == found.matrix).all()
    assert json.loads(again.model_dump_json())["nearest"] == found.nearest.tolist()
    later = client.job(job.id).result()
    assert isinstance(later, isomatch.Dissimilarities)


def test_refusals(client: isomatch.Client, meshes: list[Path]) -> None:
    shapes = [client.upload(mesh) for mesh in meshes[:2]]
    with pytest.raises(TypeError, match="dissimilarities"):
        client.dissimilarities(shapes, point=6)  # type: ignore[call-arg]
    with pytest.raises(isomatch.InvalidRequest) as refused:
        client.dissimilarities(shapes[:1] * 2)
    assert [wrong.field for wrong in refused.value.errors] == ["body.shapes.1"]
    with pytest.raises(isomatch.UnknownShape):
        client.dissimilarities([*shapes, "nobody"])


def test_a_matrix_with_gaps_is_refused() -> None:
    document: dict[str, object] = {
        "shapes": ["a", "b"], "labels": None, "parameters": {}, "matrix": [[0, None], [None, 0]],
        "lower_bounds": [0.0], "certified": True, "uncertified": [], "nearest": [[1], [0]],
        "mean_average_precision": None, "precision_at_1": None, "average_precisions": None,
        "warnings": [], "timings": {},
    }  # fmt: skip
    with pytest.raises(ValidationError, match="finite"):
        isomatch.Dissimilarities.from_json(json.dumps(document))


@pytest.mark.parametrize(("name", "expected"), CLASSES.items())
def test_classes_are_named_without_a_separator(name: str, expected: str) -> None:
    assert class_of(name) == expected


def test_compare(url: str, meshes: list[Path], tmp_path: Path) -> None:
    picture = tmp_path / "matrix.png"
    done = run("compare", *meshes, *QUICK, "--labels-from-names", "--picture", picture, url=url)
    assert done.returncode == 0, done.stderr
    assert picture.read_bytes().startswith(b"\x89PNG")
    for word in ("torus0", "torus1", "mean average precision", "1.0000", "all of them"):
        assert word in done.stdout
    labels = ",".join("aabbcc")
    plain = run("compare", *meshes, *QUICK, "--labels", labels, "--json", url=url)
    assert plain.returncode == 0, plain.stderr
    assert json.loads(plain.stdout)["labels"] == list("aabbcc")
    wrong = run("compare", *meshes, "--labels", "a,b", url=url)
    assert wrong.returncode == 2
    assert "a label for each shape: 6, not 2" in wrong.stderr
    alone = run("compare", meshes[0], url=url)
    assert alone.returncode == 1
    assert "at least 2" in alone.stderr
