"""Figures of certificates."""

import math
from pathlib import Path

import pytest

from bench.certificates import Certificate, figures_of, instance_certificate


def test_figures() -> None:
    certificates = [
        Certificate("a b", 4, 6, 24, 1.0, 1.0, 0.0, 0.1, 1.0, 20.0),
        Certificate("a c", 6, 4, 24, 2.0, 1.0, 5e-3, 0.3, 1.0, None),
        Certificate("b c", 4, 4, 16, 1.0, 0.9, 0.2, 0.2, 2.0, None),
    ]
    figures = figures_of(certificates)
    assert figures["share_1e4"] == pytest.approx(1 / 3)
    assert figures["share_1e2"] == pytest.approx(2 / 3)
    assert figures["median_seconds"] == 0.2
    assert figures["worst_gap"] == 0.2
    assert figures["answers_of_least_energy"] == pytest.approx(1 / 3)
    assert figures["most_megabytes"] == 20.0
    assert (figures["peak_megabytes"] or 0.0) > 20.0
    assert figures["median_candidates"] == 24
    # 6! / 2! = 360 injective maps of four points into six; of six into four as many partial ones.
    assert figures["median_digits"] == pytest.approx(math.log10(360))


def test_an_instance_is_solved_over_all_its_assignments(tmp_path: Path) -> None:
    path = tmp_path / "small.dd"
    path.write_text("p 2 3 4 1\na 0 0 0 -1\na 1 0 1 -2\na 2 1 1 -1\na 3 1 2 -1\ne 0 2 -3\n")
    found = instance_certificate(path, 10.0, memory=True)
    assert (found.points, found.target_points, found.candidates) == (2, 3, 4)
    assert (found.answer, found.energy, found.gap) == (-5.0, -5.0, 0.0)
    assert found.megabytes is not None
    assert found.megabytes > 0.0
