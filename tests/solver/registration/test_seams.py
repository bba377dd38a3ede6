"""Seams between two candidates: the minimum cut against all choices."""

from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import KDTree

from solver.arrays import BoolArray, FloatArray, IntArray
from solver.registration import seams
from solver.registration.confidence import RIGHT_ERROR
from solver.registration.seams import neighbours_of, takes_second
from solver.registration.surface import SmoothSurface

COUNT = 8


def energy(
    taken: BoolArray,
    worse: FloatArray,
    neighbours: IntArray,
    first: FloatArray,
    second: FloatArray,
) -> float:
    """Energy of labels, term by term as in the module's text."""
    apart = np.linalg.norm(first - second, axis=1)
    total = -worse[taken].sum()
    for i, row in enumerate(neighbours):
        for j in row:
            if taken[i] != taken[j]:
                total += 0.5 * seams._JUMP * 0.5 * (apart[i] + apart[j])
    distance, same = (np.asarray(one) for one in KDTree(second).query(first))
    for i, j in enumerate(same):
        twice = distance[i] < RIGHT_ERROR < apart[i]
        if twice and not taken[i] and taken[j]:
            total += seams._TWICE
    return float(total)


@settings(max_examples=30)
@given(st.integers(0, 10**6))
def test_no_other_choice_costs_less(seed: int) -> None:
    rng = np.random.default_rng(seed)
    worse = rng.normal(scale=3.0, size=COUNT)
    line = np.arange(COUNT)
    neighbours = np.stack([np.maximum(line - 1, 0), np.minimum(line + 1, COUNT - 1)], axis=1)
    first = rng.uniform(size=(COUNT, 3)) * 0.5
    second = np.where(rng.random((COUNT, 1)) < 0.5, first[rng.permutation(COUNT)], first)
    found = takes_second(worse, neighbours, first, second)
    least = min(
        energy(np.array(choice), worse, neighbours, first, second)
        for choice in product((False, True), repeat=COUNT)
    )
    assert energy(found, worse, neighbours, first, second) == pytest.approx(least, abs=0.05)


def test_limbs_that_are_exchanged_are_taken_together() -> None:
    """One of two limbs fits a little better where it is, the other one much worse."""
    limbs = np.repeat([[0.0, 0, 0], [1.0, 0, 0]], 4, axis=0) + np.arange(8)[:, None] % 4 * 0.02
    exchanged = np.roll(limbs, 4, axis=0)
    neighbours = np.array([[j for j in range(8) if j // 4 == i // 4 and j != i] for i in range(8)])
    worse = np.repeat([2.0, -0.5], 4)
    assert takes_second(worse, neighbours, limbs, exchanged).all()
    assert not takes_second(-worse, neighbours, limbs, exchanged).any()


def test_neighbours_are_near_on_the_surface(surface: SmoothSurface) -> None:
    samples = surface.samples.first(100)
    neighbours = neighbours_of(samples)
    assert neighbours.shape == (100, 6)
    assert (neighbours != np.arange(100)[:, None]).all()
    apart = np.linalg.norm(samples.positions[neighbours] - samples.positions[:, None], axis=2)
    assert np.median(apart) < 0.25
