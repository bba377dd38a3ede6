"""Fusion against enumeration of all mixtures."""

import itertools

import numpy as np
import pytest

from solver.arrays import IntArray
from solver.labelling import UNMATCHED, LabellingProblem
from solver.optimisation.primal import fuse
from tests.solver.problems import explicit_instance, metric_instance


def best_mixture(problem: LabellingProblem, first: IntArray, second: IntArray) -> float:
    energies = []
    for sides in itertools.product((False, True), repeat=len(first)):
        partners = np.where(sides, second, first)
        used = partners[partners != UNMATCHED]
        if len(set(used.tolist())) == len(used):
            energies.append(problem.energy(partners))
    return min(energies)


def random_partners(n: int, m: int, rng: np.random.Generator, optional: bool) -> IntArray:
    partners = rng.permutation(m)[:n].astype(np.int64)
    if optional:
        partners[rng.random(n) < 0.3] = UNMATCHED
    return partners


def test_where_all_points_are_taken_the_fusion_is_the_best_mixture() -> None:
    for seed in range(30):
        rng = np.random.default_rng(seed)
        for problem in (
            metric_instance(8, 8, seed, noise=1.0),
            explicit_instance(8, 8, seed, density=0.1),
        ):
            first, second = (random_partners(8, 8, rng, optional=False) for _ in range(2))
            found = fuse(problem, first, second)
            assert problem.energy(found) == pytest.approx(best_mixture(problem, first, second))


@pytest.mark.parametrize("optional", [False, True])
def test_fusion_is_a_mixture_no_worse_than_either(optional: bool) -> None:
    for seed in range(30):
        rng = np.random.default_rng(seed)
        problem = explicit_instance(7, 9, seed, density=0.1)
        first, second = (random_partners(7, 9, rng, optional) for _ in range(2))
        found = fuse(problem, first, second)
        assert ((found == first) | (found == second)).all()
        either = min(problem.energy(first), problem.energy(second))
        assert best_mixture(problem, first, second) - 1e-9 <= problem.energy(found)
        assert problem.energy(found) <= either + 1e-9


def test_of_many_parts_the_fusion_is_no_worse_than_either() -> None:
    better = 0
    for seed in range(5):
        problem = metric_instance(20, 60, seed, noise=1.0)
        first, second = np.arange(20), np.arange(20) + 20  # as many parts as points
        found = problem.energy(fuse(problem, first, second))
        least = min(problem.energy(first), problem.energy(second))
        assert found <= least + 1e-9
        better += found < least
    assert better == 5


def test_equal_correspondences_stay() -> None:
    problem = metric_instance(4, 4, 0)
    assert (fuse(problem, np.arange(4), np.arange(4)) == np.arange(4)).all()
