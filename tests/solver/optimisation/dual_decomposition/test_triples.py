"""Triples against enumeration; what they gain."""

import itertools

import numpy as np
import pytest

from solver.optimisation.dual_decomposition import (
    PairSubproblems,
    TripleSubproblems,
    choose_triples,
    full_costs,
    full_groups,
    sides_of,
)
from tests.solver.problems import metric_instance


def frustrated_pairs(seed: int, optional: bool) -> PairSubproblems:
    """Source pairs with random unary costs, so that pairs of points disagree."""
    problem = metric_instance(6, 6, seed, noise=1.0)
    side = sides_of(problem)[0]
    groups = full_groups(side)
    costs = full_costs(side, groups, problem.pairwise_costs, 1.0)
    pairs = PairSubproblems(side, groups, costs, optional)
    pairs.unary[:] = np.random.default_rng(seed).normal(size=len(pairs.unary))
    return pairs


@pytest.mark.parametrize("optional", [False, True])
def test_minimum_of_a_triple_is_that_of_enumeration(optional: bool) -> None:
    for seed in range(4):
        pairs = frustrated_pairs(seed, optional)
        pairs.minimise()
        triples = choose_triples(pairs, 1, np.zeros(len(pairs.groups.points), dtype=np.bool_))
        batch = TripleSubproblems(pairs, triples)
        first = pairs.side.first
        counts = np.diff(first)[triples.points[0]]
        unary = np.split(batch.unary, np.cumsum(counts)[:-1])
        sizes = [counts[i] * counts[j] for i, j in ((0, 1), (0, 2), (1, 2))]
        parts = np.split(batch.pairwise, np.cumsum(sizes)[:-1])
        blocks = {
            (i, j): part.reshape(counts[i], counts[j])
            for (i, j), part in zip(((0, 1), (0, 2), (1, 2)), parts, strict=True)
        }
        none = [-1] if optional else []
        expected = min(
            sum(unary[i][c] for i, c in enumerate(choice) if c >= 0)
            + sum(
                blocks[i, j][choice[i], choice[j]]
                for i, j in blocks
                if choice[i] >= 0 and choice[j] >= 0
            )
            for choice in itertools.product(*([*range(count), *none] for count in counts))
        )
        assert batch.minimise() == pytest.approx(expected)
        unary_used, pairwise_used = batch.used
        attained = batch.unary[unary_used.positions].sum()
        attained += batch.pairwise[pairwise_used.positions].sum()
        assert attained == pytest.approx(expected)


def test_taking_over_raises_the_bound() -> None:
    for seed in range(6):
        pairs = frustrated_pairs(seed, optional=False)
        before = pairs.minimise()
        taken = np.zeros(len(pairs.groups.points), dtype=np.bool_)
        triples = choose_triples(pairs, 4, taken)
        assert len(triples.points) > 0
        assert taken.sum() == 3 * len(triples.points)  # no two share a pair
        batch = TripleSubproblems(pairs, triples)
        assert pairs.minimise() + batch.minimise() > before


def test_pairs_that_agree_need_no_triple() -> None:
    problem = metric_instance(5, 5, 0, noise=0.0, unary=0.0)
    side = sides_of(problem)[0]
    groups = full_groups(side)
    costs = full_costs(side, groups, problem.pairwise_costs, 1.0)
    pairs = PairSubproblems(side, groups, costs, False)
    pairs.minimise()
    free = np.zeros(len(groups.points), dtype=np.bool_)
    assert len(choose_triples(pairs, 10, free).points) == 0
