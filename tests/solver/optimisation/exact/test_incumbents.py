"""Correspondences that are known before a search: what is kept, and what is looked at."""

import numpy as np
import pytest

from solver.labelling import UNMATCHED, LabellingProblem
from solver.optimisation import ReparametrisedCosts
from solver.optimisation.exact import Incumbents, dive, energy_of, keep
from solver.optimisation.primal import partners_of
from tests.solver.problems import all_solutions, metric_instance

PROBLEMS = [
    metric_instance(5, 6, 0, noise=0.5),
    metric_instance(5, 6, 1, noise=0.5, occlusion_cost=0.3),
    metric_instance(5, 7, 2, noise=1.0, share_of_candidates=0.6),
]


@pytest.mark.parametrize("problem", PROBLEMS)
def test_what_is_found_cannot_be_improved_at_one_point(problem: LabellingProblem) -> None:
    own, m = ReparametrisedCosts.of(problem), 6
    found = Incumbents.none(m, problem.n_sources)
    dive(found, own, own, problem.first_candidate)
    assert np.isfinite(found.energies).all()
    assert (np.diff(found.energies) >= 0.0).all()
    assert len(np.unique(found.chosen, axis=0)) == m
    partners = [partners_of(problem, chosen) for chosen in found.chosen]
    for energy, one in zip(found.energies, partners, strict=True):
        assert problem.energy(one) == pytest.approx(energy)
    better = [
        np.array(one)
        for energy, one in all_solutions(problem)
        if energy < found.energies[-1] - 1e-9
    ]
    missed = [one for one in better if not any((one == known).all() for known in partners)]
    for one in missed:
        assert all((one != known).sum() > 1 for known in partners)


@pytest.mark.parametrize("problem", PROBLEMS)
def test_beginning_everywhere_finds_no_worse(problem: LabellingProblem) -> None:
    own = ReparametrisedCosts.of(problem)
    few, many = (Incumbents.none(1, problem.n_sources) for _ in range(2))
    dive(few, own, own, problem.first_candidate)
    dive(many, own, own, problem.first_candidate, everywhere=True)
    optimum, _ = all_solutions(problem)[0]
    assert optimum - 1e-9 <= many.energies[0] <= few.energies[0] + 1e-9


def test_only_the_best_are_kept_and_none_twice() -> None:
    found = Incumbents.none(2, 1)
    for energy, candidate in (3.0, 0), (1.0, 1), (1.0, 1), (2.0, 2), (5.0, 3):
        keep(found, energy, np.array([candidate]))
    np.testing.assert_array_equal(found.energies, [1.0, 2.0])
    np.testing.assert_array_equal(found.chosen, [[1], [2]])


def test_candidates_that_exclude_one_another_cost_infinitely_much() -> None:
    own = ReparametrisedCosts.of(PROBLEMS[1])
    nobody = np.full(5, UNMATCHED)
    assert energy_of(own, nobody) == pytest.approx(5 * 0.3)
    same_target = nobody.copy()
    same_target[:2] = 0, 6
    assert energy_of(own, same_target) == np.inf
