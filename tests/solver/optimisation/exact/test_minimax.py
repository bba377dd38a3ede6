"""Minimax correspondences and the Gromov-Hausdorff distance against enumeration."""

import itertools
import time

import numpy as np
import pytest

from solver.arrays import FloatArray, IntArray
from solver.control import Control, Status
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


def distortion_by_relations(source: FloatArray, target: FloatArray) -> float:
    """Least distortion of all subsets of pairs that cover both sides."""
    pairs = np.array(list(itertools.product(range(len(source)), range(len(target)))))
    least = np.inf
    for chosen in itertools.product([False, True], repeat=len(pairs)):
        x, y = pairs[np.array(chosen)].T
        if len(set(x)) == len(source) and len(set(y)) == len(target):
            least = min(least, distortion(source, target, np.stack([x, y], axis=1)))
    return least


@pytest.mark.parametrize(("n", "m"), [(2, 3), (3, 3), (3, 4), (4, 3)])
def test_gromov_hausdorff_distance_is_the_least_of_all_relations(n: int, m: int) -> None:
    source, target = spaces(n, m, 11)
    assert gromov_hausdorff_distance(source, target).value == distortion_by_relations(
        source, target
    )


def simplex(n: int, edge: float = 1.0) -> FloatArray:
    return edge * (np.ones((n, n)) - np.eye(n))


@pytest.mark.parametrize(("n", "m"), [(12, 11), (11, 12), (12, 5), (30, 29)])
def test_simplices_of_different_sizes_are_half_an_edge_apart(n: int, m: int) -> None:
    found = gromov_hausdorff_distance(simplex(n), simplex(m))
    assert (found.value, found.certified) == (1.0, True)


def test_simplices_of_different_edges() -> None:
    # max(edge of the larger one, difference of the edges) if there are more points, as two merge.
    assert gromov_hausdorff_distance(simplex(12, 2.0), simplex(12, 5.0)).value == 3.0
    assert gromov_hausdorff_distance(simplex(9, 2.0), simplex(12, 5.0)).value == 5.0
    assert gromov_hausdorff_distance(simplex(12, 2.0), simplex(9, 5.0)).value == 3.0
    assert minimax_correspondence(simplex(9, 2.0), simplex(12, 5.0)).value == 3.0


def test_a_scaled_interval_differs_by_its_diameter() -> None:
    points = np.sort(np.random.default_rng(5).random(12))
    interval = np.abs(points[:, None] - points)
    found = gromov_hausdorff_distance(interval, 1.5 * interval)
    assert found.value == pytest.approx(0.5 * interval.max())
    assert found.certified


def test_a_cycle_of_equal_arcs_and_its_half() -> None:
    # The cycle of 2n points covers that of n points, and one step of it is lost where two merge.
    steps = np.arange(12)
    around = np.abs(steps[:, None] - steps)
    cycle = np.minimum(around, 12 - around).astype(float)
    found = gromov_hausdorff_distance(cycle, cycle[::2, ::2])
    assert (found.value, found.certified) == (1.0, True)


def bounds_by_invariants(source: FloatArray, target: FloatArray) -> list[float]:
    """Lower bounds of the distortion (Mémoli 2012), each by its own formula."""
    greatest = [space.max(axis=1) for space in (source, target)]
    sets = np.array([[hausdorff(one, other) for other in target] for one in source])
    return [
        abs(source.max() - target.max()),
        hausdorff(greatest[0], greatest[1]),
        hausdorff(source.ravel(), target.ravel()),
        float(max(sets.min(axis=1).max(), sets.min(axis=0).max())),
    ]


def hausdorff(one: FloatArray, other: FloatArray) -> float:
    apart = np.abs(one[:, None] - other)
    return float(max(apart.min(axis=1).max(), apart.min(axis=0).max()))


@pytest.mark.parametrize(("n", "m", "seed"), [(10, 12, 0), (12, 12, 1), (30, 30, 2)])
def test_lower_bound_is_no_less_than_those_of_invariants(n: int, m: int, seed: int) -> None:
    source, target = spaces(n, m, seed)
    found = gromov_hausdorff_distance(source, target, seconds=0.2)
    assert max(bounds_by_invariants(source, target)) <= found.lower_bound <= found.value
    assert found.value == pytest.approx(distortion(source, target, found.answer))
    assert set(found.answer[:, 0]) == set(range(n))
    assert set(found.answer[:, 1]) == set(range(m))


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


def test_twelve_points_are_proven() -> None:
    for seed in range(5):
        source, target = spaces(12, 12, seed)
        whole = gromov_hausdorff_distance(source, target)
        one_to_one = minimax_correspondence(source, target)
        assert whole.gap == 0.0
        assert one_to_one.gap == 0.0
        assert whole.value <= one_to_one.value
        assert gromov_hausdorff_distance(target, source).value == whole.value


def test_limits_leave_a_bound() -> None:
    source, target = spaces(9, 12, 0)
    early = minimax_correspondence(source, target, control=Control(deadline=time.monotonic()))
    assert early.lower_bound <= minimax_correspondence(source, target).value
    assert early.value == pytest.approx(distortion(source, target, early.answer))
    little = minimax_correspondence(*spaces(30, 45, 0), seconds=0.05)
    assert little.status is Status.ITERATIONS
    assert 0.0 < little.lower_bound < little.value
    more = minimax_correspondence(*spaces(30, 45, 0), seconds=0.5)
    assert little.lower_bound <= more.lower_bound <= more.value <= little.value
    with pytest.raises(Cancelled):
        minimax_correspondence(source, target, control=Control(is_cancelled=lambda: True))


def test_what_cannot_be_matched_is_refused() -> None:
    source, target = spaces(3, 2, 0)
    with pytest.raises(ValueError, match="its own"):
        minimax_correspondence(source, target)
    many = np.zeros((63, 63))
    with pytest.raises(ValueError, match="more than 62"):
        minimax_correspondence(source, many)
    with pytest.raises(ValueError, match="needs a point"):
        gromov_hausdorff_distance(source, np.zeros((0, 0)))
