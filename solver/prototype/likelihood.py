"""Costs of matching a target with a prototype: equation (6)."""

from dataclasses import dataclass

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.kernel import kernel
from solver.labelling import LabellingProblem
from solver.level import Level
from solver.pairwise import PairwiseTerms
from solver.prototype.mixture import GaussianMixtures
from solver.prototype.prototype import LearntDescriptors, LearntDistances, pair_places


@dataclass(frozen=True, eq=False)
class PrototypeLevel(Level):
    """One level of a match with a prototype, whose source is the prototype's means.

    Parameters
    ----------
    learnt_distances, learnt_descriptors
        The prototype's distributions at this level.
    """

    learnt_distances: LearntDistances
    learnt_descriptors: LearntDescriptors | None

    def problem(self, candidates: IntArray) -> LabellingProblem:
        """Problem (6) on given candidates.

        A pair weighs 2/(N − 1), as in (5). Of each log-likelihood its greatest value is
        subtracted, so that no cost is negative; if all points are matched this only adds a
        constant to the energy, and else it says what γ is compared with: a perfectly likely
        partner costs nothing.

        Parameters
        ----------
        candidates
            (V, 2) indices into points and samples, in lexicographic order.
        """
        n = len(self.source.vertices)
        terms = self._terms(candidates, self.beta * 2.0 / max(n - 1, 1))
        return LabellingProblem.explicit(
            (n, len(self.target.vertices)),
            candidates,
            self._unary(candidates),
            terms,
            self.occlusion_cost,
        )

    def _terms(self, candidates: IntArray, weight: float) -> PairwiseTerms:
        x, y = candidates.T
        one, two = np.triu_indices(len(candidates), 1)
        apart = (x[one] != x[two]) & (y[one] != y[two])
        one, two = one[apart], two[apart]
        costs = distance_costs(
            self.learnt_distances,
            pair_places(x[one], x[two]),
            self.target.distances[y[one], y[two]],
        )
        return PairwiseTerms(one.astype(np.int64), two.astype(np.int64), weight * costs)

    def _unary(self, candidates: IntArray) -> FloatArray:
        learnt, described = self.learnt_descriptors, self.target.descriptors
        if learnt is None or described is None or self.first_order_weight == 0.0:
            return np.zeros(len(candidates))
        n = len(self.source.vertices)
        mixtures = learnt.mixtures.first(n)
        points = np.broadcast_to(described, (n, *described.shape))
        costs = negative_log_likelihoods(
            mixtures.log_density(points), mixtures.log_peaks[:, None], learnt.log_background
        )
        x, y = candidates.T
        result: FloatArray = self.first_order_weight * costs[x, y]
        return result


def negative_log_likelihoods(
    log_density: FloatArray, log_peak: FloatArray, log_background: float
) -> FloatArray:
    """−log of a density with a background, less its least value.

    Parameters
    ----------
    log_density
        Of a mixture.
    log_peak
        Its greatest value.
    log_background
        Log density of the background.

    Returns
    -------
    float64, at least 0 and at most log(1 + exp(log_peak − log_background)).
    """
    least = np.logaddexp(log_peak, log_background)
    costs: FloatArray = np.maximum(least - np.logaddexp(log_density, log_background), 0.0)
    return costs


def distance_costs(learnt: LearntDistances, places: IntArray, distances: FloatArray) -> FloatArray:
    """Pairwise costs of (6) without their weight.

    Parameters
    ----------
    learnt
        The distributions.
    places
        (E,) of the prototype's pairs.
    distances
        (E,) on the target.

    Returns
    -------
    (E,) float64, at least 0.
    """
    m = learnt.mixtures
    log_scales = m.log_weights + np.log(m.roots[:, :, 0, 0]) - 0.5 * np.log(2.0 * np.pi)
    densities = _log_densities(log_scales, m.means[:, :, 0], m.roots[:, :, 0, 0], places, distances)
    return negative_log_likelihoods(densities, m.log_peaks[places], learnt.log_background)


@kernel
def _log_densities(
    log_scales: FloatArray,
    means: FloatArray,
    roots: FloatArray,
    places: IntArray,
    distances: FloatArray,
) -> FloatArray:
    """Log densities of one-dimensional mixtures, by log-sum-exp."""
    found = np.empty(len(places))
    count = means.shape[1]
    for e in range(len(places)):
        p = places[e]
        greatest = -np.inf
        for k in range(count):
            z = roots[p, k] * (distances[e] - means[p, k])
            greatest = max(greatest, log_scales[p, k] - 0.5 * z * z)
        total = 0.0
        for k in range(count):
            z = roots[p, k] * (distances[e] - means[p, k])
            total += np.exp(log_scales[p, k] - 0.5 * z * z - greatest)
        found[e] = greatest + np.log(total)
    return found


def mean_distances(mixtures: GaussianMixtures, count: int) -> FloatArray:
    """(count, count) mean distances of the first points."""
    means = (mixtures.weights * mixtures.means[:, :, 0]).sum(axis=1)
    square = np.zeros((count, count))
    second, first = np.tril_indices(count, -1)
    square[second, first] = square[first, second] = means[: len(first)]
    return square
