"""Fit of a displaced whole to a part of it: as :mod:`solver.registration.fit`, where they meet.

Where surfaces only overlap, the fit of a small patch is always good: what has no partner is charged
with the score of an occlusion. Of a part, every point has a partner, and nothing is charged.
"""

from dataclasses import dataclass

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.registration.alignment import Alignment
from solver.registration.fit import Measures, strain
from solver.registration.partial.alignment import (
    IN_SPACE,
    WEIGHTS,
    PartSamples,
    embed,
    find_pairs,
)
from solver.registration.surface import Samples, SmoothSurface

_FIT_DISTANCE = 0.05
"""Distance over √area of the whole within which a point's partner's partner is near it, where the
fit of surfaces that overlap is measured. With `PARTNER_DISTANCE`, more wrong candidates cover as
much as right ones."""

_OCCLUSION = -5.0
_REFINED_OCCLUSION = -10.0
"""Scores of what has no partner, before and after the refinement: somewhat more than those of what
has one. If more is charged, wrong candidates are preferred that cover more."""

_WHOLE_OCCLUSION = -7.0
"""The same after the refinement, between the candidate that fits best and the one that lies as both
do as wholes: most surfaces lack little, so that more is charged. Of 11 pairs where one of the two
is right and the other far off, all are told apart by -7.6 to -5.5, and seven by -10."""


@dataclass(frozen=True)
class PartFit(Measures):
    """Measures of a displaced whole and a part, each 0 where the part was cut out of the whole.

    Parameters
    ----------
    apart
        Mean distance of the part from the whole in the embedding, over √area of the part.
    turned
        Root mean square distance of unit normals.
    sheared, stretched
        As of :class:`.Fit`, where the whole is covered.
    bent
        For each diffusion time, mean change of the average curvature, which cuts change little,
        over its mean deviation from the median on the whole.
    share
        Share of both areas that has a partner, if the surfaces only overlap; 1 of a part.
    """

    apart: float
    turned: float
    sheared: float
    stretched: float
    bent: tuple[float, ...]
    share: float = 1.0

    @property
    def score(self) -> float:
        """Sum of the logarithms of the measures, where something is met; the less, the better."""
        return _with_occlusion(super().score, self.share, _OCCLUSION)


def measure_part_fit(
    whole: Samples, part: PartSamples, alignment: Alignment, scale: float
) -> PartFit:
    """Measure the fit of a displaced whole to a part.

    Parameters
    ----------
    whole, part
        Samples.
    alignment
        Of them.
    scale
        √area of the whole in the part's unit.
    """
    pairs = find_pairs(whole, part, alignment, scale, IN_SPACE, _FIT_DISTANCE)
    back = pairs.back[pairs.met]
    if not len(back):
        return PartFit(1.0, 1.0, 1.0, 1.0, (), 0.0)
    apart, turned = _apart_and_turned(whole, part, alignment, scale, pairs.back)
    bent = _bent(whole, part, scale, pairs.back)
    met = np.bincount(back, minlength=len(whole)) + pairs.covered
    sheared, stretched = strain(whole, alignment, scale)
    shares = float(pairs.covered.mean()), float(pairs.met.mean())
    return PartFit(
        float(apart[pairs.met].mean()),
        float(np.sqrt(2.0 * max(turned[pairs.met].mean(), 0.0))),
        float(np.sqrt(2.0 * (met * sheared).sum() / met.sum())),
        float((met * np.abs(stretched)).sum() / met.sum()),
        tuple(bent[pairs.met].mean(axis=0).tolist()),
        1.0 if part.entire else mean_share(*shares, scale),
    )


def _apart_and_turned(
    whole: Samples, part: PartSamples, alignment: Alignment, scale: float, back: IntArray
) -> tuple[FloatArray, FloatArray]:
    """(M,) distances of the part's samples from theirs, and half of those of normals, squared."""
    ours, theirs = embed(whole, part, alignment, scale, IN_SPACE)
    apart: FloatArray = np.linalg.norm(ours[back] - theirs, axis=1) * scale
    normals = whole.surface(alignment.coefficients)[1][back]
    return apart, 1.0 - (normals * part.normals).sum(axis=1)


def _bent(whole: Samples, part: PartSamples, scale: float, back: IntArray) -> FloatArray:
    """(M, m) changes of standardised curvatures from the part's samples to theirs."""
    there, here = part.curvatures(whole, scale)
    return np.abs(there[back] - here)


def _with_occlusion(score: float, share: float, occlusion: float) -> float:
    """Mean score over the area: what has no partner has the score of the occlusion."""
    return share * score + (1.0 - share) * occlusion


def mean_share(whole: float, part: float, scale: float) -> float:
    """Share of the area of both surfaces together, from the share of each.

    Parameters
    ----------
    whole, part
        The shares.
    scale
        √area of the whole in the part's unit.
    """
    area = scale**2
    return (area * whole + part) / (area + 1.0)


def scale_of(whole: Samples, part: PartSamples, alignment: Alignment, scale: float) -> float:
    """√area of the whole in the part's unit: median stretch of the whole at all pairs."""
    pairs = find_pairs(whole, part, alignment, scale, WEIGHTS)
    every = np.append(np.flatnonzero(pairs.covered), pairs.back[pairs.met])
    _, stretched = strain(whole, alignment, scale)
    return scale * float(np.exp(0.5 * np.median(stretched[every])))


@dataclass(frozen=True)
class RefinedPartFit(Measures):
    """Measures of a whole that was displaced as rigidly as possible, each 0 for a part cut out.

    They tell candidates apart that eigenfunctions fit equally well.

    Parameters
    ----------
    apart
        Mean distance of the part from the displaced whole, over √area of the part.
    turned
        Root mean square distance of unit normals.
    strained
        Mean strain of the edges of the whole.
    bent
        As of :class:`PartFit`; empty where it is not measured.
    distorted
        Mean change of distances between near points of the part, as of :class:`.NearDistances`;
        ``None`` where it is not measured, as where the surfaces only overlap.
    share
        As of :class:`PartFit`.
    """

    apart: float
    turned: float
    strained: float
    bent: tuple[float, ...] = ()
    distorted: float | None = None
    share: float = 1.0

    @classmethod
    def of_nothing(cls) -> "RefinedPartFit":
        """Return the fit of surfaces of which nothing has a partner."""
        return cls(1.0, 1.0, 1.0, share=0.0)

    @property
    def score(self) -> float:
        """Sum of the logarithms of the measures, where something is met; the less, the better."""
        return _with_occlusion(super().score, self.share, _REFINED_OCCLUSION)

    @property
    def score_as_wholes(self) -> float:
        """The same where both are expected to be whole."""
        return _with_occlusion(super().score, self.share, _WHOLE_OCCLUSION)


def changes_of_curvature(
    whole: SmoothSurface,
    part: SmoothSurface,
    vertices: IntArray,
    images: IntArray,
    scale: float,
) -> tuple[float, ...]:
    """Mean changes of standardised curvatures from the part to the whole.

    Parameters
    ----------
    whole, part
        The surfaces.
    vertices, images
        (M,) vertices of the part, and those of the whole that they go to.
    scale
        √area of the whole in the part's unit.

    Returns
    -------
    One for each diffusion time; none where there are no vertices.
    """
    if not len(vertices):
        return ()
    here = part.averages.standardised_by(whole.averages, scale, vertices)
    return tuple(np.abs(whole.averages.standardised[images] - here).mean(axis=0).tolist())
