"""Meshes that times and errors are measured on."""

from importlib import import_module
from pathlib import Path

import numpy as np
import pytest

from bench.geodesics import has_exact_distances
from solver.mesh import triangle_mesh
from tests.solver.shapes import icosphere

BOOK = "OFF\n5 3 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n0 -1 0\n3 0 1 2\n3 0 1 3\n3 1 0 4\n"
"""Three faces at one edge."""


def refusal(
    name: str,
    options: list[str],
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> str:
    monkeypatch.setattr("sys.argv", [name, *options])
    with pytest.raises(SystemExit, match="2"):
        import_module(f"bench.{name}").main()
    return capsys.readouterr().err


def test_exact_distances_are_those_of_connected_manifolds(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    ball = icosphere(1)
    assert has_exact_distances(ball)
    assert has_exact_distances(triangle_mesh(ball.vertices, ball.faces[5:]))
    two = np.concatenate([ball.vertices, ball.vertices + 3.0])
    faces = np.concatenate([ball.faces, ball.faces + ball.n_vertices])
    assert not has_exact_distances(triangle_mesh(two, faces))
    (tmp_path / "book.off").write_text(BOOK)
    said = refusal("geodesics", ["--mesh", str(tmp_path / "book.off")], monkeypatch, capsys)
    assert "not a connected manifold" in said


@pytest.mark.parametrize("name", ["geodesics", "spectrum"])
def test_no_body_is_smaller_than_the_smallest(
    name: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    said = refusal(name, ["--most", "4999"], monkeypatch, capsys)
    assert "--most: the smallest body has 5000 vertices" in said
