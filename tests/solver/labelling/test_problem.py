"""The energy (5): against its definition, term by term, and its invariances."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from solver.labelling import UNMATCHED, LabellingProblem
from tests.solver.problems import all_solutions, explicit_instance, metric_instance, relabelled


def energy_by_definition(problem: LabellingProblem, partners: tuple[int, ...]) -> float:
    """(5) as written, over pairs of candidates, plus γ|X|; γ counts only where it is finite."""
    chosen = [(x, y) for x, y in enumerate(partners) if y != UNMATCHED]
    unary = dict(zip(map(tuple, problem.candidates.tolist()), problem.unary, strict=True))
    total = sum(unary[x, y] for x, y in chosen)
    for i, (x, y) in enumerate(chosen):
        for x2, y2 in chosen[i + 1 :]:
            distortion = problem.source_distances[x, x2] - problem.target_distances[y, y2]
            total += problem.beta * distortion**2
    unmatched = len(partners) - len(chosen)
    return float(total + (problem.occlusion_cost * unmatched if unmatched else 0.0))


@given(seed=st.integers(0, 10_000), gamma=st.sampled_from([np.inf, 3, 0.2]))
def test_energy_is_equation_5(seed: int, gamma: float) -> None:
    problem = metric_instance(3, 4, seed, occlusion_cost=gamma, share_of_candidates=0.7)
    for energy, partners in all_solutions(problem):
        assert energy == pytest.approx(energy_by_definition(problem, partners), abs=1e-12)
        assert problem.energy(np.array(partners)) == pytest.approx(energy, abs=1e-12)


def test_costs_are_shares_of_the_energy() -> None:
    problem = metric_instance(5, 6, 1, occlusion_cost=0.5)
    partners = np.array([3, UNMATCHED, 0, 5, 1])
    costs = problem.costs(partners)
    assert costs.sum() == pytest.approx(problem.energy(partners))
    assert costs[1] == 0.5


def test_pairwise_matrix_is_the_second_order_term() -> None:
    problem = metric_instance(4, 5, 2, beta=1.7)
    matrix = problem.pairwise_matrix()
    x, y = problem.candidates.T
    assert (matrix == matrix.T).all()
    exclusive = (x[:, None] == x) | (y[:, None] == y)
    np.fill_diagonal(exclusive, False)
    assert np.isinf(matrix[exclusive]).all()
    a, b = 1, 13
    assert (x[a], y[a], x[b], y[b]) == (0, 1, 2, 3)
    expected = 1.7 * (problem.source_distances[0, 2] - problem.target_distances[1, 3]) ** 2
    assert matrix[a, b] == pytest.approx(expected)


@given(seed=st.integers(0, 10_000))
def test_energy_does_not_depend_on_the_numbering(seed: int) -> None:
    rng = np.random.default_rng(seed)
    problem = metric_instance(5, 7, seed, share_of_candidates=0.6)
    rows, columns = rng.permutation(5), rng.permutation(7)
    partners = np.arange(5)
    renamed = np.empty(5, dtype=np.int64)
    renamed[rows] = columns[partners]
    again = relabelled(problem, rows, columns)
    assert again.energy(renamed) == pytest.approx(problem.energy(partners), rel=1e-12)


def test_a_perfect_copy_costs_nothing() -> None:
    problem = metric_instance(6, 6, 3, noise=0.0, unary=0.0)
    assert all_solutions(problem)[0][0] == pytest.approx(0.0, abs=1e-20)


@pytest.mark.parametrize(
    ("partners", "message"),
    [
        ([0, 0, 1], "used twice"),
        ([2, 1, 0], "not a candidate"),
        # Numbered on, they would be candidates of the point before or after.
        ([3, 1, 2], "not a candidate"),
        ([0, -2, -1], "not a candidate"),
    ],
)
def test_impossible_correspondences_are_refused(partners: list[int], message: str) -> None:
    candidates = np.array([[0, 0], [0, 1], [1, 0], [1, 1], [2, 1], [2, 2]])
    problem = LabellingProblem(candidates, np.zeros(6), np.zeros((3, 3)), np.zeros((3, 3)))
    with pytest.raises(ValueError, match=message):
        problem.energy(np.array(partners))


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"candidates": np.array([[1, 0], [0, 0]])}, "lexicographic"),
        ({"candidates": np.array([[0, 0], [0, 0]])}, "unique"),
        ({"candidates": np.array([[0, 0], [0, 2]])}, "do not exist"),
        ({"unary": np.array([0.0, np.nan])}, "finite"),
        ({"beta": -1.0}, "beta"),
        ({"occlusion_cost": -0.1}, "occlusion"),
        ({"source_distances": np.full((2, 2), np.inf)}, "finite"),
    ],
)
def test_meaningless_problems_are_refused(changes: dict[str, object], message: str) -> None:
    sound: dict[str, object] = {
        "candidates": np.array([[0, 0], [0, 1]]),
        "unary": np.zeros(2),
        "source_distances": np.zeros((2, 2)),
        "target_distances": np.zeros((2, 2)),
    }
    with pytest.raises(ValueError, match=message):
        LabellingProblem(**{**sound, **changes})  # type: ignore[arg-type]


@pytest.mark.parametrize("gamma", [np.inf, 0.4])
def test_some_candidates_cost_what_they_did(gamma: float) -> None:
    rng = np.random.default_rng(2)
    for problem in (
        metric_instance(4, 5, 0, occlusion_cost=gamma),
        explicit_instance(4, 5, 0, occlusion_cost=gamma),
    ):
        table = rng.random((problem.n_candidates, problem.n_candidates))
        whole = replace(problem, table=table + table.T)
        diagonal = whole.candidates[:, 0] == whole.candidates[:, 1]
        kept = np.flatnonzero(diagonal | (rng.random(len(diagonal)) < 0.5))
        some = whole.among(kept)
        assert some.n_candidates == len(kept) < whole.n_candidates
        np.testing.assert_array_equal(
            some.pairwise_matrix(), whole.pairwise_matrix()[np.ix_(kept, kept)]
        )
        for energy, partners in all_solutions(some)[:20]:
            assert whole.energy(np.array(partners)) == pytest.approx(energy)
