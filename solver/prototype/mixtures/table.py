"""Pairwise costs of (6), tabulated for all pairs of candidates.

Each mixture is evaluated at all its distances in one vectorised loop: a table of some 35,000
likelihoods takes less than a millisecond. Problems of one level share most candidates; their costs
are copied from an earlier table.
"""

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.kernel import inlined, kernel


@kernel
def likelihood_table(
    candidates: IntArray,
    distances: FloatArray,
    log_scales: FloatArray,
    means: FloatArray,
    roots: FloatArray,
    least: FloatArray,
    log_background: float,
    weight: float,
    known: FloatArray,
    within: IntArray,
) -> FloatArray:
    """Pairwise costs of (6), by log-sum-exp.

    Parameters
    ----------
    candidates
        (V, 2) points and samples, in lexicographic order.
    distances
        (M, M) d_Y among the samples.
    log_scales
        (P, K) logarithm of each component's weight times its density at its mean.
    means, roots
        (P, K) means, and inverses of standard deviations.
    least
        (P,) greatest log density, with the background, which is subtracted.
    log_background
        Log density of the background.
    weight
        Of every pair.
    known, within
        (W, W) a table of other candidates with the same distributions, and (V,) place of each
        candidate among these, -1 for none.

    Returns
    -------
    (V, V) float64, symmetric, at least 0; 0 where candidates exclude one another.
    """
    count = len(candidates)
    table = np.zeros((count, count))
    if count == 0:  # nothing was matched at the level before
        return table
    for a in range(count):
        if within[a] >= 0:
            before, after = known[within[a]], table[a]
            for b in range(count):
                if within[b] >= 0:
                    after[b] = before[within[b]]
    points = candidates[:, 0].max() + 1
    rows = np.searchsorted(candidates[:, 0], np.arange(points + 1))
    place = np.full((points, len(distances)), -1)
    for a in range(count):
        place[candidates[a, 0], candidates[a, 1]] = a
    most = np.diff(rows).max() ** 2
    listed, pairs = np.empty(most), np.empty((most, 2), dtype=np.int64)
    costs, greatest = np.empty(most), np.empty(most)
    for other in range(1, points):
        for x in range(other):
            p = other * (other - 1) // 2 + x
            number = _list_distances(
                candidates, distances, rows, place, within, (x, other), listed, pairs
            )
            _log_densities(
                listed[:number],
                log_scales[p],
                means[p],
                roots[p],
                log_background,
                greatest[:number],
                costs[:number],
            )
            for i in range(number):
                a, b = pairs[i]
                cost = weight * max(least[p] - costs[i], 0.0)
                table[a, b] = table[b, a] = cost
                one, two = place[x, candidates[b, 1]], place[other, candidates[a, 1]]
                if one >= 0 and two >= 0:
                    table[one, two] = table[two, one] = cost
    return table


@kernel
def _list_distances(
    candidates: IntArray,
    distances: FloatArray,
    rows: IntArray,
    place: IntArray,
    within: IntArray,
    points: tuple[int, int],
    listed: FloatArray,
    pairs: IntArray,
) -> int:
    """List the distances between the samples of two points, with their candidates; return how many.

    Pairs whose cost is known are left out. Exchanging two samples keeps their distance, so that one
    of two such pairs is listed.
    """
    x, other = points
    number = 0
    for a in range(rows[x], rows[x + 1]):
        y = candidates[a, 1]
        new = within[a] < 0
        for b in range(rows[other], rows[other + 1]):
            z = candidates[b, 1]
            if z == y or not (new or within[b] < 0):
                continue
            one, two = place[x, z], place[other, y]
            if z < y and one >= 0 and two >= 0 and (within[one] < 0 or within[two] < 0):
                continue
            listed[number] = distances[y, z]
            pairs[number, 0], pairs[number, 1] = a, b
            number += 1
    return number


@inlined
def _exponential(x: float) -> float:
    """Return exp(x) for x <= 0, to a few units in the last place of 1, without calls or branches.

    The Taylor polynomial of exp(x / 64), squared six times; exp(-40) for x < -40.
    """
    t = max(x, -40.0) / 64.0
    p = 1.0 / 5040.0 + t * (1.0 / 40320.0 + t * (1.0 / 362880.0))
    p = 1.0 / 24.0 + t * (1.0 / 120.0 + t * (1.0 / 720.0 + t * p))
    p = 1.0 + t * (1.0 + t * (0.5 + t * (1.0 / 6.0 + t * p)))
    p = p * p
    p = p * p
    p = p * p
    p = p * p
    p = p * p
    return p * p


@kernel
def _log_densities(
    distances: FloatArray,
    log_scales: FloatArray,
    means: FloatArray,
    roots: FloatArray,
    log_background: float,
    greatest: FloatArray,
    found: FloatArray,
) -> None:
    """Log densities of one mixture with its background; `greatest` is workspace."""
    count = len(distances)
    greatest[:] = log_background
    for k in range(len(means)):
        scale, mean, root = log_scales[k], means[k], roots[k]
        for i in range(count):
            apart = root * (distances[i] - mean)
            greatest[i] = max(greatest[i], scale - 0.5 * apart * apart)
    for i in range(count):
        found[i] = _exponential(log_background - greatest[i])
    for k in range(len(means)):
        scale, mean, root = log_scales[k], means[k], roots[k]
        for i in range(count):
            apart = root * (distances[i] - mean)
            found[i] += _exponential(scale - 0.5 * apart * apart - greatest[i])
    for i in range(count):
        found[i] = greatest[i] + np.log(found[i])
