"""Pairwise costs of (6), tabulated for all pairs of candidates.

A mixture is evaluated at all the distances it is asked for at once, in loops that compilers make
vector instructions of: a table of some 35,000 likelihoods takes less than a millisecond. Problems
of one level have most candidates in common: what an earlier table has is taken from there.
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
        (P,) what is subtracted: the greatest log density, background included.
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
    asked, pairs = np.empty(most), np.empty((most, 2), dtype=np.int64)
    costs, greatest = np.empty(most), np.empty(most)
    for other in range(1, points):
        for x in range(other):
            p = other * (other - 1) // 2 + x
            number = _ask(candidates, distances, rows, place, within, (x, other), asked, pairs)
            _log_densities(
                asked[:number],
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
def _ask(
    candidates: IntArray,
    distances: FloatArray,
    rows: IntArray,
    place: IntArray,
    within: IntArray,
    points: tuple[int, int],
    asked: FloatArray,
    pairs: IntArray,
) -> int:
    """Write the distances between two points' samples, and whose they are; return how many.

    Those of two candidates whose cost is known are not written. Exchanging two samples leaves their
    distance: of two such pairs of candidates one is written.
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
            asked[number] = distances[y, z]
            pairs[number, 0], pairs[number, 1] = a, b
            number += 1
    return number


@inlined
def _exponential(x: float) -> float:
    """Return exp(x) of x <= 0, to the last digits of 1, without a call or a branch.

    The Taylor polynomial of exp(x / 64), squared six times; of x < -40, exp(-40).
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
    """Log densities of one mixture with its background; `greatest` is room to work in."""
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
