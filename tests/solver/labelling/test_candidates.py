"""Pairs that agree with landmarks."""

import numpy as np

from solver.labelling import pairs_with_landmarks


def test_a_landmark_has_one_partner_and_nobody_else_has_it() -> None:
    np.testing.assert_array_equal(
        pairs_with_landmarks(3, 4, 2),
        [[True, False, False, False], [False, True, False, False], [False, False, True, True]],
    )


def test_without_landmarks_all_pairs_are_allowed() -> None:
    assert pairs_with_landmarks(2, 3, 0).all()
