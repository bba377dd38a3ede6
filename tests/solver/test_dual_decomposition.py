"""The lower bound against brute force, and its subproblems against enumeration."""

import itertools
import time

import numpy as np
import pytest

from solver.control import Control
from solver.dual_decomposition import dual_decomposition
from solver.dual_decomposition.local import minimise_source_pairs, minimise_target_pairs
from solver.errors import Cancelled
from tests.solver.problems import all_solutions, metric_instance, relabelled
from tests.solver.test_branch_and_bound import REGIMES


@pytest.mark.parametrize("regime", REGIMES)
@pytest.mark.parametrize(("n", "m"), [(2, 2), (3, 3), (4, 4), (4, 6)])
def test_bound_is_under_the_optimum_and_the_answer_above(regime: str, n: int, m: int) -> None:
    for seed in range(5):
        problem = metric_instance(n, m, seed, **REGIMES[regime])
        optimum = all_solutions(problem)[0][0]
        found = dual_decomposition(problem, iterations=150)
        assert found.lower_bound <= optimum + 1e-12
        assert optimum <= found.energy + 1e-12
        assert problem.energy(found.partners) == pytest.approx(found.energy)
        assert (np.diff(found.bounds) >= 0.0).all()
        if found.certified:
            assert found.energy == pytest.approx(optimum, rel=1.1e-4)


def test_bound_is_tight_on_square_instances() -> None:
    gaps = [
        dual_decomposition(metric_instance(8, 8, seed), iterations=1000).gap for seed in range(10)
    ]
    assert np.median(gaps) <= 1e-4
    assert max(gaps) < 0.05


def test_bound_does_not_depend_on_the_numbering() -> None:
    problem = metric_instance(6, 7, 3)
    rng = np.random.default_rng(0)
    again = relabelled(problem, rng.permutation(6), rng.permutation(7))
    first, second = (dual_decomposition(p, iterations=600, gap=0.0) for p in (problem, again))
    assert first.energy == pytest.approx(second.energy)
    # Ties may be broken otherwise, so the paths differ; where they lead does not.
    assert first.lower_bound == pytest.approx(second.lower_bound, rel=0.02)


def test_the_same_question_has_the_same_answer() -> None:
    problem = metric_instance(7, 9, 1, noise=0.7)
    first, second = (dual_decomposition(problem, iterations=100) for _ in range(2))
    assert (first.bounds == second.bounds).all()
    assert (first.partners == second.partners).all()


def test_deadline_and_cancellation() -> None:
    problem = metric_instance(8, 8, 0)
    late = dual_decomposition(problem, control=Control(deadline=time.monotonic()))
    assert late.iterations == 0
    assert late.lower_bound == 0.0
    assert problem.energy(late.partners) == pytest.approx(late.energy)
    with pytest.raises(Cancelled):
        dual_decomposition(problem, control=Control(is_cancelled=lambda: True))


@pytest.mark.parametrize("optional", [False, True])
def test_source_pairs_are_minimised(optional: bool) -> None:
    problem = metric_instance(4, 5, 7, share_of_candidates=0.8)
    rng = np.random.default_rng(7)
    v = problem.n_candidates
    unary = rng.normal(size=(v, 4))
    pairwise = np.triu(rng.normal(size=(v, v)), 1)
    choices = np.full((4, 4), -1, dtype=np.int64)
    total = minimise_source_pairs(
        problem.candidates, problem.first_candidate, unary, pairwise, optional, choices
    )
    x, y = problem.candidates.T
    expected = 0.0
    for first, second in itertools.combinations(range(4), 2):
        options = [-1] if optional else []
        expected += min(
            (unary[a, second] if a >= 0 else 0.0)
            + (unary[b, first] if b >= 0 else 0.0)
            + (pairwise[a, b] if a >= 0 and b >= 0 else 0.0)
            for a in [*np.flatnonzero(x == first), *options]
            for b in [*np.flatnonzero(x == second), *options]
            if a < 0 or b < 0 or y[a] != y[b]
        )
    assert total == pytest.approx(expected)


@pytest.mark.parametrize("optional", [False, True])
def test_target_pairs_are_minimised(optional: bool) -> None:
    problem = metric_instance(5, 5, 8, beta=0.9, share_of_candidates=0.8)
    rng = np.random.default_rng(8)
    v, m = problem.n_candidates, problem.n_targets
    unary = rng.normal(size=(v, m))
    shares = np.triu(rng.normal(size=(v, v)), 1)
    x, y = problem.candidates.T
    order = np.argsort(y, kind="stable").astype(np.int64)
    first = np.searchsorted(y[order], np.arange(m + 1)).astype(np.int64)
    choices = np.full((m, m), -1, dtype=np.int64)
    total = minimise_target_pairs(
        problem.candidates, first, order, problem.source_distances, problem.target_distances,
        problem.beta, unary, shares, optional, choices,
    )  # fmt: skip
    whole = problem.pairwise_matrix()
    expected = 0.0
    for one, two in itertools.combinations(range(m), 2):
        options = [-1] if optional else []
        expected += min(
            (unary[a, two] if a >= 0 else 0.0)
            + (unary[b, one] if b >= 0 else 0.0)
            + (whole[a, b] - shares[min(a, b), max(a, b)] if a >= 0 and b >= 0 else 0.0)
            for a in [*np.flatnonzero(y == one), *options]
            for b in [*np.flatnonzero(y == two), *options]
            if a < 0 or b < 0 or x[a] != x[b]
        )
    assert total == pytest.approx(expected)
