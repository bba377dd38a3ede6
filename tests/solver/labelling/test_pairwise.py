"""Both forms of the pairwise costs."""

import itertools
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from solver.labelling import PairwiseTerms, pairwise_cost
from tests.solver.problems import all_solutions, explicit_instance, metric_instance


@given(
    st.lists(
        st.tuples(st.integers(0, 9), st.integers(0, 9), st.floats(-5, 5)).filter(
            lambda term: term[0] != term[1]
        ),
        max_size=30,
    )
)
def test_terms_are_collected(listed: list[tuple[int, int, float]]) -> None:
    pairs = np.array([term[:2] for term in listed], dtype=np.int64).reshape(-1, 2)
    terms = PairwiseTerms.collect(pairs, np.array([term[2] for term in listed]))
    dense = np.zeros((10, 10))
    for a, b, cost in listed:
        dense[min(a, b), max(a, b)] += cost
    again = np.zeros((10, 10))
    again[terms.first, terms.second] = terms.costs
    np.testing.assert_allclose(again, dense, atol=1e-12)
    first, other, weights = terms.adjacency(10)
    for a in range(10):
        row = slice(first[a], first[a + 1])
        assert (np.diff(other[row]) > 0).all()
        np.testing.assert_allclose(weights[row], (dense + dense.T)[a, other[row]], atol=1e-12)


def test_both_forms_add_up() -> None:
    explicit, metric = explicit_instance(4, 5, 0), metric_instance(4, 5, 0, beta=1.3)
    problem = replace(metric, terms=explicit.terms)
    matrix = problem.pairwise_matrix()
    parts = metric.pairwise_matrix() + explicit.pairwise_matrix()
    np.testing.assert_allclose(matrix, parts)
    for a, b in itertools.combinations(range(problem.n_candidates), 2):
        if np.isfinite(matrix[a, b]):
            assert pairwise_cost(problem.pairwise_costs, a, b) == pytest.approx(matrix[a, b])


def test_energy_is_the_sum_of_what_is_chosen() -> None:
    problem = explicit_instance(3, 4, 5, occlusion_cost=0.7)
    matrix = problem.pairwise_matrix()
    for energy, partners in all_solutions(problem):
        chosen = problem.chosen_candidates(np.array(partners))
        used = chosen[chosen >= 0]
        expected = problem.unary[used].sum() + 0.5 * matrix[np.ix_(used, used)].sum()
        assert energy == pytest.approx(expected + 0.7 * (chosen < 0).sum())
        assert problem.energy(np.array(partners)) == pytest.approx(energy)


@pytest.mark.parametrize(
    ("first", "second", "costs", "message"),
    [
        ([1], [1], [0.0], "lower index first"),
        ([2], [1], [0.0], "lower index first"),
        ([0, 0], [1, 1], [0.0, 1.0], "unique"),
        ([1, 0], [2, 1], [0.0, 1.0], "lexicographic"),
        ([0], [1], [np.nan], "finite"),
        ([0], [1, 2], [0.0], "two candidates"),
    ],
)
def test_meaningless_terms_are_refused(
    first: list[int], second: list[int], costs: list[float], message: str
) -> None:
    with pytest.raises(ValueError, match=message):
        PairwiseTerms(np.array(first), np.array(second), np.array(costs))
