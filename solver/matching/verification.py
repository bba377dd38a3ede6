"""Verification of hypotheses by points that were not matched.

Where a body is nearly symmetric, crossing its front legs but not its hind legs changes distances
between the few matched points by less than bending does, and by less than samples that are not
images of one another. But it tears the flanks: what lies there was near to two legs of its own
side. So each hypothesis carries further points along, and how these are distorted says more of it
than its own points do.
"""

from dataclasses import dataclass
from typing import Self

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.labelling import UNMATCHED
from solver.matching.hypotheses import Hypothesis
from solver.matching.level import Level
from solver.shape import Shape, heat_images, lengths_by_heat, spread_in_space

_WITNESSES, _PLACES = 32, 256
"""Points of the source that are carried along, and points of the target that they may go to."""
_TIME = 0.015
"""Of diffusion, over the area: short enough that the two sides of a body are apart."""
_WEIGHT = 8.0
"""Of their distortion: placed where it is least, they are distorted an order less than points."""


@dataclass(frozen=True, eq=False)
class Witnesses:
    """Points of two shapes that are not matched, as heat sees them.

    Parameters
    ----------
    time
        t of Varadhan's formula, in the shapes' unit of area.
    source, target
        (W, k) and (P, k) images of the points of X, and of where they may go on Y:
        :func:`solver.shape.metrics.heat_images`.
    among, places
        (W, W) and (P, P) lengths between them.
    unit
        Mean square of the former.
    """

    time: float
    source: FloatArray
    target: FloatArray
    among: FloatArray
    places: FloatArray
    unit: float

    @classmethod
    def of(cls, source: Shape, target: Shape) -> Self:
        """Spread points over two shapes.

        Parameters
        ----------
        source, target
            The shapes X and Y.
        """
        time = _TIME * source.size * target.size
        ours, theirs = (
            heat_images(shape.spectrum(), _spread(shape, count), time)
            for shape, count in ((source, _WITNESSES), (target, _PLACES))
        )
        among, places = (lengths_by_heat(images, images, time) for images in (ours, theirs))
        return cls(time, ours, theirs, among, places, float((among**2).mean()) or 1.0)

    def distortion(self, source: FloatArray, target: FloatArray) -> float:
        """Mean squared distortion of lengths of the witnesses where matched points put them.

        Each goes where its lengths to the matched points are preserved best, and then where those
        to all other witnesses are as well.

        Parameters
        ----------
        source, target
            (K, k) images of matched points of X and of their partners on Y.

        Returns
        -------
        Of lengths to the matched points and of lengths among the witnesses, each relative to the
        latter's mean square, together.
        """
        known = lengths_by_heat(self.source, source, self.time)
        there = lengths_by_heat(self.target, target, self.time)
        chosen = _most_alike(known, there)
        chosen = _most_alike(
            np.hstack([known, self.among]), np.hstack([there, self.places[:, chosen]])
        )
        to_matched = known - there[chosen]
        to_others = self.among - self.places[np.ix_(chosen, chosen)]
        return float(((to_matched**2).mean() + (to_others**2).mean()) / self.unit)


def verified(
    hypotheses: list[Hypothesis], finest: Level, source: Shape, target: Shape
) -> list[Hypothesis]:
    """Put hypotheses in the order in which the rest of the surface agrees with them.

    Parameters
    ----------
    hypotheses
        Carried to the finest level.
    finest
        That level.
    source, target
        The shapes X and Y.

    Returns
    -------
    By their energy (5) with the distortion of the witnesses, some times, in place of that of the
    matched points: what single points cost still counts, as of colours that tell left from right.
    """
    if len(hypotheses) < 2:
        return hypotheses
    witnesses = Witnesses.of(source, target)
    images = (
        heat_images(source.spectrum(), finest.source.vertices, witnesses.time),
        heat_images(target.spectrum(), finest.target.vertices, witnesses.time),
    )
    return sorted(hypotheses, key=lambda one: _energy(one, witnesses, images))


def _energy(
    hypothesis: Hypothesis, witnesses: Witnesses, images: tuple[FloatArray, FloatArray]
) -> float:
    """Energy with the witnesses' distortion in place of that of the matched points."""
    problem, partners = hypothesis.stages[-1].problem, hypothesis.partners
    matched = np.flatnonzero(partners != UNMATCHED)
    left = len(partners) - len(matched)
    energy = left * problem.occlusion_cost if left else 0.0
    if len(matched):
        energy += float(problem.unary_matrix[matched, partners[matched]].sum())
        pairs = len(matched) * (len(matched) - 1) / 2
        mean = witnesses.distortion(images[0][matched], images[1][partners[matched]])
        energy += _WEIGHT * problem.beta * pairs * mean
    return energy


def _spread(shape: Shape, count: int) -> IntArray:
    return spread_in_space(shape.surface.vertices, min(count, shape.n_vertices))


def _most_alike(rows: FloatArray, others: FloatArray) -> IntArray:
    """Of each of the rows, which of others is nearest."""
    squares = (others**2).sum(axis=1) - 2.0 * rows @ others.T
    nearest: IntArray = squares.argmin(axis=1)
    return nearest
