"""The bijection of least distortion is that of brute force, of both other exact solvers."""

from itertools import permutations

import numpy as np
import pytest

from solver.arrays import FloatArray, IntArray
from solver.matching import Level, SampledStructure
from solver.optimisation.exact import m_best_solutions, minimax_correspondence
from solver.shape.choices import Geodesic, HeatKernelSignature
from solver.similarity.qap import MAX_POINTS, QapSolutions, least_distortions

_PAIR = np.array([[0, 1]])


def _metric(random: np.random.Generator, n: int) -> FloatArray:
    points = random.standard_normal((n, 3))
    distances: FloatArray = np.linalg.norm(points[:, None] - points[None], axis=2)
    return distances


def _problem(seed: int, n: int, kinds: int = 1) -> tuple[FloatArray, FloatArray]:
    """Two shapes: the second is the first one renumbered and distorted, more or less."""
    random = np.random.default_rng(seed)
    distances, descriptors = np.zeros((2, kinds, n, n)), random.random((2, kinds, n, 4))
    for kind in range(kinds):
        first, other = _metric(random, n), _metric(random, n)
        order = random.permutation(n)
        share = random.choice([0.0, 0.1, 1.0])
        distances[:, kind] = first, (1.0 - share) * first[np.ix_(order, order)] + share * other
    return distances, descriptors


def _deviation(descriptors: FloatArray) -> float:
    flat = descriptors.reshape(-1, descriptors.shape[-1])
    return float(np.sqrt(((flat - flat.mean(axis=0)) ** 2).sum(axis=1).mean()))


def _costs(
    distances: FloatArray, descriptors: FloatArray, weight: float, unit: float
) -> FloatArray:
    """Both costs of all bijections of the two shapes, in the order of :func:`permutations`."""
    n = len(distances[0])
    scale = np.sqrt((distances**2).sum() / (2 * n * (n - 1)))
    rows = []
    for order in permutations(range(n)):
        y = list(order)
        difference = distances[0] - distances[1][np.ix_(y, y)]
        first_order = np.linalg.norm(descriptors[0] - descriptors[1][y], axis=1).mean() / unit
        second_order = (difference**2).sum() / (n * (n - 1)) / scale**2
        rows.append((second_order + weight * first_order, np.abs(difference).max()))
    return np.array(rows)


def _solve(
    distances: FloatArray, descriptors: FloatArray, weight: float, minimax: bool
) -> tuple[float, IntArray]:
    contiguous = np.ascontiguousarray(distances), np.ascontiguousarray(descriptors)
    found = least_distortions(*contiguous, _PAIR, weight, minimax)
    return float(found.costs[0]), found.partners[0]


@pytest.mark.parametrize("n", [3, 4, 5, 6])
@pytest.mark.parametrize("weight", [0.0, 0.3])
def test_it_is_the_best_of_all_bijections(n: int, weight: float) -> None:
    for seed in range(12):
        distances, descriptors = _problem(seed, n)
        costs = _costs(distances[:, 0], descriptors[:, 0], weight, _deviation(descriptors))
        for minimax in (False, True):
            cost, partners = _solve(distances, descriptors, weight, minimax)
            every = costs[:, int(minimax)]
            where = list(permutations(range(n))).index(tuple(partners.tolist()))
            assert cost == pytest.approx(every.min(), abs=1e-12)
            assert every[where] == pytest.approx(every.min(), abs=1e-12)


def test_constant_descriptors_cost_nothing() -> None:
    """Rounding noise is not divided by itself, neither here nor in a match."""
    random = np.random.default_rng(0)
    distances = np.stack([_metric(random, 6)] * 2)[:, None]
    descriptors = 0.3 + random.choice([-1e-16, 0.0, 1e-16], (2, 1, 6, 2))
    assert np.ptp(descriptors) > 0.0
    assert _solve(distances, descriptors, 1.0, False)[0] == 0.0
    ours, theirs = (
        SampledStructure(np.arange(6), distances[k, 0], descriptors[k, 0]) for k in range(2)
    )
    level = Level(0, Geodesic(), HeatKernelSignature(), ours, theirs, 1.0, 0.05, np.inf)
    assert not level.problem(level.all_candidates()).unary.any()


@pytest.mark.parametrize("n", [8, MAX_POINTS])
def test_it_agrees_with_the_solvers_of_a_match(n: int) -> None:
    for seed in range(4):
        distances, descriptors = _problem(seed, n)
        first, second = (
            SampledStructure(np.arange(n), distances[k, 0], descriptors[k, 0]) for k in range(2)
        )
        level = Level(0, Geodesic(), HeatKernelSignature(), first, second, 1.0, 0.05, np.inf)
        exact = m_best_solutions(level.problem(level.all_candidates()))
        assert exact.proven
        cost, _ = _solve(distances, descriptors, 0.05, False)
        assert cost == pytest.approx(exact.energies[0] / n, rel=1e-9, abs=1e-12)
        least = minimax_correspondence(distances[0, 0], distances[1, 0])
        assert least.gap == 0.0
        assert _solve(distances, descriptors, 0.05, True)[0] == least.value


@pytest.mark.parametrize("minimax", [False, True])
def test_the_best_sampling_counts(minimax: bool) -> None:
    for seed in range(20):
        distances, descriptors = _problem(seed, 6, kinds=3)
        alone = []
        for kind in range(3):
            described = descriptors[:, kind : kind + 1]
            # Descriptors of all samplings have one unit.
            weight = 0.1 * _deviation(described) / _deviation(descriptors)
            alone.append(_solve(distances[:, kind : kind + 1], described, weight, minimax)[0])
        found = least_distortions(distances, descriptors, _PAIR, 0.1, minimax)
        assert found.costs[0] == pytest.approx(min(alone), rel=1e-12)
        assert alone[found.samplings[0]] == pytest.approx(min(alone), rel=1e-12)


@pytest.mark.parametrize("minimax", [False, True])
def test_renumbered_points_are_found_again_without_distortion(minimax: bool) -> None:
    random = np.random.default_rng(7)
    n = MAX_POINTS
    first, order = _metric(random, n), random.permutation(n)
    distances = np.stack([first[np.ix_(order, order)], first])[:, None]
    cost, partners = _solve(distances, np.zeros((2, 1, n, 0)), 0.0, minimax)
    assert cost == 0.0
    assert (partners == order).all()


@pytest.mark.parametrize("minimax", [False, True])
def test_equal_distances_take_no_time(minimax: bool) -> None:
    n = MAX_POINTS
    simplex = 1.0 - np.eye(n)
    distances = np.stack([simplex, simplex])[:, None]
    found = least_distortions(distances, np.zeros((2, 1, n, 0)), _PAIR, 0.0, minimax)
    assert found.costs[0] == 0.0
    assert found.nodes[0] <= 100


def test_pairs_do_not_depend_on_their_company() -> None:
    random = np.random.default_rng(3)
    distances = np.stack([[_metric(random, 7) for _ in range(3)] for _ in range(5)])
    descriptors = random.random((5, 3, 7, 2))
    pairs = np.stack(np.triu_indices(5, 1), axis=1)
    whole = least_distortions(distances, descriptors, pairs, 0.2, False)
    for place, pair in enumerate(pairs):
        alone: QapSolutions = least_distortions(distances, descriptors, pair[None], 0.2, False)
        assert alone.costs[0] == whole.costs[place]
        assert (alone.partners[0] == whole.partners[place]).all()
        turned = least_distortions(distances, descriptors, pair[None, ::-1].copy(), 0.2, False)
        assert turned.costs[0] == pytest.approx(alone.costs[0], rel=1e-12)
