"""Branching: a region is divided by the place of the partner of one source point."""

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.kernel import kernel
from solver.labelling import UNMATCHED, LabellingProblem
from solver.optimisation.regions.region import Region

_WAYS = 3
"""Clusters of target points that the labels of a source point are divided into."""


def divide_region(problem: LabellingProblem, region: Region, limit: float) -> list[Region]:
    """Divide a region into disjoint ones by the labels of one source point.

    The labels are divided into clusters of near target points, so that each part fixes the place of
    the source point roughly; staying unmatched is a part of its own.

    Parameters
    ----------
    problem
        The labelling problem.
    region
        A region in which some source point has several labels.
    limit
        Bound from which on a label is of no interest.

    Returns
    -------
    Regions that contain every correspondence of the given one, none with all of its labels.
    """
    x = _point_to_divide(problem, region, limit)
    here = slice(region.rows[x], region.rows[x + 1])
    clusters = _clusters(problem, region.labels[here], region.bounds[here])
    parts = []
    for cluster in range(int(clusters.max()) + 1):
        kept = np.ones(len(region.labels), dtype=np.bool_)
        kept[here] = clusters == cluster
        parts.append(region.among(kept))
    return parts


def _point_to_divide(problem: LabellingProblem, region: Region, limit: float) -> int:
    """Source point with few labels of interest that lie far apart.

    A label weighs the margin that its bound leaves below the limit. The sum of the weights is
    divided by a power of the mean distance of two labels, drawn by their weights; the power 3/2 was
    chosen on a few pairs of animals and people.
    """
    best, least = -1, np.inf
    for x, (first, last) in enumerate(zip(region.rows[:-1], region.rows[1:], strict=True)):
        if last - first < 2:
            continue
        labels = region.labels[first:last]
        weights = np.maximum(limit - region.bounds[first:last], 0.0)
        score = _scatter(problem, labels, weights)
        if score < least or best < 0:
            best, least = x, score
    return best


def _scatter(problem: LabellingProblem, labels: IntArray, weights: FloatArray) -> float:
    """Weight of some labels over a power of their mean distance; ``inf`` for one place."""
    matched = labels != UNMATCHED
    total, weights = float(weights.sum()), weights[matched]
    places = problem.candidates[labels[matched], 1]
    apart = _weighted_distances(problem.target_distances, places, weights)
    if not apart > 0.0:
        return np.inf
    mean = apart / float(weights.sum()) ** 2
    return total / float(mean**1.5)


@kernel
def _weighted_distances(distances: FloatArray, places: IntArray, weights: FloatArray) -> float:
    """Sum of the distances of every two places times both weights.

    A matrix product would add in an order that depends on the processor, and points that a symmetry
    takes to one another tie.
    """
    total = 0.0
    for i in range(len(places)):
        row, part = distances[places[i]], 0.0
        for j in range(i):
            part += weights[j] * row[places[j]]
        total += 2.0 * weights[i] * part
    return total


def _clusters(problem: LabellingProblem, labels: IntArray, bounds: FloatArray) -> IntArray:
    """(K,) cluster of each label: its nearest of a few that lie far apart, the best one first."""
    clusters = np.zeros(len(labels), dtype=np.int64)
    matched = np.flatnonzero(labels != UNMATCHED)
    places = problem.candidates[labels[matched], 1]
    apart = problem.target_distances[np.ix_(places, places)]
    chosen = [int(np.argmin(bounds[matched]))] if len(matched) else []
    while 0 < len(chosen) < min(_WAYS, len(matched)):
        distance = apart[chosen].min(axis=0)
        distance[chosen] = -1.0
        chosen.append(int(np.argmax(distance)))
    if chosen:
        nearest = np.argmin(apart[chosen], axis=0)
        nearest[chosen] = np.arange(len(chosen))  # even if they coincide
        clusters[matched] = nearest
    clusters[labels == UNMATCHED] = len(chosen)
    return clusters
