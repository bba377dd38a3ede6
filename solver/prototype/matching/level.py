"""Costs of matching a target with a prototype: equation (6)."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.labelling import NO_TABLE, LabellingProblem
from solver.matching import Level
from solver.prototype.mixtures import GaussianMixtures, likelihood_table
from solver.prototype.prototype import LearnedDescriptors, LearnedDistances, all_pairs


@dataclass(frozen=True, eq=False)
class PrototypeLevel(Level):
    """One level of a match with a prototype, whose source is the prototype's means.

    Parameters
    ----------
    learned_distances, learned_descriptors
        The prototype's distributions at this level.
    """

    learned_distances: LearnedDistances
    learned_descriptors: LearnedDescriptors | None

    def problem(self, candidates: IntArray) -> LabellingProblem:
        """Problem (6) on given candidates.

        A pair weighs 2/(N − 1), as in (5). Costs are negative log-likelihoods over their least
        values, so that the most likely partner costs 0. If all points are matched this adds a
        constant to the energy; otherwise γ is relative to it.

        Parameters
        ----------
        candidates
            (V, 2) indices into points and samples, in lexicographic order.
        """
        for earlier in self._problems:
            if np.array_equal(earlier.candidates, candidates):
                return earlier
        n, m = len(self.source.vertices), len(self.target.vertices)
        problem = LabellingProblem(
            candidates,
            self._unary(candidates),
            np.zeros((n, n)),
            np.zeros((m, m)),
            0.0,
            self.occlusion_cost,
            table=self._table(candidates),
        )
        self._problems.append(problem)
        return problem

    @cached_property
    def _problems(self) -> list[LabellingProblem]:
        """Problems so far: hypotheses often share all candidates, or nearly all."""
        return []

    @cached_property
    def _mixtures(self) -> GaussianMixtures:
        """Of the distances of the level's points: peaks of others are not computed."""
        n = len(self.source.vertices)
        return self.learned_distances.mixtures.first(n * (n - 1) // 2)

    def _known(self, candidates: IntArray) -> tuple[FloatArray, IntArray]:
        """Table of the problem that shares the most candidates, and their places in it."""
        width = len(self.target.vertices)
        keys = candidates @ np.array([width, 1])
        table, within = NO_TABLE, np.full(len(keys), -1)
        for earlier in self._problems:
            others = earlier.candidates @ np.array([width, 1])
            place = np.searchsorted(others, keys)
            place[~np.isin(keys, others, assume_unique=True)] = -1
            if (place >= 0).sum() > (within >= 0).sum():
                table, within = earlier.table, place
        return table, within

    def _table(self, candidates: IntArray) -> FloatArray:
        n, mixtures = len(self.source.vertices), self._mixtures
        roots = mixtures.roots[:, :, 0, 0]
        log_scales = mixtures.log_weights + np.log(roots) - 0.5 * np.log(2.0 * np.pi)
        background = self.learned_distances.log_background
        return likelihood_table(
            np.ascontiguousarray(candidates),  # else the kernel is compiled twice
            self.target.distances,
            log_scales,
            mixtures.means[:, :, 0],
            roots,
            np.logaddexp(mixtures.log_peaks, background),
            background,
            self.beta * 2.0 / max(n - 1, 1),
            *self._known(candidates),
        )

    def _unary(self, candidates: IntArray) -> FloatArray:
        x, y = candidates.T
        result: FloatArray = self.first_order_weight * self._descriptor_costs[x, y]
        return result

    @cached_property
    def _descriptor_costs(self) -> FloatArray:
        """(N, M) first-order costs of (6), unweighted."""
        n, m = len(self.source.vertices), len(self.target.vertices)
        learned, described = self.learned_descriptors, self.target.descriptors
        if learned is None or described is None:
            return np.zeros((n, m))
        everywhere = np.broadcast_to(described, (n, *described.shape))
        mixtures = learned.mixtures.first(n)
        densities = mixtures.log_density(everywhere)
        return negative_log_likelihoods(
            densities, mixtures.log_peaks[:, None], learned.log_background
        )


def negative_log_likelihoods(
    log_density: FloatArray, log_peak: FloatArray, log_background: float
) -> FloatArray:
    """Negative logarithm of a density plus background, over its least value.

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


def mean_distances(mixtures: GaussianMixtures, count: int) -> FloatArray:
    """(count, count) mean distances of the first points."""
    square = np.zeros((count, count))
    first, second = all_pairs(count)
    square[second, first] = square[first, second] = mixtures.averages[: len(first), 0]
    return square
