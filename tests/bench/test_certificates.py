"""Figures of certificates."""

import math

import pytest

from bench.certificates import Certificate, figures_of


def test_figures() -> None:
    certificates = [
        Certificate("a b", 1.0, 1.0, 0.0, 0.1, 1.0, 20.0),
        Certificate("a c", 2.0, 1.0, 5e-3, 0.3, 1.0, math.nan),
        Certificate("b c", 1.0, 0.9, 0.2, 0.2, 2.0, math.nan),
    ]
    figures = figures_of(certificates)
    assert figures["share_1e4"] == pytest.approx(1 / 3)
    assert figures["share_1e2"] == pytest.approx(2 / 3)
    assert figures["median_seconds"] == 0.2
    assert figures["worst_gap"] == 0.2
    assert figures["answers_of_least_energy"] == pytest.approx(1 / 3)
    assert figures["most_megabytes"] == 20.0
