"""Verification stage: hypotheses ranked by samples that were not matched.

Where a body is nearly symmetric, crossing its front legs but not its hind legs changes distances
between the few matched points by less than bending does, and by less than the error of sampling.
But it separates neighbouring points of the flanks. So each hypothesis maps
further samples of the source, and their distortion replaces that of the matched points.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.control import Control
from solver.labelling import UNMATCHED
from solver.matching.hypothesis import Hypothesis
from solver.matching.level import Level
from solver.shape import (
    Shape,
    embedded_varadhan_distances,
    euclidean_farthest_points,
    heat_kernel_embedding,
)

_SOURCE_SAMPLES, _TARGET_SAMPLES = 32, 256
"""Verification samples of X, and samples of Y that they may be mapped to. These and the next two
are chosen on generated shapes and measured by `python -m bench.points`."""

_TIME = 0.015
"""Diffusion time of Varadhan's formula, over the area: short enough to separate the two sides of a
body."""

_WEIGHT = 8.0
"""Weight of the samples' distortion. Their images are chosen to have the least, so that it is an
order of magnitude less than that of matched points."""


@dataclass(frozen=True, eq=False)
class VerificationSamples:
    """Samples of two shapes that are not matched, and Varadhan distances between them.

    Parameters
    ----------
    time
        t of Varadhan's formula, in the shapes' unit of area.
    source, target
        (S, k) and (T, k) heat embeddings of the samples of X and of Y, whose inner products give
        Varadhan distances: :func:`solver.shape.heat_kernel_embedding`.
    source_distances, target_distances
        (S, S) and (T, T) Varadhan distances among them.
    unit
        Mean square of the former.
    """

    time: float
    source: FloatArray
    target: FloatArray
    source_distances: FloatArray
    target_distances: FloatArray
    unit: float

    @classmethod
    def of(cls, source: Shape, target: Shape) -> Self:
        """Spread samples over two shapes.

        Parameters
        ----------
        source, target
            The shapes X and Y.
        """
        time = _TIME * source.size * target.size
        ours, theirs = (
            heat_kernel_embedding(shape.spectrum(), _spread(shape, count), time)
            for shape, count in ((source, _SOURCE_SAMPLES), (target, _TARGET_SAMPLES))
        )
        within_source, within_target = (
            embedded_varadhan_distances(embedded, embedded, time) for embedded in (ours, theirs)
        )
        unit = float((within_source**2).mean()) or 1.0
        return cls(time, ours, theirs, within_source, within_target, unit)

    def distortion(self, source: FloatArray, target: FloatArray) -> float:
        """Mean squared distortion of the samples' distances under a correspondence.

        Each sample of X is mapped to the sample of Y that preserves its distances to the matched
        points best, and once more, with its distances to all other samples of X as well.

        Parameters
        ----------
        source, target
            (K, k) heat embeddings of matched points of X and of their partners on Y.

        Returns
        -------
        Sum of the mean squared distortions of distances to the matched points and of distances
        among the samples, relative to the mean square of the latter on X.
        """
        known = embedded_varadhan_distances(self.source, source, self.time)
        there = embedded_varadhan_distances(self.target, target, self.time)
        chosen = _nearest_rows(known, there)
        chosen = _nearest_rows(
            np.hstack([known, self.source_distances]),
            np.hstack([there, self.target_distances[:, chosen]]),
        )
        to_matched = known - there[chosen]
        to_others = self.source_distances - self.target_distances[np.ix_(chosen, chosen)]
        return float(((to_matched**2).mean() + (to_others**2).mean()) / self.unit)


def verify(
    hypotheses: Sequence[Hypothesis], finest: Level, source: Shape, target: Shape, control: Control
) -> list[Hypothesis]:
    """Order hypotheses by their energy with the distortion of verification samples.

    In the energy (5), the weighted distortion of the verification samples replaces that of the
    matched points; first-order terms, as of colours that differ between left and right, remain.

    Parameters
    ----------
    hypotheses
        Refined to the finest level.
    finest
        That level.
    source, target
        The shapes X and Y.
    control
        Times the stage.

    Returns
    -------
    The same hypotheses, the best first.
    """
    if len(hypotheses) < 2:
        return list(hypotheses)
    with control.stage("refinement"):
        samples = VerificationSamples.of(source, target)
        embedded = (
            heat_kernel_embedding(source.spectrum(), finest.source.vertices, samples.time),
            heat_kernel_embedding(target.spectrum(), finest.target.vertices, samples.time),
        )
        return sorted(hypotheses, key=lambda one: _verified_energy(one, samples, embedded))


def _verified_energy(
    hypothesis: Hypothesis, samples: VerificationSamples, embedded: tuple[FloatArray, FloatArray]
) -> float:
    """Energy with the samples' distortion in place of that of the matched points."""
    problem, partners = hypothesis.levels[-1].problem, hypothesis.partners
    matched = np.flatnonzero(partners != UNMATCHED)
    unmatched = len(partners) - len(matched)
    energy = unmatched * problem.occlusion_cost if unmatched else 0.0
    if len(matched):
        energy += float(problem.unary_matrix[matched, partners[matched]].sum())
        pairs = len(matched) * (len(matched) - 1) / 2
        mean = samples.distortion(embedded[0][matched], embedded[1][partners[matched]])
        energy += _WEIGHT * problem.beta * pairs * mean
    return energy


def _spread(shape: Shape, count: int) -> IntArray:
    return euclidean_farthest_points(shape.surface.vertices, min(count, shape.n_vertices))


def _nearest_rows(rows: FloatArray, others: FloatArray) -> IntArray:
    """(R,) index of the nearest of the other rows to each row."""
    squares = (others**2).sum(axis=1) - 2.0 * rows @ others.T
    nearest: IntArray = squares.argmin(axis=1)
    return nearest
