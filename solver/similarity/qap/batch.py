"""Quadratic assignment of many pairs of shapes, in the best of several samplings each."""

from typing import NamedTuple

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.kernel import kernel
from solver.shape.descriptors import descriptor_deviation
from solver.similarity.qap.bound import lower_bound
from solver.similarity.qap.problem import Search, load_problem, new_search
from solver.similarity.qap.search import solve


class QapSolutions(NamedTuple):
    """Optimal solutions of pairs of shapes, each proven.

    Parameters
    ----------
    costs
        (P,) least cost of each pair, over all samplings and all bijections.
    samplings
        (P,) the sampling that attains it.
    partners
        (P, N) point of the second shape for each point of the first, in that sampling.
    nodes
        (P,) search nodes visited.
    """

    costs: FloatArray
    samplings: IntArray
    partners: IntArray
    nodes: IntArray


def least_distortions(
    distances: FloatArray,
    descriptors: FloatArray,
    pairs: IntArray,
    first_order_weight: float,
    minimax: bool,
) -> QapSolutions:
    """Solve the quadratic assignment problem of each of many pairs of shapes.

    The samplings of a pair are searched in the order of their lower bounds. Time grows
    exponentially with N; six points take some 20 to 30 µs.

    Parameters
    ----------
    distances
        (K, S, N, N) metrics of K shapes between the points of S samplings.
    descriptors
        (K, S, N, m) descriptors at these points, m = 0 for none.
    pairs
        (P, 2) indices of shapes.
    first_order_weight
        Weight of the first-order term.
    minimax
        Whether the greatest distortion of a distance is minimised, in the unit of the distances
        and without descriptors. Otherwise the cost is the energy (5) for each point, with the
        weights of a match: the mean squared distortion of the distances, divided by the mean of
        the squared distances of both shapes, and the weight times the mean deviation of the
        descriptors, divided by their root mean square deviation on all K shapes: on two shapes that
        are both constant but for their meshes, it would be that of the meshes.

    Returns
    -------
    QapSolutions
    """
    shapes, samplings, n, m = descriptors.shape
    count = len(pairs)
    found = QapSolutions(
        np.zeros(count),
        np.zeros(count, dtype=np.int64),
        np.zeros((count, n), dtype=np.int64),
        np.zeros(count, dtype=np.int64),
    )
    unit = descriptor_deviation(descriptors.reshape(shapes * samplings * n, m))
    weight = 0.0 if minimax or unit == 0.0 else float(first_order_weight) / unit
    _compare(
        new_search(n),
        np.ascontiguousarray(distances),
        np.ascontiguousarray(descriptors),
        np.ascontiguousarray(pairs),
        weight,
        minimax,
        found,
    )
    return found


@kernel
def _compare(
    search: Search,
    distances: FloatArray,
    descriptors: FloatArray,
    pairs: IntArray,
    first_order_weight: float,
    minimax: bool,
    found: QapSolutions,
) -> None:
    """Solve all pairs, for each the sampling of the least bound first."""
    n, kinds = distances.shape[2], distances.shape[1]
    bounds = np.zeros(kinds)
    for p in range(len(pairs)):
        i, j = pairs[p, 0], pairs[p, 1]
        for k in range(kinds):
            weight = load_problem(
                search,
                distances[i, k],
                distances[j, k],
                descriptors[i, k],
                descriptors[j, k],
                first_order_weight,
                minimax,
            )
            bounds[k] = lower_bound(search, 0, weight, minimax, np.inf)
        least = np.inf
        for _ in range(kinds):
            k = 0
            for other in range(kinds):
                if bounds[other] < bounds[k]:
                    k = other
            if not bounds[k] < least:
                break
            bounds[k] = np.inf
            weight = load_problem(
                search,
                distances[i, k],
                distances[j, k],
                descriptors[i, k],
                descriptors[j, k],
                first_order_weight,
                minimax,
            )
            cost, nodes = solve(search, weight, minimax, least)
            found.nodes[p] += nodes
            if cost < least:
                least = cost
                found.costs[p] = cost
                found.samplings[p] = k
                for x in range(n):
                    found.partners[p, x] = search.best[x]
