"""Minimax correspondences and the Gromov-Hausdorff distance against enumeration."""

import itertools
import time

import numpy as np
import pytest

from solver.arrays import FloatArray, IntArray
from solver.control import Control
from solver.errors import Cancelled
from solver.optimisation.exact import gromov_hausdorff_distance, minimax_correspondence
from tests.solver.problems import distances_of


def spaces(n: int, m: int, seed: int) -> tuple[FloatArray, FloatArray]:
    rng = np.random.default_rng(seed)
    return distances_of(rng.normal(size=(n, 3))), distances_of(rng.normal(size=(m, 3)))


def distortion(source: FloatArray, target: FloatArray, pairs: IntArray) -> float:
    x, y = pairs.T
    return float(np.abs(source[np.ix_(x, x)] - target[np.ix_(y, y)]).max())


def distortion_by_maps(source: FloatArray, target: FloatArray) -> float:
    """Least distortion of a map X -> Y and a map Y -> X taken together: the definition."""
    n, m = len(source), len(target)
    least = np.inf
    for there in itertools.product(range(m), repeat=n):
        for back in itertools.product(range(n), repeat=m):
            pairs = [*enumerate(there), *((x, y) for y, x in enumerate(back))]
            least = min(least, distortion(source, target, np.array(pairs)))
    return least


@pytest.mark.parametrize(("n", "m"), [(1, 1), (1, 4), (3, 2), (3, 3), (2, 4)])
def test_gromov_hausdorff_distance_is_that_of_all_maps(n: int, m: int) -> None:
    for seed in range(6):
        source, target = spaces(n, m, seed)
        found = gromov_hausdorff_distance(source, target)
        assert found.gap == 0.0
        assert found.value == pytest.approx(distortion_by_maps(source, target))
        assert found.value == pytest.approx(distortion(source, target, found.answer))
        assert set(found.answer[:, 0]) == set(range(n))
        assert set(found.answer[:, 1]) == set(range(m))
        assert max(n, m) <= len(found.answer) < n + m


@pytest.mark.parametrize(("n", "m"), [(1, 3), (3, 3), (4, 6), (5, 5)])
def test_minimax_is_the_least_of_all_injections(n: int, m: int) -> None:
    for seed in range(6):
        source, target = spaces(n, m, seed)
        found = minimax_correspondence(source, target)
        expected = min(
            distortion(source, target, np.stack([np.arange(n), np.array(images)], axis=1))
            for images in itertools.permutations(range(m), n)
        )
        assert found.gap == 0.0
        assert found.value == pytest.approx(expected)
        assert (found.answer[:, 0] == np.arange(n)).all()
        assert len(set(found.answer[:, 1])) == n


def test_distance_is_a_metric_between_spaces() -> None:
    x, y = spaces(5, 6, 1)
    z, _ = spaces(4, 1, 2)
    between = {
        pair: gromov_hausdorff_distance(*spaces_of).value
        for pair, spaces_of in {"xy": (x, y), "yz": (y, z), "xz": (x, z), "yx": (y, x)}.items()
    }
    assert between["xy"] == pytest.approx(between["yx"])
    assert between["xz"] <= between["xy"] + between["yz"] + 1e-12
    shuffled = np.random.default_rng(0).permutation(5)
    assert gromov_hausdorff_distance(x, x[np.ix_(shuffled, shuffled)]).value == 0.0


def test_a_point_is_half_a_diameter_away() -> None:
    x, _ = spaces(6, 1, 3)
    assert gromov_hausdorff_distance(x, np.zeros((1, 1))).value == pytest.approx(x.max())


def test_eight_points_are_proven() -> None:
    for seed in range(5):
        source, target = spaces(8, 8, seed)
        whole = gromov_hausdorff_distance(source, target)
        one_to_one = minimax_correspondence(source, target)
        assert whole.gap == 0.0
        assert one_to_one.gap == 0.0
        assert whole.value <= one_to_one.value


def test_limits_leave_a_bound() -> None:
    source, target = spaces(9, 12, 0)
    early = minimax_correspondence(source, target, control=Control(deadline=time.monotonic()))
    assert early.lower_bound <= minimax_correspondence(source, target).value
    assert early.value == pytest.approx(distortion(source, target, early.answer))
    with pytest.raises(Cancelled):
        minimax_correspondence(source, target, control=Control(is_cancelled=lambda: True))


def test_what_cannot_be_matched_is_refused() -> None:
    source, target = spaces(3, 2, 0)
    with pytest.raises(ValueError, match="its own"):
        minimax_correspondence(source, target)
    with pytest.raises(ValueError, match="needs a point"):
        gromov_hausdorff_distance(source, np.zeros((0, 0)))
