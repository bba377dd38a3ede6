"""Local subproblems against enumeration."""

import itertools

import numpy as np
import pytest

from solver.labelling import LabellingProblem
from solver.optimisation.dual_decomposition import (
    PairSubproblems,
    full_groups,
    sides_of,
    sparse_groups,
)
from tests.solver.problems import explicit_instance, metric_instance


def random_subproblems(
    problem: LabellingProblem, which: int, listed: bool, optional: bool
) -> tuple[PairSubproblems, dict[tuple[int, int], float]]:
    """Subproblems of a side with random costs, and the pairwise costs by candidates."""
    side = sides_of(problem)[which]
    rng = np.random.default_rng(which)
    v = problem.n_candidates
    x, y = problem.candidates.T
    pairs = [
        (a, b) for a, b in itertools.combinations(range(v), 2) if x[a] != x[b] and y[a] != y[b]
    ]
    if listed:
        pairs = [pair for pair in pairs if rng.random() < 0.4]
    cost = {pair: float(rng.normal()) for pair in pairs}
    if listed:
        first, second = np.array(pairs, dtype=np.int64).T
        groups, order = sparse_groups(side, first, second)
        values = np.array([cost[pairs[k]] for k in order])
    else:
        groups = full_groups(side)
        values = np.full(groups.pairwise[-1], np.inf)
        for g, (p, q) in enumerate(groups.points):
            ours, theirs = (side.order[side.first[i] : side.first[i + 1]] for i in (p, q))
            block = itertools.product(ours, theirs)
            for e, (a, b) in enumerate(block, start=groups.pairwise[g]):
                values[e] = cost.get((min(a, b), max(a, b)), np.inf)
    found = PairSubproblems(side, groups, values, optional)
    found.unary[:] = rng.normal(size=len(found.unary))
    return found, cost


@pytest.mark.parametrize("optional", [False, True])
@pytest.mark.parametrize("listed", [False, True])
@pytest.mark.parametrize("which", [0, 1])
def test_minima_are_those_of_enumeration(which: int, listed: bool, optional: bool) -> None:
    problem = metric_instance(5, 5, 7, share_of_candidates=0.8)
    pairs, cost = random_subproblems(problem, which, listed, optional)
    side, groups = pairs.side, pairs.groups
    total = pairs.minimise()
    expected = 0.0
    for g, (p, q) in enumerate(groups.points):
        ours, theirs = (list(side.order[side.first[i] : side.first[i + 1]]) for i in (p, q))
        start = groups.unary[g]
        alone = {a: pairs.unary[start + i] for i, a in enumerate(ours)}
        other = {b: pairs.unary[start + len(ours) + j] for j, b in enumerate(theirs)}
        choices = [
            alone[a] + other[b] + cost.get((min(a, b), max(a, b)), 0.0)
            for a in ours
            for b in theirs
            if side.other[a] != side.other[b]
        ]
        if optional:
            choices += [0.0, *alone.values(), *other.values()]
        expected += min(choices)
        assert pairs.minima[g] == pytest.approx(min(choices))
    assert total == pytest.approx(expected)


@pytest.mark.parametrize("listed", [False, True])
def test_what_is_used_costs_the_minimum(listed: bool) -> None:
    problem = explicit_instance(4, 5, 3)
    for which in (0, 1):
        pairs, _ = random_subproblems(problem, which, listed, optional=True)
        total = pairs.minimise()
        used = pairs.unary[pairs.used_unary.positions].sum()
        used += pairs.pairwise[pairs.used_pairwise].sum()
        assert total == pytest.approx(used)


def test_all_places_of_a_candidate_are_found() -> None:
    pairs, _ = random_subproblems(metric_instance(4, 5, 1), 0, listed=False, optional=False)
    places = pairs.places_of(np.array([3, 11])).positions
    assert sorted(places) == sorted(np.flatnonzero(np.isin(pairs.candidate_at, [3, 11])))
