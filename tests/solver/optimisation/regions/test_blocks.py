"""Bounds from blocks of source points: every cost is divided, and no bound exceeds the optimum."""

import sys
from dataclasses import replace

import numpy as np
import pytest

from solver.arrays import FloatArray
from solver.control import UNLIMITED, Control, iterate
from solver.labelling import LabellingProblem
from solver.optimisation.primal import local_search
from solver.optimisation.regions import prove
from solver.optimisation.regions.blocks import BlockSearch, block_problem, blocks_of
from solver.optimisation.regions.message_passing import MetricCosts
from solver.optimisation.regions.region import Region, ascend, whole_region
from tests.solver.problems import REGIMES, all_solutions, distances_of, metric_instance

COMPLETE = [name for name, regime in REGIMES.items() if "occlusion_cost" not in regime]
"""Regimes whose points must all be matched."""


def ascended(problem: LabellingProblem, limit: float) -> Region:
    costs, whole = MetricCosts.of(problem, limit), whole_region(problem)
    return ascend(problem, costs, whole, limit, np.inf, Control())[0]


def symmetric(n: int, seed: int) -> FloatArray:
    random = np.random.default_rng(seed).random((n, n))
    return np.asarray(random + random.T)


def strips(n: int, m: int) -> LabellingProblem:
    """Match random points of two rectangles, which have two symmetries each."""
    random = np.random.default_rng(0)
    source, target = (random.random((count, 2)) * [2.0, 1.0] for count in (n, m))
    pairs = np.argwhere(np.ones((n, m)))
    return LabellingProblem(pairs, np.zeros(n * m), distances_of(source), distances_of(target))


@pytest.mark.parametrize("count", [40, 64, 77, 110])
def test_every_pair_is_divided_among_blocks(count: int) -> None:
    divisions = blocks_of(count)
    sizes = [max(map(len, one.points)) for one in divisions]
    assert sizes == sorted(sizes)
    for division in divisions:
        pairs, times = np.zeros((count, count)), np.zeros(count)
        for points in division.points:
            pairs[np.ix_(points, points)] += division.weights[np.ix_(points, points)]
            times[points] += 1
        assert pairs == pytest.approx(np.ones((count, count)))
        assert (times == division.times).all()


def test_blocks_add_up_to_the_energy() -> None:
    for seed in range(3):
        problem = metric_instance(9, 12, seed, noise=1.0)
        region = ascended(problem, 1e9)
        assert np.abs(region.messages).max() > 0.0
        (division,) = blocks_of(9)
        parts = [block_problem(problem, region, division, k) for k in range(7)]
        assert all(part.non_negative for part, _ in parts)
        for draw in range(5):
            partners = np.random.default_rng(draw).permutation(12)[:9]
            total = sum(
                part.energy(partners[points]) + constant
                for points, (part, constant) in zip(division.points, parts, strict=True)
            )
            assert total == pytest.approx(problem.energy(partners))


def test_bound_is_between_that_of_dual_ascent_and_the_optimum() -> None:
    gains = []
    for seed in range(6):
        problem = metric_instance(7, 8, seed, noise=1.0, unary=0.0)
        optimum = all_solutions(problem)[0][0]
        region = ascended(problem, optimum)
        blocks = BlockSearch(problem, region, Control())
        bound = iterate(blocks, UNLIMITED, Control()).state.bound
        assert region.bound <= bound <= optimum + 1e-9 or bound == np.inf
        gains.append(bound - region.bound)
    assert max(gains) > 0.0


def test_bound_is_at_most_an_optimum_of_zero() -> None:
    for seed in range(8):
        problem = metric_instance(12, 12, seed, noise=0.0, unary=0.0)
        assert prove(problem).value == 0.0
        region = replace(ascended(problem, 1.0), bound=0.0)
        blocks = BlockSearch(problem, region, Control())
        assert iterate(blocks, UNLIMITED, Control()).state.bound <= 0.0


@pytest.mark.parametrize("regime", [name for name in COMPLETE if name != "features only"])
def test_optimum_with_blocks_is_that_of_enumeration(
    monkeypatch: pytest.MonkeyPatch, regime: str
) -> None:
    monkeypatch.setattr(sys.modules[prove.__module__], "_MANY_POINTS", 4)
    for seed in range(3):
        problem = metric_instance(5, 6, seed, **REGIMES[regime])
        found = prove(problem)
        assert found.value == pytest.approx(all_solutions(problem)[0][0], abs=1e-12)
        assert found.lower_bound == found.value


def test_blocks_narrow_the_gap_that_symmetry_leaves() -> None:
    problem = strips(21, 30)
    optimum = prove(problem)
    assert optimum.gap == 0.0
    region = ascended(problem, optimum.value)
    bound = iterate(BlockSearch(problem, region, Control()), UNLIMITED, Control()).state.bound
    assert bound <= optimum.value
    assert optimum.value - bound < 0.8 * (optimum.value - region.bound)


def test_blocks_of_many_points_share_the_work_with_regions(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    problem = strips(40, 56)
    with_blocks = prove(problem, seconds=0.5)
    monkeypatch.setattr(sys.modules[prove.__module__], "_MANY_POINTS", 41)
    without = prove(problem, seconds=0.5)
    assert with_blocks.iterations < without.iterations
    assert with_blocks.lower_bound <= without.value


def test_pairs_count_with_their_weights() -> None:
    for seed in range(4):
        plain = metric_instance(4, 5, seed, noise=1.0)
        problem = replace(plain, weights=symmetric(4, seed))
        partners = np.random.default_rng(seed).permutation(5)[:4]
        d = plain.source_distances - plain.target_distances[np.ix_(partners, partners)]
        expected = plain.unary[plain.chosen_candidates(partners)].sum()
        expected += np.triu(problem.weights * d**2, 1).sum()
        assert problem.energy(partners) == pytest.approx(expected)
        best = all_solutions(problem)[0][0]
        assert prove(problem).value == pytest.approx(best, abs=1e-12)
        improved = local_search(problem, partners)
        assert best - 1e-12 <= problem.energy(improved) <= expected + 1e-12


@pytest.mark.parametrize(
    ("weights", "message"),
    [(np.ones((2, 2)), "every two source points"), (np.eye(3), "> 0")],
)
def test_weights_must_be_those_of_the_points(weights: FloatArray, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        replace(metric_instance(3, 3, 0), weights=weights)
