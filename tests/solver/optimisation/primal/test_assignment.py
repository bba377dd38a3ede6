"""Linear assignment over the candidates of a problem."""

import itertools

import numpy as np
import pytest

from solver.labelling import LabellingProblem
from solver.optimisation.primal import InfeasibleError, maximum_matching, solve_lap
from tests.solver.problems import all_solutions, metric_instance


def test_assign_is_the_optimum_without_pairwise_costs() -> None:
    for gamma in (np.inf, 0.3):
        for seed in range(10):
            problem = metric_instance(
                4, 5, seed, beta=0.0, unary=1.0, occlusion_cost=gamma, share_of_candidates=0.6
            )
            found = solve_lap(problem, problem.unary)
            assert problem.energy(found) == pytest.approx(all_solutions(problem)[0][0])


def test_assign_says_when_not_all_can_be_matched() -> None:
    crowded = LabellingProblem(
        np.array([[0, 0], [1, 0]]), np.zeros(2), np.zeros((2, 2)), np.zeros((2, 2))
    )
    with pytest.raises(InfeasibleError):
        solve_lap(crowded, crowded.unary)


@pytest.mark.parametrize("unit", [1e-6, 1e6])
def test_a_maximum_matching_leaves_out_no_point_that_can_be_matched(unit: float) -> None:
    """However much it costs, and however little it costs to leave it out."""
    for seed in range(5):
        problem = metric_instance(4, 4, seed, occlusion_cost=1e-3, share_of_candidates=0.2)
        problem = problem.among(np.flatnonzero(problem.candidates[:, 1] != seed % 4))
        costs = unit * np.random.default_rng(seed).random(problem.n_candidates)
        found = problem.chosen_candidates(maximum_matching(problem, costs))
        sets = [
            list(kept)
            for size in range(5)
            for kept in itertools.combinations(range(problem.n_candidates), size)
            if all(len(set(ends)) == size for ends in problem.candidates[list(kept)].T)
        ]
        best = min(sets, key=lambda kept: (-len(kept), costs[kept].sum()))
        assert found[found >= 0].tolist() == best
