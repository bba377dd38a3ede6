"""Labelling problems that the solver's tests share."""

import itertools
from dataclasses import replace

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.labelling import UNMATCHED, LabellingProblem, PairwiseTerms, triple_costs

REGIMES = {
    "easy": {"noise": 0.1},
    "noisy": {"noise": 1.0},
    "features only": {"noise": 1.0, "beta": 0.0},
    "no features": {"unary": 0.0},
    "strong features": {"unary": 10.0},
    "large beta": {"beta": 100.0},
    "few candidates": {"share_of_candidates": 0.4},
    "cheap occlusion": {"occlusion_cost": 0.05},
    "occlusion": {"occlusion_cost": 0.4, "noise": 0.6},
    "dear occlusion": {"occlusion_cost": 50.0},
    "occlusion, few candidates": {"occlusion_cost": 0.3, "share_of_candidates": 0.5},
}
"""Arguments of :func:`metric_instance`."""


def distances_of(points: FloatArray) -> FloatArray:
    distances: FloatArray = np.linalg.norm(points[:, None] - points[None], axis=2)
    return distances


def metric_instance(
    n: int,
    m: int,
    seed: int,
    *,
    noise: float = 0.3,
    unary: float = 0.1,
    beta: float = 1.0,
    occlusion_cost: float = np.inf,
    share_of_candidates: float = 1.0,
) -> LabellingProblem:
    """Noisy copies of some of m points in space, in another order; all or some pairs may match.

    The diagonal pairs are always candidates, so that a complete correspondence exists.
    """
    rng = np.random.default_rng(seed)
    target = rng.normal(size=(m, 3))
    source = target[rng.permutation(m)[:n]] + noise * rng.normal(size=(n, 3))
    pairs = np.array(list(itertools.product(range(n), range(m))), dtype=np.int64)
    kept = rng.random(len(pairs)) < share_of_candidates
    kept |= pairs[:, 0] == pairs[:, 1]
    pairs = pairs[kept]
    return LabellingProblem(
        pairs,
        unary * rng.random(len(pairs)),
        distances_of(source),
        distances_of(target),
        beta,
        occlusion_cost,
    )


def explicit_instance(
    n: int,
    m: int,
    seed: int,
    *,
    density: float = 0.4,
    occlusion_cost: float = 0.0,
    share_of_candidates: float = 1.0,
) -> LabellingProblem:
    """Random unary costs and pairwise terms of either sign; the diagonal pairs are candidates."""
    rng = np.random.default_rng(seed)
    pairs = np.array(list(itertools.product(range(n), range(m))), dtype=np.int64)
    kept = (rng.random(len(pairs)) < share_of_candidates) | (pairs[:, 0] == pairs[:, 1])
    pairs = pairs[kept]
    edges = np.array(list(itertools.combinations(range(len(pairs)), 2)), dtype=np.int64)
    edges = edges.reshape(-1, 2)
    edges = edges[rng.random(len(edges)) < density]
    terms = PairwiseTerms.collect(edges, rng.normal(size=len(edges)))
    unary = rng.normal(size=len(pairs))
    return LabellingProblem.explicit((n, m), pairs, unary, terms, occlusion_cost)


def all_solutions(problem: LabellingProblem) -> list[tuple[float, tuple[int, ...]]]:
    """Energy and partners of every correspondence, best first, by plain enumeration."""
    n, m = problem.shape
    # UNMATCHED is the last place of a row, where no candidate is.
    number = np.full((n, m + 1), UNMATCHED)
    number[tuple(problem.candidates.T)] = np.arange(problem.n_candidates)
    optional = not problem.must_match_all
    choices = [[*np.flatnonzero(row[:m] >= 0), *[UNMATCHED] * optional] for row in number]
    partners = np.array(list(itertools.product(*choices)), dtype=np.int64).reshape(-1, n)
    chosen = number[np.arange(n), partners]
    energies = np.append(problem.unary, problem.occlusion_cost)[chosen].sum(axis=1)
    pairwise = np.pad(problem.pairwise_matrix(), (0, 1))
    for x, other in itertools.combinations(range(n), 2):
        energies += pairwise[chosen[:, x], chosen[:, other]]
    for t, points in enumerate(problem.triples.points):
        used = (chosen[:, points] >= 0).all(axis=1)
        places = chosen[np.ix_(used, points)] - problem.first_candidate[points]
        energies[used] += problem.triples.table(t)[tuple(places.T)]
    # A target point that is used twice costs infinitely much.
    possible = np.isfinite(energies)
    return sorted(
        (energy, tuple(one))
        for energy, one in zip(
            energies[possible].tolist(), partners[possible].tolist(), strict=True
        )
    )


def relabelled(problem: LabellingProblem, rows: IntArray, columns: IntArray) -> LabellingProblem:
    """The same problem with source point i renamed to rows[i], target point j to columns[j]."""
    pairs = np.stack([rows[problem.candidates[:, 0]], columns[problem.candidates[:, 1]]], axis=1)
    order = np.lexsort((pairs[:, 1], pairs[:, 0]))
    back_rows, back_columns = np.argsort(rows), np.argsort(columns)
    return replace(
        problem,
        candidates=pairs[order],
        unary=problem.unary[order],
        source_distances=problem.source_distances[np.ix_(back_rows, back_rows)],
        target_distances=problem.target_distances[np.ix_(back_columns, back_columns)],
    )


def with_triples(problem: LabellingProblem, seed: int, weight: float = 1.0) -> LabellingProblem:
    """Add random costs >= 0 on half of the triples of source points; many of them share pairs."""
    rng = np.random.default_rng(seed)
    triples = list(itertools.combinations(range(problem.n_sources), 3))
    points = sorted(triples[t] for t in rng.permutation(len(triples))[: (len(triples) + 1) // 2])
    sizes = np.diff(problem.first_candidate)
    tables = [weight * rng.random(sizes[list(triple)]) ** 3 for triple in points]
    chosen = np.array(points, dtype=np.int64).reshape(-1, 3)
    return replace(problem, triples=triple_costs(problem.first_candidate, chosen, tables))


def scaled(problem: LabellingProblem, factor: float) -> LabellingProblem:
    """The same problem with all costs times a factor."""
    terms, third = problem.terms, problem.triples
    return replace(
        problem,
        unary=factor * problem.unary,
        beta=factor * problem.beta,
        occlusion_cost=factor * problem.occlusion_cost,
        terms=replace(terms, costs=factor * terms.costs),
        triples=third._replace(costs=factor * third.costs),
    )
