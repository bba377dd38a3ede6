"""Distortions against their definitions in section 2."""

import numpy as np
import pytest

from solver.labelling import measure_distortion


def test_distortions_by_hand() -> None:
    source = np.array([[0.0, 1.0, 2.0], [1.0, 0.0, 3.0], [2.0, 3.0, 0.0]])
    target = np.array([[0.0, 1.5, 2.0], [1.5, 0.0, 1.0], [2.0, 1.0, 0.0]])
    found = measure_distortion(
        source, target, np.array([[0.0, 0.0], [1, 0], [0, 0]]), np.array([[0.0, 2], [0, 0], [0, 0]])
    )
    assert found.first_order == pytest.approx(4 + 1)
    assert found.second_order == pytest.approx(2 * (0.25 + 4))  # ordered pairs count twice
    assert found.linf == 2.0
    assert found.gromov_hausdorff == 1.0


def test_nothing_matched_distorts_nothing() -> None:
    found = measure_distortion(np.zeros((0, 0)), np.zeros((0, 0)))
    assert (found.first_order, found.second_order, found.linf) == (None, 0.0, 0.0)
