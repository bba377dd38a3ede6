"""Triples against enumeration; what they gain."""

import itertools

import numpy as np
import pytest

from solver.optimisation.dual_decomposition import (
    PairSubproblems,
    TripleSubproblems,
    full_costs,
    full_groups,
    sides_of,
    triples_of,
)
from tests.solver.problems import metric_instance

APART = np.array([[0, 1, 2], [0, 3, 4], [1, 3, 5], [2, 4, 5]])
"""Triples of six points, no two of which share a pair."""


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
    for seed, triple in enumerate(APART):
        pairs = frustrated_pairs(seed, optional)
        triples = triples_of(pairs.side, pairs.groups, triple[None])
        counts = np.diff(pairs.side.first)[triple]
        third = np.random.default_rng(seed).random(counts)
        batch = TripleSubproblems(pairs, triples, third.ravel())
        unary = np.split(batch.unary, np.cumsum(counts)[:-1])
        sizes = [counts[i] * counts[j] for i, j in ((0, 1), (0, 2), (1, 2))]
        parts = np.split(batch.pairwise, np.cumsum(sizes)[:-1])
        blocks = {
            (i, j): part.reshape(counts[i], counts[j])
            for (i, j), part in zip(((0, 1), (0, 2), (1, 2)), parts, strict=True)
        }
        none = [-1] if optional else []
        expected, choice = min(
            (
                sum(unary[i][c] for i, c in enumerate(choice) if c >= 0)
                + sum(
                    blocks[i, j][choice[i], choice[j]]
                    for i, j in blocks
                    if choice[i] >= 0 and choice[j] >= 0
                )
                + (third[choice] if min(choice) >= 0 else 0.0),
                choice,
            )
            for choice in itertools.product(*([*range(count), *none] for count in counts))
        )
        assert batch.minimise() == pytest.approx(expected)
        unary_used, pairwise_used = batch.used
        attained = batch.unary[unary_used.positions].sum()
        attained += batch.pairwise[pairwise_used.positions].sum()
        attained += third[choice] if min(choice) >= 0 else 0.0
        assert attained == pytest.approx(expected)


def test_taking_over_raises_the_bound() -> None:
    for seed in range(6):
        pairs = frustrated_pairs(seed, optional=False)
        before = pairs.minimise()
        triples = triples_of(pairs.side, pairs.groups, APART)
        batch = TripleSubproblems(pairs, triples, np.zeros(triples.third[-1]))
        assert pairs.minimise() + batch.minimise() > before
