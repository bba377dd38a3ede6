"""The compiled messages against plain NumPy."""

import numpy as np
import pytest

from solver.arrays import FloatArray, IntArray
from solver.labelling import UNMATCHED, LabellingProblem
from solver.optimisation.regions.message_passing import MetricCosts, divide_costs, label_bounds
from solver.optimisation.regions.region import Region, whole_region
from tests.solver.problems import metric_instance

REGIMES = {
    "all pairs": {},
    "few candidates": {"share_of_candidates": 0.25},
    "occlusion": {"occlusion_cost": 0.4},
    "occlusion, few candidates": {"occlusion_cost": 0.4, "share_of_candidates": 0.25},
}


def targets_of(problem: LabellingProblem, region: Region) -> IntArray:
    matched = region.labels != UNMATCHED
    return np.where(matched, problem.candidates[region.labels, 1], UNMATCHED)


def plain_costs(costs: MetricCosts, points: IntArray, targets: IntArray) -> FloatArray:
    """(L, L) pairwise costs of labels."""
    matched = targets != UNMATCHED
    difference = costs.source[np.ix_(points, points)] - costs.target[np.ix_(targets, targets)]
    beta = costs.beta[np.ix_(points, points)]
    found: FloatArray = beta * difference**2 * (matched[:, None] & matched[None])
    return found


def residuals(theta: FloatArray, points: IntArray, messages: FloatArray) -> FloatArray:
    """(L, L) pairwise costs less what was moved to the labels."""
    moved = messages[points]  # [a, b]: to b from its pair with the point of a
    left: FloatArray = theta - moved - moved.T
    return left


@pytest.mark.parametrize("regime", REGIMES)
def test_costs_are_only_moved(regime: str) -> None:
    problem = metric_instance(5, 9, 3, **REGIMES[regime])
    region = whole_region(problem)
    costs, targets = MetricCosts.of(problem, 2.0), targets_of(problem, region)
    unary, messages = region.unary(problem), np.zeros((problem.n_sources, len(region.labels)))
    own, theta = unary.copy(), plain_costs(costs, region.points, targets)
    bound = -np.inf
    for back in (False, True, False):
        divide_costs(costs, region.rows, targets, unary, messages, back, (0, 5))
        np.testing.assert_allclose(unary, own + messages.sum(axis=0), atol=1e-12)
        left = residuals(theta, region.points, messages)
        different = region.points[:, None] != region.points[None]
        assert left[different].min() >= -1e-12
        least = np.minimum.reduceat(unary, region.rows[:-1]).sum()
        assert least >= bound - 1e-12
        bound = least


@pytest.mark.parametrize("regime", REGIMES)
def test_bounds_of_labels(regime: str) -> None:
    problem = metric_instance(4, 8, 1, **REGIMES[regime])
    region = whole_region(problem)
    costs, targets = MetricCosts.of(problem, 2.0), targets_of(problem, region)
    unary, messages = region.unary(problem), np.zeros((problem.n_sources, len(region.labels)))
    divide_costs(costs, region.rows, targets, unary, messages, False, (0, 4))
    left = residuals(plain_costs(costs, region.points, targets), region.points, messages)
    total = left + unary[None]
    expected = unary + sum(
        np.where(region.points == y, 0.0, total[:, region.points == y].min(axis=1))
        for y in range(problem.n_sources)
    )
    found = label_bounds(costs, region.rows, targets, unary, messages, (0, 4))
    np.testing.assert_allclose(found, expected, atol=1e-12)


def test_a_target_point_used_twice_costs_more_than_the_limit() -> None:
    problem = metric_instance(4, 5, 0, beta=0.3)
    costs = MetricCosts.of(problem, 7.0)
    twice = costs.beta * (costs.source - costs.target[0, 0]) ** 2
    assert twice.min() > 7.0
