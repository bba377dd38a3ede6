"""Where to change from one candidate to another: the minimum cut between two maps.

Each source sample takes its image from one of two candidates. The labels minimise

    Σ_i u_i(l_i) + Σ_ij w_ij [l_i ≠ l_j] + Σ_ij c [l_i = first, l_j = second],

where u is by how much a candidate fits worse there, the second sum is over neighbours on the
source, between which the image would jump, and the third over samples i and j that the first and
the second candidate send to the same place, which would be covered twice, and another not at all.
All pairs are submodular, so that a minimum cut finds the optimum (Kolmogorov and Zabih, IEEE TPAMI
26(2), 2004).
"""

import numpy as np
from scipy.spatial import KDTree

from solver.arrays import BoolArray, FloatArray, IntArray
from solver.optimisation.minimum_cut import minimum_cut
from solver.registration.confidence import RIGHT_ERROR
from solver.registration.surface import Samples

# Of jumps and of places covered twice, in what a sample changes the score by, times the number of
# samples. On generated pairs, half or twice of both change errors by a fiftieth; on
# bodies with glued parts, twice is worse by a half.
_JUMP = 10.0
"""Weight of a jump of √area between samples that are neighbours."""

_TWICE = 5.0
"""Weight of a place that is covered twice."""

_NEIGHBOURS = 6

_STEPS = 1000
"""Capacities are whole numbers of this part of a unit, so that equal cuts are told exactly."""


def neighbours_of(samples: Samples) -> IntArray:
    """(S, 6) nearest samples of each, by commute time."""
    scale = np.sqrt(np.maximum(samples.eigenvalues[1:], 1e-12))
    places = samples.eigenfunctions[:, 1:] / scale
    count = min(_NEIGHBOURS, len(samples) - 1)
    nearest = np.asarray(KDTree(places).query(places, count + 1)[1])
    return nearest[:, 1:]


def takes_second(
    worse: FloatArray, neighbours: IntArray, first: FloatArray, second: FloatArray
) -> BoolArray:
    """Return which samples take their image from the second of two candidates.

    Parameters
    ----------
    worse
        (S,) by how much the first fits worse than the second round each sample.
    neighbours
        (S, n) samples next to each.
    first, second
        (S, 3) images of both, in √area.
    """
    count = len(worse)
    one_end, other_end, every = count, count + 1, np.arange(count)
    here, there = np.repeat(every, neighbours.shape[1]), neighbours.ravel()
    apart = np.linalg.norm(first - second, axis=1)
    # Each edge is listed at both ends, with half of its weight.
    jump = 0.5 * _JUMP * 0.5 * (apart[here] + apart[there])
    distance, same = (np.asarray(one) for one in KDTree(second).query(first))
    # Within the error of a right answer, images are in the same place.
    twice = np.flatnonzero((distance < RIGHT_ERROR) & (apart > RIGHT_ERROR))
    tails = np.concatenate([here, there, twice, np.full(count, one_end), every])
    heads = np.concatenate([there, here, same[twice], every, np.full(count, other_end)])
    capacities = np.concatenate(
        [jump, jump, np.full(len(twice), _TWICE), np.maximum(-worse, 0.0), np.maximum(worse, 0.0)]
    )
    whole = np.round(_STEPS * capacities)
    _, keeps_first = minimum_cut(tails, heads, whole, one_end, other_end)
    return ~keeps_first[:count]
