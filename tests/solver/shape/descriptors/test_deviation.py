"""The unit of descriptors, against plain NumPy."""

import numpy as np
import pytest

from solver.shape.descriptors import descriptor_deviation


def test_it_is_the_root_mean_square_deviation_from_the_mean() -> None:
    descriptors = np.random.default_rng(0).normal(3.0, 2.0, (20, 4))
    about = descriptors - descriptors.mean(axis=0)
    expected = np.sqrt((about**2).sum(axis=1).mean())
    assert descriptor_deviation(descriptors) == pytest.approx(expected, rel=1e-12)
    assert descriptor_deviation(1e6 + 1e-2 * descriptors) == pytest.approx(1e-2 * expected)


@pytest.mark.parametrize("value", [0.0, 0.3, 1e12])
def test_rounding_noise_is_no_deviation(value: float) -> None:
    noise = np.spacing(value) * np.random.default_rng(0).integers(-2, 3, (8, 3))
    assert descriptor_deviation(value + noise) == 0.0


@pytest.mark.parametrize("shape", [(0, 3), (4, 0)])
def test_it_is_0_of_nothing(shape: tuple[int, int]) -> None:
    assert descriptor_deviation(np.zeros(shape)) == 0.0
