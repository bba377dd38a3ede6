"""Third-order costs in every part of the optimisation: bound <= optimum <= energy."""

import numpy as np
import pytest

from solver.labelling import LabellingProblem
from solver.optimisation import ReparametrisedCosts, minimise
from solver.optimisation.dual_decomposition import DualDecomposition, Subproblems
from solver.optimisation.exact import divide_triples, m_best_solutions
from solver.optimisation.primal import fuse, local_search
from solver.optimisation.regions import can_prove
from tests.solver.optimisation.dual_decomposition.decomposed import decomposed
from tests.solver.optimisation.primal.test_local_search import neighbours
from tests.solver.problems import REGIMES, all_solutions, metric_instance, with_triples


def instance(n: int, m: int, seed: int, weight: float = 1.0, **regime: float) -> LabellingProblem:
    return with_triples(metric_instance(n, m, seed, **regime), seed, weight)


@pytest.mark.parametrize("weight", [0.01, 1.0, 100.0])
@pytest.mark.parametrize("regime", REGIMES)
def test_m_best_are_those_of_enumeration(regime: str, weight: float) -> None:
    for seed in range(3):
        problem = instance(5, 5, seed, weight, **REGIMES[regime])
        expected = all_solutions(problem)[:8]
        found = m_best_solutions(problem, 8)
        assert found.proven
        np.testing.assert_allclose(
            found.energies, [energy for energy, _ in expected], rtol=1e-9, atol=1e-12
        )
        for solution in found:
            assert problem.energy(solution.answer) == pytest.approx(solution.value, abs=1e-12)


@pytest.mark.parametrize("regime", REGIMES)
def test_optimum_is_that_of_enumeration(regime: str) -> None:
    for seed in range(3):
        problem = instance(5, 6, seed, **REGIMES[regime])
        found = minimise(problem)
        assert found.value == pytest.approx(all_solutions(problem)[0][0], abs=1e-12)
        assert found.certified


def test_seven_points_with_several_triples() -> None:
    for seed in range(2):
        problem = instance(7, 7, seed, noise=1.0)
        assert len(problem.triples.points) >= 5
        optimum, partners = all_solutions(problem)[0]
        found = m_best_solutions(problem, rounds=4)
        assert found.proven
        assert found.energies[0] == pytest.approx(optimum)
        assert tuple(found.partners[0]) == partners


@pytest.mark.parametrize(
    "subproblems",
    [
        Subproblems(),
        Subproblems(maxflow=True),
        Subproblems(target_pairs=False),
        Subproblems(source_pairs=False),
    ],
    ids=["pairs", "maxflow", "source pairs", "target pairs"],
)
@pytest.mark.parametrize("gamma", [np.inf, 0.4])
def test_bound_of_the_dual_decomposition(subproblems: Subproblems, gamma: float) -> None:
    for seed in range(3):
        problem = instance(5, 6, seed, noise=1.0, occlusion_cost=gamma)
        optimum = all_solutions(problem)[0][0]
        found = decomposed(problem, subproblems, iterations=60)
        assert found.lower_bound <= optimum + 1e-12 <= found.value + 2e-12


def test_points_without_candidates_have_no_triple_subproblems() -> None:
    """Candidates of two points are excluded, as a reduction of the problem does."""
    for seed in range(3):
        problem = instance(6, 6, seed, noise=1.0, occlusion_cost=0.4)
        kept = np.flatnonzero(~np.isin(problem.candidates[:, 0], [0, 4]))
        reduced = problem.among(kept)
        state = DualDecomposition(reduced).init()
        method = DualDecomposition(reduced)
        for _ in range(20):
            state = method.step(state)
        costs = state.reparametrised_costs()
        for energy, partners in all_solutions(reduced):
            chosen = reduced.chosen_candidates(np.array(partners))
            assert total(costs, chosen) <= energy + 1e-9


def test_third_order_costs_raise_the_bound() -> None:
    """Triples alone cost something: the bound with pairs of source points is above zero."""
    for seed in range(3):
        problem = instance(6, 6, seed, noise=0.0, unary=0.0, beta=0.0)
        optimum = all_solutions(problem)[0][0]
        bounds = [
            decomposed(problem, chosen, iterations=100).lower_bound
            for chosen in (Subproblems(source_pairs=False), Subproblems())
        ]
        assert bounds[0] == 0.0
        assert 0.0 < bounds[1] <= optimum + 1e-12


@pytest.mark.parametrize("gamma", [np.inf, 0.4])
def test_costs_of_the_decomposition_bound_every_correspondence(gamma: float) -> None:
    problem = instance(4, 5, 2, noise=1.0, occlusion_cost=gamma)
    state = DualDecomposition(problem).init()
    method = DualDecomposition(problem)
    for _ in range(20):
        state = method.step(state)
    costs = state.reparametrised_costs()
    for energy, partners in all_solutions(problem):
        chosen = problem.chosen_candidates(np.array(partners))
        assert total(costs, chosen) <= energy + 1e-9


def total(costs: ReparametrisedCosts, chosen: np.ndarray) -> float:
    """All costs of a correspondence, by plain sums."""
    matched = chosen[chosen >= 0]
    value = costs.constant + costs.unary[matched].sum() + costs.occlusion[chosen < 0].sum()
    value += costs.pairwise[np.ix_(matched, matched)].sum() / 2.0
    for t, points in enumerate(costs.triples.points):
        if (chosen[points] >= 0).all():
            value += costs.triples.table(t)[tuple(chosen[points] - costs.triples.rows[points])]
    return float(value)


def test_division_changes_no_energy_and_leaves_nothing_negative() -> None:
    problem = instance(6, 6, 4, noise=1.0)
    own = ReparametrisedCosts.of(problem)
    divided = divide_triples(own)
    assert divided.pairwise.min() >= 0.0
    assert divided.triples.costs.min() >= 0.0
    assert (divided.pairwise == divided.pairwise.T).all()
    for energy, partners in all_solutions(problem):
        chosen = problem.chosen_candidates(np.array(partners))
        assert total(divided, chosen) == pytest.approx(energy)
    # Each triple keeps a triple of candidates that costs nothing beyond its pairs.
    for t in range(len(divided.triples.points)):
        assert divided.triples.table(t).min() == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("gamma", [np.inf, 0.5])
def test_local_search_ends_where_no_neighbour_is_better(gamma: float) -> None:
    for seed in range(8):
        problem = instance(7, 9, seed, noise=1.0, occlusion_cost=gamma)
        start = np.random.default_rng(seed).permutation(9)[:7]
        found = local_search(problem, start)
        energy = problem.energy(found)
        assert energy <= problem.energy(start)
        assert energy <= min(map(problem.energy, neighbours(problem, found))) + 1e-12


def test_fusion_is_no_worse_than_either() -> None:
    for seed in range(8):
        problem = instance(7, 9, seed, noise=1.0)
        rng = np.random.default_rng(seed)
        first, second = (rng.permutation(9)[:7] for _ in range(2))
        fused = problem.energy(fuse(problem, first, second))
        assert fused <= min(problem.energy(first), problem.energy(second))


def test_regions_have_no_third_order_costs() -> None:
    problem = metric_instance(5, 6, 0)
    assert can_prove(problem)
    assert not can_prove(with_triples(problem, 0))
