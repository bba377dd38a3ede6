"""The lower bound against brute force, for every combination of subproblems."""

import time

import numpy as np
import pytest

from solver.control import Control, iterate
from solver.errors import Cancelled
from solver.labelling import LabellingProblem
from solver.optimisation.dual_decomposition import DualDecomposition, Subproblems
from tests.solver.optimisation.dual_decomposition.decomposed import decomposed
from tests.solver.problems import (
    REGIMES,
    all_solutions,
    explicit_instance,
    metric_instance,
    relabelled,
)


@pytest.mark.parametrize("regime", REGIMES)
@pytest.mark.parametrize(("n", "m"), [(2, 2), (3, 3), (4, 4), (4, 6)])
def test_bound_is_under_the_optimum_and_the_answer_above(regime: str, n: int, m: int) -> None:
    for seed in range(5):
        problem = metric_instance(n, m, seed, **REGIMES[regime])
        optimum = all_solutions(problem)[0][0]
        found = decomposed(problem, iterations=150)
        assert found.lower_bound <= optimum + 1e-12
        assert optimum <= found.value + 1e-12
        assert problem.energy(found.answer) == pytest.approx(found.value)
        assert (np.diff(found.history) >= 0.0).all()
        if found.certified:
            assert found.value == pytest.approx(optimum, rel=1.1e-4)


def test_bound_is_tight_on_square_instances() -> None:
    gaps = [decomposed(metric_instance(8, 8, seed), iterations=1000).gap for seed in range(10)]
    assert np.median(gaps) <= 1e-4
    assert max(gaps) < 0.05


def test_bound_does_not_depend_on_the_numbering() -> None:
    problem = metric_instance(6, 7, 3)
    rng = np.random.default_rng(0)
    again = relabelled(problem, rng.permutation(6), rng.permutation(7))
    first, second = (decomposed(p, iterations=600, gap=0.0) for p in (problem, again))
    assert first.value == pytest.approx(second.value)
    # Ties may be broken otherwise, so the paths differ; where they lead does not.
    assert first.lower_bound == pytest.approx(second.lower_bound, rel=0.02)


def test_the_same_question_has_the_same_answer() -> None:
    problem = metric_instance(7, 9, 1, noise=0.7)
    first, second = (decomposed(problem, iterations=100) for _ in range(2))
    assert first.history == second.history
    assert (first.answer == second.answer).all()


def test_deadline_and_cancellation() -> None:
    problem = metric_instance(8, 8, 0)
    late = decomposed(problem, control=Control(deadline=time.monotonic()))
    assert late.iterations == 0
    assert late.lower_bound == 0.0
    assert problem.energy(late.answer) == pytest.approx(late.value)
    with pytest.raises(Cancelled):
        decomposed(problem, control=Control(is_cancelled=lambda: True))


COMBINATIONS = {
    "source pairs": Subproblems(target_pairs=False),
    "target pairs": Subproblems(source_pairs=False),
    "both": Subproblems(),
    "maxflow": Subproblems(source_pairs=False, target_pairs=False, maxflow=True),
    "source pairs, maxflow": Subproblems(target_pairs=False, maxflow=True),
    "all": Subproblems(maxflow=True),
}


def instances(seed: int) -> list[LabellingProblem]:
    return [
        metric_instance(3, 4, seed, noise=0.8),
        metric_instance(4, 4, seed, noise=0.8, share_of_candidates=0.6),
        metric_instance(4, 4, seed, occlusion_cost=0.4),
        explicit_instance(3, 4, seed),
        explicit_instance(4, 4, seed, occlusion_cost=0.5, share_of_candidates=0.6),
        explicit_instance(4, 3, seed, density=0.1),
        explicit_instance(4, 4, seed, occlusion_cost=np.inf),
    ]


@pytest.mark.parametrize("combination", COMBINATIONS)
def test_every_combination_bounds_the_optimum(combination: str) -> None:
    for seed in range(3):
        for problem in instances(seed):
            optimum = all_solutions(problem)[0][0]
            found = decomposed(problem, COMBINATIONS[combination], iterations=60, gap=1e-7)
            assert found.lower_bound <= optimum + 1e-9
            assert optimum <= found.value + 1e-9
            assert problem.energy(found.answer) == pytest.approx(found.value)
            assert (np.diff(found.history) >= 0.0).all()


@pytest.mark.parametrize("combination", COMBINATIONS)
def test_reparametrised_costs_are_under_every_energy(combination: str) -> None:
    for seed in range(2):
        for problem in instances(seed):
            method = DualDecomposition(problem, None, COMBINATIONS[combination], gap=0.0)
            costs = iterate(method, 25, Control()).state.reparametrised_costs()
            for energy, partners in all_solutions(problem)[:60]:
                chosen = problem.chosen_candidates(np.array(partners))
                used = chosen[chosen >= 0]
                total = costs.constant + costs.unary[used].sum()
                total += 0.5 * costs.pairwise[np.ix_(used, used)].sum()
                total += costs.occlusion[chosen < 0].sum() if (chosen < 0).any() else 0.0
                assert total <= energy + 1e-9 * (1.0 + abs(energy))


def test_nothing_is_lost_where_every_point_is_matched() -> None:
    # No local subproblem has a choice without a candidate, so their costs add up to the energy.
    for problem in (metric_instance(5, 5, 1, noise=0.9), explicit_instance(4, 4, 2, density=1.0)):
        if not problem.must_match_all:
            problem = LabellingProblem.explicit(
                problem.shape, problem.candidates, problem.unary, problem.terms
            )
        method = DualDecomposition(problem, gap=0.0)
        costs = iterate(method, 40, Control()).state.reparametrised_costs()
        for energy, partners in all_solutions(problem)[:100]:
            used = problem.chosen_candidates(np.array(partners))
            total = costs.constant + costs.unary[used].sum()
            total += 0.5 * costs.pairwise[np.ix_(used, used)].sum()
            assert total == pytest.approx(energy, rel=1e-7, abs=1e-7)


def test_more_subproblems_bound_better() -> None:
    gaps: dict[str, list[float]] = {}
    combinations = {
        "maxflow": COMBINATIONS["maxflow"],
        "one side": COMBINATIONS["source pairs"],
        "two sides": COMBINATIONS["both"],
    }
    for seed in range(2):
        problem = metric_instance(8, 10, seed, noise=0.3, occlusion_cost=0.5)
        for name, subproblems in combinations.items():
            found = decomposed(problem, subproblems, iterations=600)
            gaps.setdefault(name, []).append(found.gap)
    mean = {name: float(np.mean(values)) for name, values in gaps.items()}
    assert mean["maxflow"] > mean["one side"] > mean["two sides"]


def test_something_must_know_of_pairwise_costs() -> None:
    with pytest.raises(ValueError, match="linear"):
        Subproblems(source_pairs=False, target_pairs=False)
