"""Extremities of two surfaces, matched in the ways that change the distances between them least.

Limbs that are glued together, or proportions that differ much, change the eigenfunctions and the
cheapest coarse correspondences; the ends of limbs remain ends. There are few of them, so that all
ways to match them can be tried.
"""

from itertools import permutations

import numpy as np

from solver.arrays import IntArray, RealArray
from solver.registration.candidates import Points
from solver.registration.surface import Samples, commute_times

_OURS, _THEIRS = 5, 8
"""Extremities of the source, and of the target; these are more, since an end of a limb may come
late there. Five and seven find the right answer for one pair of 28 less, six and seven for half as
many."""

_MATCHINGS = 400
"""Least distorted matchings that are returned, of 6,720. Most right ones are among 300."""


def matched_extremities(source: Samples, target: Samples) -> list[Points]:
    """Match extremities of the source to some of the target's in many ways.

    Parameters
    ----------
    source, target
        S and M samples.

    Returns
    -------
    Corresponding vertices, the least distorted matching first.
    """
    ours, here = _extremities(source, _OURS)
    theirs, there = _extremities(target, _THEIRS)
    count = min(len(ours), len(theirs))
    matchings = np.array(list(permutations(range(len(theirs)), count)))
    distances = there[matchings[:, :, None], matchings[:, None, :]]
    distortions = np.abs(distances - here[:count, :count]).sum(axis=(1, 2))
    best = np.argsort(distortions, kind="stable")[:_MATCHINGS]
    return [(ours[:count], theirs[matching]) for matching in matchings[best]]


def _extremities(samples: Samples, count: int) -> tuple[IntArray, RealArray]:
    """(n,) vertices, farthest first by commute time, and (n, n) distances between them."""
    distances = commute_times(samples, np.arange(len(samples)))
    chosen = [int(np.square(distances).sum(axis=1).argmax())]
    nearest = distances[chosen[0]]
    for _ in range(min(count, len(samples)) - 1):
        chosen.append(int(nearest.argmax()))
        nearest = np.minimum(nearest, distances[chosen[-1]])
    return samples.vertices[chosen], distances[np.ix_(chosen, chosen)]
