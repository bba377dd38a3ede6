"""Calibration of probabilities, on cases known in closed form."""

import numpy as np
import pytest

from bench.calibration import BINS, calibration, reliability


def test_perfect_probabilities_have_no_error() -> None:
    right = np.array([True, False, True])
    found = calibration(right.astype(np.float64), right)
    assert found.brier == found.error == 0.0
    assert found.right_of_sure == found.doubted_of_wrong == 1.0
    assert found.right == found.sure == pytest.approx(2 / 3)


def test_always_one_half_has_a_brier_score_of_a_quarter() -> None:
    right = np.array([True, False] * 7)
    found = calibration(np.full(14, 0.5), right)
    assert found.brier == 0.25
    assert found.error == 0.0
    # A coin toss is doubtful.
    assert found.right_of_sure is None
    assert found.doubted_of_wrong == 1.0


def test_figures_of_four_answers() -> None:
    probability = np.array([0.9, 0.95, 0.3, 0.1])
    right = np.array([True, False, True, False])
    found = calibration(probability, right)
    assert found.figures() == pytest.approx(
        {
            "right": 0.5,
            "sure": 0.5,
            "right_of_sure": 0.5,
            "doubted_of_wrong": 0.5,
            "brier": (0.1**2 + 0.95**2 + 0.7**2 + 0.1**2) / 4,
            # bins: 0.1 with none right, 0.3 with all right, 0.925 with half right
            "calibration_error": (0.1 + 0.7 + 0.425) / 3,
        }
    )


def test_shares_of_nothing_are_not_known() -> None:
    found = calibration(np.array([0.2, 0.4]), np.array([True, True]))
    assert found.right_of_sure is None
    assert found.doubted_of_wrong is None


def test_bins_hold_every_answer_once() -> None:
    probability = np.concatenate([np.linspace(0.0, 1.0, 101), [0.2, 0.4]])
    bins = reliability(probability, probability > 0.5)
    assert len(bins) == BINS
    assert sum(one.answers for one in bins) == len(probability)
    assert bins[0].least == 0.0
    assert bins[-1].most == 1.0
    for one in bins:
        assert one.probability is not None
        assert one.least <= one.probability <= one.most


def test_probabilities_drawn_as_they_say_are_calibrated() -> None:
    rng = np.random.default_rng(0)
    probability = rng.random(200_000)
    found = calibration(probability, rng.random(200_000) < probability)
    assert found.error < 0.01
    # The integral of p (1 - p) over [0, 1].
    assert found.brier == pytest.approx(1 / 6, abs=2e-3)
    assert found.right_of_sure == pytest.approx(0.75, abs=0.01)
