"""Bounds of dual ascent against plain enumeration."""

from itertools import combinations, pairwise

import numpy as np
import pytest

from solver.arrays import FloatArray, IntArray
from solver.control import Control, iterate
from solver.labelling import UNMATCHED, LabellingProblem
from solver.optimisation import ReparametrisedCosts
from solver.optimisation.exact import AscentState, DualAscent
from tests.solver.problems import REGIMES, all_solutions, explicit_instance, metric_instance

PROBLEMS = [
    *(metric_instance(4, 5, seed, **REGIMES[regime]) for regime in REGIMES for seed in range(2)),
    *(explicit_instance(4, 4, seed, occlusion_cost=0.2 * (seed % 3)) for seed in range(6)),
    *(explicit_instance(4, 5, seed, occlusion_cost=np.inf) for seed in range(3)),
]


def ascended(problem: LabellingProblem, rounds: int, limit: float = np.inf) -> AscentState:
    ascent = DualAscent(ReparametrisedCosts.of(problem), problem.first_candidate, limit)
    return iterate(ascent, rounds, Control()).state


def cost(costs: ReparametrisedCosts, problem: LabellingProblem, partners: tuple[int, ...]) -> float:
    """Cost of a correspondence, added up part by part."""
    chosen = problem.chosen_candidates(np.array(partners))
    used = chosen[chosen >= 0]
    total = costs.constant + costs.unary[used].sum() + costs.occlusion[chosen < 0].sum()
    pairs = costs.pairwise[np.ix_(used, used)]
    return float(total + np.triu(pairs, 1).sum())


@pytest.mark.parametrize("problem", PROBLEMS)
def test_the_bound_is_below_the_optimum_and_never_falls(problem: LabellingProblem) -> None:
    optimum = all_solutions(problem)[0][0]
    bounds = [ascended(problem, rounds).bound for rounds in range(7)]
    assert bounds[-1] <= optimum + 1e-9
    assert (np.diff(bounds) >= -1e-9).all()


@pytest.mark.parametrize("problem", PROBLEMS)
def test_no_correspondence_becomes_dearer_and_all_cost_the_bound(problem: LabellingProblem) -> None:
    ascent = ascended(problem, 3)
    costs = ascent.costs()
    finite = costs.pairwise[np.isfinite(costs.pairwise)]
    assert finite.min() >= -1e-9
    for energy, partners in all_solutions(problem):
        divided = cost(costs, problem, partners)
        assert ascent.bound - 1e-9 <= divided <= energy + 1e-9
        if UNMATCHED not in partners:
            assert divided == pytest.approx(energy, abs=1e-9)


def divided_in_turn(costs: ReparametrisedCosts, rows: IntArray) -> FloatArray:
    """(V,) costs of candidates after a round, there and back, written as it is read."""
    n, unary = len(rows) - 1, costs.unary.copy()
    theta = np.minimum(costs.pairwise, 1e9)
    messages = np.zeros((n, len(unary)))
    points = [slice(*ends) for ends in pairwise(rows)]
    for order in (range(n), range(n - 1, -1, -1)):
        for x, y in combinations(order, 2):
            a, b = points[x], points[y]
            f, g = unary[a] - messages[y, a], unary[b] - messages[x, b]
            half = 0.5 * (f + (theta[a, b] + g).min(axis=1))
            second = g + (theta[b, a] + f - half).min(axis=1)
            first = f + (theta[a, b] + g - second).min(axis=1)
            messages[y, a], messages[x, b] = messages[y, a] + first - unary[a], second - g
            unary[a], unary[b] = first, second
    return unary


@pytest.mark.parametrize("sizes", [(5, 6), (6, 9), (7, 13), (4, 4)])
def test_a_round_is_what_it_says(sizes: tuple[int, int]) -> None:
    problem = metric_instance(*sizes, 4, noise=0.7)
    expected = divided_in_turn(ReparametrisedCosts.of(problem), problem.first_candidate)
    np.testing.assert_allclose(ascended(problem, 1).costs().unary, expected, atol=1e-12)


@pytest.mark.parametrize("problem", PROBLEMS)
def test_what_is_dropped_is_used_by_nothing_better(problem: LabellingProblem) -> None:
    solutions = all_solutions(problem)
    limit = solutions[min(3, len(solutions) - 1)][0] + 1e-6
    ascent = ascended(problem, 20, limit)
    costs, kept = ascent.costs(), ascent.kept
    rows = np.searchsorted(problem.candidates[kept, 0], np.arange(problem.n_sources + 1))
    left = set(kept[costs.promising(rows, limit)])
    for energy, partners in solutions:
        if energy < limit - 1e-9:
            chosen = problem.chosen_candidates(np.array(partners))
            assert set(chosen[chosen >= 0]) <= left
            # Nor is it dropped that a point stays unmatched.
            assert np.isfinite(costs.occlusion[chosen < 0]).all()


def test_a_limit_that_nothing_is_below_leaves_nothing() -> None:
    problem = metric_instance(5, 6, 0, noise=0.3)
    optimum = all_solutions(problem)[0][0]
    ascent = ascended(problem, 200, 0.5 * optimum)
    assert ascent.exhausted
    assert len(ascent.kept) < problem.n_candidates


def test_a_point_without_candidates_is_infeasible() -> None:
    problem = metric_instance(3, 3, 0)
    kept = np.flatnonzero(problem.candidates[:, 0] != 1)
    alone = problem.among(kept)
    assert ascended(alone, 0).exhausted
    assert ascended(alone, 2).bound == np.inf


def test_trees_are_bounded_exactly() -> None:
    """Without constraints between targets and with pairs that form a chain, nothing is lost."""
    rng = np.random.default_rng(0)
    n, k = 5, 3
    unary, rows = rng.random(n * k), np.arange(0, n * k + 1, k)
    pairwise = np.zeros((n * k, n * k))
    for x in range(n - 1):
        block = rng.random((k, k))
        pairwise[x * k : (x + 1) * k, (x + 1) * k : (x + 2) * k] = block
        pairwise[(x + 1) * k : (x + 2) * k, x * k : (x + 1) * k] = block.T
    ahead = np.zeros(k)  # dynamic programming, from the last point on
    for x in range(n - 1, 0, -1):
        own = unary[x * k : (x + 1) * k] + ahead
        ahead = (pairwise[(x - 1) * k : x * k, x * k : (x + 1) * k] + own).min(axis=1)
    optimum = float((unary[:k] + ahead).min())
    costs = ReparametrisedCosts(0.0, unary, pairwise, np.full(n, np.inf), scale=1.0)
    ascent = DualAscent(costs, rows)
    assert iterate(ascent, 100, Control()).state.bound == pytest.approx(optimum, abs=1e-6)
