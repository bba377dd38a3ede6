"""Local search."""

import numpy as np
import pytest

from solver.arrays import IntArray
from solver.labelling import UNMATCHED, LabellingProblem
from solver.optimisation.primal import local_search
from tests.solver.problems import all_solutions, metric_instance


def neighbours(problem: LabellingProblem, partners: IntArray) -> list[IntArray]:
    """Correspondences that differ in one point, or in two that swap their partners."""
    found = []
    n, m = problem.shape
    for x in range(n):
        for y in range(m):
            other = partners.copy()
            taken = np.flatnonzero(partners == y)
            if taken.size:
                other[taken[0]] = partners[x]
            other[x] = y
            found.append(other)
        if not problem.must_match_all:
            other = partners.copy()
            other[x] = UNMATCHED
            found.append(other)
    return found


@pytest.mark.parametrize("gamma", [np.inf, 0.5])
def test_local_search_ends_where_no_neighbour_is_better(gamma: float) -> None:
    for seed in range(10):
        problem = metric_instance(7, 9, seed, noise=1.0, occlusion_cost=gamma)
        start = np.random.default_rng(seed).permutation(9)[:7]
        found = local_search(problem, start)
        energy = problem.energy(found)
        assert energy <= problem.energy(start)
        assert energy <= min(map(problem.energy, neighbours(problem, found))) + 1e-12


def test_local_search_never_goes_below_the_optimum() -> None:
    hits = 0
    for seed in range(20):
        problem = metric_instance(5, 5, seed, noise=0.2)
        optimum = all_solutions(problem)[0][0]
        found = problem.energy(local_search(problem, np.arange(5)))
        assert found >= optimum - 1e-12
        hits += found <= optimum + 1e-9
    assert hits >= 10  # easy instances: most starts lead to the optimum


def test_local_search_matches_what_it_can() -> None:
    problem = metric_instance(5, 5, 0)
    found = local_search(problem, np.full(5, UNMATCHED))
    assert sorted(found) == [0, 1, 2, 3, 4]
