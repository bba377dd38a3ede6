"""Roof duality against enumeration and against a linear program."""

import itertools

import numpy as np
import pytest
from scipy.optimize import linprog

from solver.arrays import FloatArray, IntArray
from solver.optimisation.dual_decomposition import MaxflowSubproblem


def instance(seed: int, sign: int, scale: float = 1.0) -> tuple[IntArray, FloatArray, FloatArray]:
    rng = np.random.default_rng(seed)
    count = int(rng.integers(2, 8))
    pairs = np.array(list(itertools.combinations(range(count), 2)), dtype=np.int64)
    pairs = pairs[rng.random(len(pairs)) < 0.7].reshape(-1, 2)
    costs = rng.normal(size=len(pairs))
    costs = sign * np.abs(costs) if sign else costs
    return pairs, scale * rng.normal(size=count), scale * costs


def least_binary(pairs: IntArray, unary: FloatArray, costs: FloatArray) -> float:
    labels = np.array(list(itertools.product((0.0, 1.0), repeat=len(unary))))
    return float((labels @ unary + (labels[:, pairs[:, 0]] * labels[:, pairs[:, 1]]) @ costs).min())


def relaxed(pairs: IntArray, unary: FloatArray, costs: FloatArray) -> float:
    """Least cost with products z of labels x: z <= x_a, z <= x_b and z >= x_a + x_b - 1."""
    v, e = len(unary), len(costs)
    rows, limits = [], []
    for k, ends in enumerate(pairs):
        for end in ends:
            row = np.zeros(v + e)
            row[v + k], row[end] = 1.0, -1.0
            rows.append(row)
            limits.append(0.0)
        row = np.zeros(v + e)
        row[v + k], row[ends] = -1.0, 1.0
        rows.append(row)
        limits.append(1.0)
    both = np.concatenate([unary, costs])
    found = linprog(both, np.array(rows) if e else None, limits if e else None, bounds=(0.0, 1.0))
    assert found.fun is not None
    return float(found.fun)


@pytest.mark.parametrize("sign", [-1, 0, 1])
def test_minimum_is_that_of_the_relaxation(sign: int) -> None:
    for seed in range(40):
        pairs, unary, costs = instance(seed, sign)
        subproblem = MaxflowSubproblem(pairs[:, 0], pairs[:, 1], unary, costs)
        minimum = subproblem.minimise()
        assert minimum == pytest.approx(relaxed(pairs, unary, costs), abs=1e-7)
        assert minimum <= least_binary(pairs, unary, costs) + 1e-12
        attained = unary @ subproblem.labels + costs @ subproblem.products
        assert attained == pytest.approx(minimum, abs=1e-7)
        assert np.isin(subproblem.labels, [0.0, 0.5, 1.0]).all()


def test_costs_that_only_reward_are_minimised_exactly() -> None:
    for seed in range(40):
        pairs, unary, costs = instance(seed, -1)
        minimum = MaxflowSubproblem(pairs[:, 0], pairs[:, 1], unary, costs).minimise()
        assert minimum == pytest.approx(least_binary(pairs, unary, costs), abs=1e-9)


@pytest.mark.parametrize("scale", [1e-12, 1e-6, 1e6, 1e12])
def test_rounding_never_raises_the_bound(scale: float) -> None:
    for seed in range(20):
        pairs, unary, costs = instance(seed, 0, scale)
        minimum = MaxflowSubproblem(pairs[:, 0], pairs[:, 1], unary, costs).minimise()
        assert minimum <= least_binary(pairs, unary, costs) + 1e-14 * scale
        assert minimum == pytest.approx(
            relaxed(pairs, unary / scale, costs / scale) * scale, rel=1e-6
        )
