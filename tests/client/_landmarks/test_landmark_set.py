"""Landmarks as users make them."""

from typing import Any

import numpy as np
import pytest
from isomatch import LandmarkSet


def test_positions_may_be_lists() -> None:
    given: Any = [[0, 0, 1], [np.nan] * 3]
    made = LandmarkSet(("a", "b"), given)
    assert made.positions.dtype == np.float64
    np.testing.assert_array_equal(made.present, [True, False])
    with pytest.raises(ValueError, match=r"positions of shape \(1, 3\), not \(2, 3\)"):
        LandmarkSet(("a",), given)
