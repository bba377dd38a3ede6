"""Folders without anything to measure end an experiment at once, with a message."""

from importlib import import_module
from pathlib import Path

import numpy as np
import pytest

from bench.collection import KnownShape, pairs_of_known_truth
from bench.correspondence import named_pairs
from solver.shape import Shape
from tests.solver.shapes import icosphere

EXPERIMENTS = (
    "certificates",
    "clouds",
    "consistency",
    "correspondence",
    "dense",
    "descriptors",
    "figure3",
    "figure4",
    "invariance",
    "landmarks",
    "minimax",
    "pair",
    "partial",
    "peer --large",
    "points",
    "refinement",
    "robust",
    "service",
    "strays",
    "templates",
    "third_order",
    "transfer",
)


@pytest.mark.parametrize("experiment", EXPERIMENTS)
def test_a_folder_without_pairs(
    experiment: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    name, *options = experiment.split()
    monkeypatch.setattr("sys.argv", [name, "--data", str(tmp_path), *options])
    with pytest.raises(SystemExit, match="2"):
        import_module(f"bench.{name}").main()
    assert "nothing to measure: --data is a folder of meshes" in capsys.readouterr().err


@pytest.mark.parametrize("name", ["figure6", "unseen"])
def test_a_folder_without_shapes_of_the_classes_is_refused_at_once(
    name: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    (tmp_path / "other0.off").write_text("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n")
    monkeypatch.setattr("sys.argv", [name, "--data", str(tmp_path)])
    with pytest.raises(SystemExit, match="2"):
        import_module(f"bench.{name}").main()
    assert "--data has no shape with known points of michael, gorilla" in capsys.readouterr().err


def known(name: str, truth: list[int] | None) -> KnownShape:
    places = None if truth is None else np.array(truth)
    return KnownShape(name, "one", Shape(icosphere(0)), places, None)


def test_pairs_share_a_known_point() -> None:
    whole, head, foot, unknown = (
        known("whole", [0, 1]),
        known("head", [0, -1]),
        known("foot", [-1, 0]),
        known("unknown", None),
    )
    pairs = pairs_of_known_truth([whole, head, foot, unknown])
    assert [(a.name, b.name) for a, b in pairs] == [("whole", "head"), ("whole", "foot")]


def test_named_pairs_are_those_of_known_shapes(tmp_path: Path) -> None:
    shapes = [known("a", [0]), known("b", [1]), known("c", None)]
    (tmp_path / "pairs").write_text("b a\n\n")
    assert named_pairs(tmp_path / "pairs", shapes) == [(shapes[1], shapes[0])]
    (tmp_path / "pairs").write_text("a c\n")
    with pytest.raises(KeyError, match="c"):
        named_pairs(tmp_path / "pairs", shapes)
