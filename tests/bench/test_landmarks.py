"""Bench of landmarks: which shapes are templates of which, and how errors are judged."""

from pathlib import Path

import numpy as np
import pytest

from bench.collection import KnownShape
from bench.landmarks import CarriedPair, from_classes, print_fit, summary
from solver.shape import Shape
from tests.solver import shapes

MESH = shapes.blob(1)


def known(name: str) -> KnownShape:
    return KnownShape(name, name[0], Shape(MESH), np.arange(4), None)


def test_a_specimen_is_none_of_its_templates(tmp_path: Path) -> None:
    every = [known(name) for name in ("a1", "a2", "a3", "b1", "b2")]
    tasks = list(from_classes(every, 2))
    assert [specimen.name for _, specimen in tasks] == ["a1", "a2", "a3"]
    for templates, specimen in tasks:
        assert {one.name for one in (*templates, specimen)} == {"a1", "a2", "a3"}


def judged(errors: list[float], trips: list[float], sure: list[float]) -> CarriedPair:
    values = (np.array(one) for one in (errors, trips, trips, [np.nan] * len(errors), sure))
    return CarriedPair("a", 0.9, *values)


def test_measures_that_separate_have_an_area_of_one(capsys: pytest.CaptureFixture[str]) -> None:
    good = judged([0.01, 0.02, 0.2], [0.001, 0.002, 0.1], [0.9, 0.8, 0.1])
    worse = judged([0.06, 0.0], [0.05, 0.003], [0.2, 0.7])
    found = summary([good, worse])
    assert found["auc_round_trip"] == found["auc_confidence"] == 1.0
    assert found["auc_match"] == 0.5
    assert found["auc_spread"] is None
    assert found["within_0_05"] == pytest.approx(3 / 5)
    print_fit([good, worse])
    assert "'round trip': -" in capsys.readouterr().out
