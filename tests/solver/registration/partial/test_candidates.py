"""Labellings of a part keep landmarks, whatever distances say."""

import numpy as np
import pytest

from solver.control import Control
from solver.registration.candidates import NO_LANDMARKS
from solver.registration.partial.candidates import Labellings, labelled_points
from solver.shape import Shape
from tests.solver.shapes import blob


@pytest.mark.parametrize("occlusion_cost", [np.inf, 0.01])
def test_landmarks_are_matched_even_if_they_contradict_all_distances(occlusion_cost: float) -> None:
    shape = Shape(blob(3))
    first = shape.sampling("geodesic", 3).indices
    # Two far points are said to be where two near ones are.
    near = shape.metric("geodesic").distances(first[:1])[0].argsort()[[0, 1]]
    landmarks = first[:2], near
    how = Labellings(6, (1.0,), 5, ((occlusion_cost, 0.0),))
    found = list(labelled_points(shape, shape, 1.0, how, landmarks, Control()))
    assert found
    for here, there in found:
        pairs = set(zip(here.tolist(), there.tolist(), strict=True))
        assert set(zip(*(one.tolist() for one in landmarks), strict=True)) <= pairs


def test_a_shape_is_labelled_with_itself() -> None:
    shape = Shape(blob(3))
    how = Labellings(8, (1.0,), 1, ((np.inf, 0.0),))
    ((here, there),) = labelled_points(shape, shape, 1.0, how, NO_LANDMARKS, Control())
    np.testing.assert_array_equal(here, there)
