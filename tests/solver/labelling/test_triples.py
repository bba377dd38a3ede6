"""Third-order costs: the energy by its definition, subsets of candidates, and what is refused."""

from dataclasses import replace

import numpy as np
import pytest

from solver.labelling import NO_TRIPLES, UNMATCHED, LabellingProblem, triple_costs
from tests.solver.problems import all_solutions, metric_instance, with_triples

REGIMES = {
    "all candidates": {},
    "few candidates": {"share_of_candidates": 0.5},
    "occlusion": {"occlusion_cost": 0.4},
}


def third_order_energy(problem: LabellingProblem, partners: tuple[int, ...]) -> float:
    """Sum over triples of matched points, by the places of their candidates."""
    total = 0.0
    for t, triple in enumerate(problem.triples.points):
        places = []
        for x in triple:
            mine = problem.candidates[problem.candidates[:, 0] == x, 1]
            places += np.flatnonzero(mine == partners[x]).tolist()
        if len(places) == 3:
            total += float(problem.triples.table(t)[tuple(places)])
    return total


@pytest.mark.parametrize("regime", REGIMES)
def test_energy_is_the_second_order_one_and_the_costs_of_triples(regime: str) -> None:
    plain = metric_instance(4, 5, 3, **REGIMES[regime])
    problem = with_triples(plain, 3)
    assert len(problem.triples.points) == 2
    solutions = all_solutions(problem)
    for energy, partners in solutions:
        expected = plain.energy(np.array(partners)) + third_order_energy(problem, partners)
        assert energy == pytest.approx(expected)
        assert problem.costs(np.array(partners)).sum() == pytest.approx(energy)
    assert any(third_order_energy(problem, partners) > 0.0 for _, partners in solutions)


def test_an_unmatched_point_costs_its_triples_nothing() -> None:
    problem = with_triples(metric_instance(3, 4, 0, occlusion_cost=0.5), 0)
    plain = replace(problem, triples=NO_TRIPLES)
    partners = np.array([2, UNMATCHED, 0])
    assert problem.energy(partners) == plain.energy(partners)


def test_some_of_the_candidates_have_the_same_energies() -> None:
    problem = with_triples(metric_instance(7, 7, 1), 1)
    assert len(problem.triples.points) > 3
    kept = np.flatnonzero(np.random.default_rng(0).random(49) < 0.6)
    diagonal = np.flatnonzero(problem.candidates[:, 0] == problem.candidates[:, 1])
    some = problem.among(np.union1d(kept, diagonal))
    assert some.n_candidates < 49
    partners = np.arange(7)
    assert some.energy(partners) == pytest.approx(problem.energy(partners))


def test_a_point_without_candidates_has_no_triples() -> None:
    problem = with_triples(metric_instance(5, 5, 1, occlusion_cost=0.5), 1)
    kept = np.flatnonzero(problem.candidates[:, 0] != 2)
    some = problem.among(kept)
    assert 2 in problem.triples.points
    assert some.triples.points.tolist() == [
        triple for triple in problem.triples.points.tolist() if 2 not in triple
    ]
    partners = np.array([0, 1, UNMATCHED, 3, 4])
    assert some.energy(partners) == pytest.approx(problem.energy(partners))


@pytest.mark.parametrize(
    ("points", "change", "message"),
    [
        ([[0, 1, 2], [0, 1, 2]], 0.0, "given twice"),
        ([[1, 0, 2]], 0.0, "ascending"),
        ([[0, 1, 4]], 0.0, "does not exist"),
        ([[0, 1, 2]], -1.0, "not negative"),
        ([[0, 1, 2]], np.inf, "finite"),
    ],
)
def test_wrong_triples_are_refused(points: list[list[int]], change: float, message: str) -> None:
    rows = np.array([0, 2, 4, 6, 8])
    tables = [np.full((2, 2, 2), change) for _ in points]
    with pytest.raises(ValueError, match=message):
        triple_costs(rows, np.array(points), tables)


def test_tables_and_candidates_must_agree() -> None:
    rows = np.array([0, 2, 4, 6])
    with pytest.raises(ValueError, match="every three candidates"):
        triple_costs(rows, np.array([[0, 1, 2]]), [np.zeros((2, 3, 2))])
    problem = metric_instance(3, 3, 0)
    third = triple_costs(rows, np.array([[0, 1, 2]]), [np.zeros((2, 2, 2))])
    with pytest.raises(ValueError, match="other candidates"):
        replace(problem, triples=third)
