"""Cycle errors of maps whose compositions are known."""

from collections.abc import ItemsView
from itertools import combinations

import numpy as np
import pytest

from solver.arrays import FloatArray, IntArray
from solver.consistency import CollectionMaps, Consistency, CycleErrors, cycle_errors

POINTS, SHAPES = 60, 4
RNG = np.random.default_rng(5)


def shuffled() -> tuple[list[FloatArray], dict[tuple[int, int], IntArray]]:
    """The same points in other orders, and the maps between them."""
    places = RNG.standard_normal((POINTS, 3))
    orders = [RNG.permutation(POINTS) for _ in range(SHAPES)]
    images = {
        (i, j): np.argsort(orders[j])[orders[i]]
        for i in range(SHAPES)
        for j in range(SHAPES)
        if i != j
    }
    return [places[order] for order in orders], images


def of(positions: list[FloatArray], images: dict[tuple[int, int], IntArray]) -> CollectionMaps:
    return CollectionMaps(positions, images, dict.fromkeys(images, 1.0))


def test_exact_maps_have_no_cycle_error() -> None:
    positions, images = shuffled()
    maps = of(positions, images)
    samples = [np.arange(POINTS)] * SHAPES
    errors = cycle_errors(maps, samples)
    assert len(errors.triples) == 12  # six pairs, two third shapes each
    assert set(errors.triples.values()) == {0.0}
    assert errors.mean == errors.of_pair((0, 1)) == errors.of_shape(3) == 0.0
    np.testing.assert_array_equal(maps.along((0, 2, 1, 3)), images[0, 3])
    np.testing.assert_array_equal(maps.along((0, 1), np.array([7])), images[0, 1][[7]])


def test_a_wrong_map_has_the_greatest_error_and_shapes_without_it_none() -> None:
    positions, images = shuffled()
    images[0, 1] = RNG.permutation(POINTS)
    images[1, 0] = np.argsort(images[0, 1])
    errors = cycle_errors(of(positions, images), [np.arange(POINTS)] * SHAPES)
    direct = np.linalg.norm(
        positions[1][images[0, 1]] - positions[1][images[2, 1][images[0, 2]]], axis=1
    )
    assert errors.of_pair((0, 1)) == pytest.approx(direct.mean())
    assert errors.of_pair((2, 3)) == 0.0
    # By way of shape 1 the map is wrong, by way of shape 3 it is right.
    assert errors.triples[0, 2, 1] > 0.0
    assert errors.of_pair((0, 2)) == 0.0
    of_wrong, of_others = errors.of_shape(0), errors.of_shape(2)
    assert of_wrong is not None
    assert of_others is not None
    assert of_wrong > of_others > 0.0


def test_of_four_shapes_only_the_wrong_map_is_doubtful() -> None:
    positions, images = shuffled()
    images[0, 1] = RNG.permutation(POINTS)
    images[1, 0] = np.argsort(images[0, 1])
    maps = of(positions, images)
    errors = cycle_errors(maps, [np.arange(POINTS)] * SHAPES)
    found = Consistency(maps, {}, errors, errors)
    assert found.doubtful_pairs() == ((0, 1),)
    assert found.doubtful_shapes() == ()


def test_of_four_shapes_one_whose_maps_are_all_wrong_is_doubtful() -> None:
    positions, images = shuffled()
    for place in (1, 2, 3):
        images[0, place] = RNG.permutation(POINTS)
        images[place, 0] = np.argsort(images[0, place])
    maps = of(positions, images)
    errors = cycle_errors(maps, [np.arange(POINTS)] * SHAPES)
    found = Consistency(maps, {}, errors, errors)
    assert found.doubtful_pairs() == ((0, 1), (0, 2), (0, 3))
    assert found.doubtful_shapes() == (0,)


def test_pairs_that_are_not_known_are_left_out() -> None:
    positions, images = shuffled()
    for pair in ((0, 1), (1, 0), (0, 2), (2, 0), (0, 3), (3, 0)):
        del images[pair]
    errors = cycle_errors(of(positions, images), [np.arange(POINTS)] * SHAPES)
    assert set(errors.triples) == {(1, 2, 3), (1, 3, 2), (2, 3, 1)}
    assert errors.of_pair((0, 1)) is None
    assert errors.of_shape(0) is None


class Counted(dict[tuple[int, int, int], float]):
    """Cycle errors that count how often all of them are read."""

    scans = 0

    # The class of a dictionary's own views has no name.
    def items(self) -> ItemsView[tuple[int, int, int], float]:  # type: ignore[override]
        self.scans += 1
        return super().items()


def test_errors_of_many_pairs_and_shapes_are_grouped_once() -> None:
    """There are N³/2 of them: a scan for each pair would take O(N⁵)."""
    count = 8
    triples = Counted(
        ((i, j, k), float(RNG.random()))
        for i, j in combinations(range(count), 2)
        for k in range(count)
        if k not in (i, j)
    )
    errors = CycleErrors(triples)
    for i, j in combinations(range(count), 2):
        by_third = [error for key, error in sorted(triples.items()) if key[:2] == (i, j)]
        triples.scans -= 1
        assert errors.of_pair((j, i)) == np.quantile(by_third, 0.5, method="lower")
    for place in range(count):
        own = [error for key, error in sorted(triples.items()) if place in key]
        triples.scans -= 1
        assert errors.of_shape(place) == pytest.approx(np.mean(own))
    assert triples.scans <= 2
