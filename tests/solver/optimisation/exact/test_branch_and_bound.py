"""The exact search against plain enumeration."""

import time
from dataclasses import replace

import numpy as np
import pytest

from solver.control import Control, iterate
from solver.errors import Cancelled
from solver.labelling import UNMATCHED
from solver.optimisation import ReparametrisedCosts
from solver.optimisation.dual_decomposition import DualDecomposition
from solver.optimisation.exact import m_best_solutions
from tests.solver.problems import REGIMES, all_solutions, explicit_instance, metric_instance


@pytest.mark.parametrize("regime", REGIMES)
@pytest.mark.parametrize(("n", "m"), [(1, 1), (1, 4), (3, 3), (4, 4), (4, 6), (5, 5)])
def test_m_best_are_those_of_enumeration(regime: str, n: int, m: int) -> None:
    for seed in range(6):
        problem = metric_instance(n, m, seed, **REGIMES[regime])
        expected = all_solutions(problem)[:8]
        found = m_best_solutions(problem, 8)
        assert found.proven
        np.testing.assert_allclose(
            found.energies, [energy for energy, _ in expected], rtol=1e-9, atol=1e-12
        )
        assert len({tuple(row) for row in found.partners}) == len(expected)
        for solution in found:
            assert problem.energy(solution.answer) == pytest.approx(solution.value, abs=1e-12)
            assert solution.lower_bound == found.energies[0]


def test_more_target_than_source_points_in_another_order() -> None:
    problem = metric_instance(4, 7, 5, noise=0.0, unary=0.0)
    found = m_best_solutions(problem)
    assert found.energies[0] == pytest.approx(0.0, abs=1e-18)
    assert UNMATCHED not in found.partners


def test_ten_points_are_proven() -> None:
    for seed in range(10):
        problem = metric_instance(10, 10, seed, noise=0.5)
        best = m_best_solutions(problem)
        eight = m_best_solutions(problem, 8)
        assert best.proven
        assert eight.proven
        assert eight.energies[0] == pytest.approx(best.energies[0])
        assert (np.diff(eight.energies) >= 0.0).all()


def test_the_same_question_has_the_same_answer() -> None:
    problem = metric_instance(9, 9, 4, noise=0.8)
    first, second = m_best_solutions(problem, 5), m_best_solutions(problem, 5)
    assert (first.partners == second.partners).all()
    assert first.nodes == second.nodes


def test_a_node_limit_ends_the_search_without_a_proof() -> None:
    problem = metric_instance(16, 16, 0, noise=2.0, unary=0.0)
    found = m_best_solutions(problem, node_limit=20_000)
    assert not found.proven
    assert problem.energy(found.partners[0]) == pytest.approx(found.energies[0])


def test_a_passed_deadline_ends_the_search() -> None:
    problem = metric_instance(16, 16, 0, noise=2.0, unary=0.0)
    found = m_best_solutions(problem, control=Control(deadline=time.monotonic()))
    assert not found.proven
    assert found.nodes == 0


def test_cancelling_leaves_the_search() -> None:
    problem = metric_instance(16, 16, 0, noise=2.0, unary=0.0)
    with pytest.raises(Cancelled):
        m_best_solutions(problem, control=Control(is_cancelled=lambda: True))


def test_a_problem_without_solution_has_no_best_one() -> None:
    problem = metric_instance(2, 2, 0)
    crowded = type(problem)(
        np.array([[0, 0], [1, 0]]),
        np.zeros(2),
        problem.source_distances,
        problem.target_distances,
    )
    found = m_best_solutions(crowded)
    assert found.proven
    assert len(found.energies) == 0


def test_more_source_than_target_points_are_known_to_have_no_solution() -> None:
    """Without search, which takes exponential time."""
    many, few = metric_instance(40, 40, 0), metric_instance(39, 39, 0)
    pairs = np.argwhere(np.ones((40, 39)))
    crowded = type(many)(pairs, np.zeros(len(pairs)), many.source_distances, few.target_distances)
    found = m_best_solutions(crowded, 3)
    assert found.proven
    assert found.nodes == 0
    assert found.partners.shape == (0, 40)
    assert m_best_solutions(replace(crowded, occlusion_cost=1.0), node_limit=1).partners.size


def test_m_best_of_explicit_problems() -> None:
    for seed in range(20):
        problem = explicit_instance(4, 4, seed, occlusion_cost=0.3 * (seed % 3))
        expected = [energy for energy, _ in all_solutions(problem)[:8]]
        found = m_best_solutions(problem, 8)
        assert found.proven
        np.testing.assert_allclose(found.energies, expected, atol=1e-12)


def test_own_costs_of_either_sign_prune_nothing_that_is_best() -> None:
    for seed in range(60):
        problem = explicit_instance(5, 5, seed, density=1.0, occlusion_cost=np.inf)
        known = np.arange(5)
        found = m_best_solutions(
            problem, known=known, reparametrised=ReparametrisedCosts.of(problem)
        )
        assert found.proven
        assert found.energies[0] == pytest.approx(all_solutions(problem)[0][0])


@pytest.mark.parametrize("gamma", [np.inf, 0.5])
def test_what_is_known_beforehand_changes_no_answer(gamma: float) -> None:
    for seed in range(10):
        problem = metric_instance(5, 6, seed, noise=0.8, occlusion_cost=gamma)
        state = iterate(DualDecomposition(problem), 30, Control()).state
        costs = state.reparametrised_costs()
        plain = m_best_solutions(problem, 5)
        for known in (None, plain.partners[3], plain.partners[0]):
            found = m_best_solutions(problem, 5, known=known, reparametrised=costs)
            assert found.proven
            np.testing.assert_allclose(found.energies, plain.energies)
            assert len(np.unique(found.partners, axis=0)) == 5


def test_costs_of_a_decomposition_prune() -> None:
    problem = metric_instance(11, 11, 0, noise=1.0)
    state = iterate(DualDecomposition(problem), 200, Control()).state
    plain = m_best_solutions(problem)
    found = m_best_solutions(problem, reparametrised=state.reparametrised_costs())
    assert found.proven
    assert found.energies[0] == pytest.approx(plain.energies[0])
    assert found.nodes < 0.1 * plain.nodes


@pytest.mark.parametrize("regime", REGIMES)
def test_an_unfinished_search_keeps_all_candidates_of_better_solutions(regime: str) -> None:
    for seed in range(3):
        problem = metric_instance(5, 6, seed, **REGIMES[regime])
        solutions = all_solutions(problem)
        for m, rounds in (1, 1), (4, 1), (1, 8):
            found = m_best_solutions(problem, m, rounds=rounds, node_limit=0)
            assert found.lower_bound <= solutions[0][0] + 1e-9
            left = set(found.candidates)
            for energy, partners in solutions:
                if energy < found.energies[-1] - 1e-9:
                    chosen = problem.chosen_candidates(np.array(partners))
                    assert set(chosen[chosen >= 0]) <= left


@pytest.mark.parametrize("gamma", [np.inf, 0.3])
def test_rounds_of_ascent_change_no_answer(gamma: float) -> None:
    for seed in range(4):
        problem = metric_instance(7, 9, seed, noise=0.4, occlusion_cost=gamma)
        few, many = (m_best_solutions(problem, 5, rounds=rounds) for rounds in (1, 20))
        assert few.proven
        assert many.proven
        np.testing.assert_allclose(many.energies, few.energies)
        assert many.lower_bound == many.energies[0]
