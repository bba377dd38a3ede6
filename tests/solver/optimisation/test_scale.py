"""The scale of the costs changes no answer: powers of two scale without rounding errors."""

from collections.abc import Callable

import numpy as np
import pytest

from solver.arrays import IntArray
from solver.labelling import LabellingProblem, Solution
from solver.optimisation import minimise
from solver.optimisation.exact import m_best_solutions, within_distortion
from solver.optimisation.primal import local_search, maximum_matching
from solver.optimisation.primal.fusion import fuse
from solver.optimisation.regions import prove
from tests.solver.problems import explicit_instance, metric_instance, scaled, with_triples

FACTORS = 2.0**-50, 2.0**30

METRIC = [
    metric_instance(5, 6, 0, noise=1.0),
    metric_instance(5, 6, 1, noise=0.6, occlusion_cost=0.4),
    metric_instance(14, 18, 0, noise=0.5),
]
PROBLEMS = [
    *METRIC,
    explicit_instance(5, 5, 0, occlusion_cost=0.2),
    explicit_instance(5, 6, 1, occlusion_cost=np.inf),
    explicit_instance(20, 20, 2, density=0.1, share_of_candidates=0.3),
    with_triples(metric_instance(5, 6, 2, noise=0.6), 0),
]

Solver = Callable[[LabellingProblem], Solution[IntArray]]


def few_iterations(problem: LabellingProblem) -> Solution[IntArray]:
    return minimise(problem, iterations=100, search_seconds=0.01)


def best(problem: LabellingProblem) -> Solution[IntArray]:
    return m_best_solutions(problem, 4, node_limit=20_000)[0]


@pytest.mark.parametrize("factor", FACTORS)
@pytest.mark.parametrize(
    ("solver", "problem"),
    [
        *((solver, problem) for solver in (best, few_iterations) for problem in PROBLEMS),
        *((prove, problem) for problem in METRIC),
    ],
)
def test_answers_and_proofs_scale(solver: Solver, problem: LabellingProblem, factor: float) -> None:
    expected, found = solver(problem), solver(scaled(problem, factor))
    np.testing.assert_array_equal(found.answer, expected.answer)
    assert found.value == pytest.approx(factor * expected.value, rel=1e-12)
    assert found.lower_bound == pytest.approx(factor * expected.lower_bound, rel=1e-9)


@pytest.mark.parametrize("factor", FACTORS)
@pytest.mark.parametrize("problem", PROBLEMS)
def test_local_search_scales(problem: LabellingProblem, factor: float) -> None:
    small = scaled(problem, factor)
    order = np.arange(problem.n_candidates)
    starts = [maximum_matching(problem, (order % k).astype(np.float64)) for k in (5, 7)]
    for start in starts:
        np.testing.assert_array_equal(local_search(small, start), local_search(problem, start))
    np.testing.assert_array_equal(fuse(small, *starts), fuse(problem, *starts))


def test_maximum_matching_scales() -> None:
    problem = metric_instance(8, 9, 0, occlusion_cost=1.0, share_of_candidates=0.5)
    expected = maximum_matching(problem, problem.unary)
    for factor in FACTORS:
        found = maximum_matching(problem, factor * problem.unary)
        np.testing.assert_array_equal(found, expected)


def test_penalties_of_distortion_scale() -> None:
    problem = metric_instance(5, 6, 0, noise=1.0)
    metrics = problem.source_distances, problem.target_distances
    expected = m_best_solutions(within_distortion(problem, *metrics, 1.5), 4)
    for factor in FACTORS:
        found = m_best_solutions(within_distortion(scaled(problem, factor), *metrics, 1.5), 4)
        np.testing.assert_array_equal(found.partners, expected.partners)
