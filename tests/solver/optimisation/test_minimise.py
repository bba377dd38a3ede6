"""The front solver of one labelling problem: exact on what can be enumerated, proven on more."""

import time

import numpy as np
import pytest

from solver.control import Control, iterate
from solver.errors import Cancelled
from solver.labelling import UNMATCHED, LabellingProblem, Method
from solver.optimisation import minimise
from solver.optimisation.primal import InfeasibleError, IteratedLocalSearch
from tests.solver.problems import (
    REGIMES,
    all_solutions,
    explicit_instance,
    metric_instance,
    relabelled,
)


@pytest.mark.parametrize("regime", REGIMES)
def test_optimum_of_metric_problems(regime: str) -> None:
    for seed in range(4):
        problem = metric_instance(4, 5, seed, **REGIMES[regime])
        found = minimise(problem)
        assert found.value == pytest.approx(all_solutions(problem)[0][0], abs=1e-12)
        assert found.certified


def test_optimum_of_explicit_problems() -> None:
    for seed in range(20):
        problem = explicit_instance(4, 4, seed, occlusion_cost=0.1 * (seed % 4))
        found = minimise(problem)
        assert found.value == pytest.approx(all_solutions(problem)[0][0])
        assert found.certified


def test_hard_problems_of_sixteen_points_are_proven() -> None:
    for seed in range(3):
        problem = metric_instance(16, 16, seed, noise=1.0)
        found = minimise(problem)
        assert found.method is Method.BRANCH_AND_BOUND
        assert found.gap == 0.0
        assert problem.energy(found.answer) == pytest.approx(found.value)


def test_optimum_does_not_depend_on_the_numbering() -> None:
    problem = metric_instance(12, 14, 1, noise=0.6)
    rng = np.random.default_rng(0)
    again = relabelled(problem, rng.permutation(12), rng.permutation(14))
    assert minimise(problem).value == pytest.approx(minimise(again).value)


def test_the_same_question_has_the_same_answer() -> None:
    problem = metric_instance(20, 24, 1, noise=0.7)
    first, second = (minimise(problem, iterations=100) for _ in range(2))
    assert (first.answer == second.answer).all()
    assert first.lower_bound == second.lower_bound


def test_deadline_and_cancellation() -> None:
    problem = metric_instance(20, 20, 0, noise=1.0)
    late = minimise(problem, control=Control(deadline=time.monotonic()))
    assert problem.energy(late.answer) == pytest.approx(late.value)
    assert 0.0 <= late.lower_bound <= late.value
    with pytest.raises(Cancelled):
        minimise(problem, control=Control(is_cancelled=lambda: True))


def test_no_solution_is_said_to_be_none() -> None:
    crowded = LabellingProblem(
        np.array([[0, 0], [1, 0]]), np.zeros(2), np.zeros((2, 2)), np.zeros((2, 2))
    )
    with pytest.raises(InfeasibleError):
        minimise(crowded)


@pytest.mark.parametrize("n", [3, 20])
def test_without_candidates_nothing_is_matched(n: int) -> None:
    nothing = np.zeros((0, 2), dtype=np.int64), np.zeros(0), np.eye(n), np.eye(n)
    found = minimise(LabellingProblem(*nothing, occlusion_cost=0.5))
    assert (found.answer == UNMATCHED).all()
    assert found.value == found.lower_bound == pytest.approx(0.5 * n)
    with pytest.raises(InfeasibleError):
        minimise(LabellingProblem(*nothing))


def test_iterated_local_search_finds_optima_and_never_loses() -> None:
    for seed in range(6):
        for problem in (metric_instance(6, 6, seed, noise=1.0), explicit_instance(5, 5, seed)):
            start = np.arange(problem.n_sources)
            found = iterate(IteratedLocalSearch(problem, start), 20, Control()).state
            assert found.energy <= problem.energy(start)
            assert found.energy == pytest.approx(minimise(problem).value)
            assert problem.energy(found.partners) == pytest.approx(found.energy)


def test_iterated_local_search_leaves_no_point_unmatched_that_must_be() -> None:
    problem = metric_instance(8, 8, 3, share_of_candidates=0.4)
    found = iterate(IteratedLocalSearch(problem, np.arange(8)), 30, Control()).state
    assert UNMATCHED not in found.partners
