"""Fit of a displaced whole to a part of it: as :mod:`solver.registration.fit`, where they meet.

Where surfaces only overlap, the fit of a small patch is always good: what has no partner is charged
with the score of an occlusion. Of a part, every point has a partner, and nothing is charged.
"""

from dataclasses import replace

import numpy as np

from solver.arrays import BoolArray, FloatArray, IntArray
from solver.registration.alignment import Alignment
from solver.registration.fit import Fit, numbered, strain
from solver.registration.partial.alignment import (
    IN_SPACE,
    WEIGHTS,
    PartSamples,
    embed,
    find_pairs,
)
from solver.registration.surface import Samples, SmoothSurface
from solver.registration.surface_map import Images, SurfaceMap, points_in_triangles

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


def measure_part_fit(whole: Samples, part: PartSamples, alignment: Alignment, scale: float) -> Fit:
    """Measure the fit of a displaced whole to a part.

    Parameters
    ----------
    whole, part
        Samples.
    alignment
        Of them.
    scale
        √area of the whole in the part's unit.

    Returns
    -------
    The fit, whose measures are 0 where the part was cut out of the whole:

    ``apart``
        mean distance of the part from the whole in the embedding, over √area of the part;
    ``turned``
        root mean square distance of unit normals;
    ``sheared``, ``stretched``
        as of :func:`.measure_fit`, where the whole is covered;
    ``bent``, for each diffusion time
        mean change of the average curvature, which cuts change little, over its mean deviation from
        the median on the whole.
    """
    pairs = find_pairs(whole, part, alignment, scale, IN_SPACE, _FIT_DISTANCE)
    back = pairs.back[pairs.met]
    if not len(back):
        nothing = dict.fromkeys(("apart", "turned", "sheared", "stretched"), 1.0)
        return Fit(nothing, share=0.0, occlusion=_OCCLUSION)
    apart, turned = _apart_and_turned(whole, part, alignment, scale, pairs.back)
    bent = _bent(whole, part, scale, pairs.back)
    met = np.bincount(back, minlength=len(whole)) + pairs.covered
    sheared, stretched = strain(whole, alignment, scale)
    shares = float(pairs.covered.mean()), float(pairs.met.mean())
    values = {
        "apart": float(apart[pairs.met].mean()),
        "turned": float(np.sqrt(2.0 * max(turned[pairs.met].mean(), 0.0))),
        "sheared": float(np.sqrt(2.0 * (met * sheared).sum() / met.sum())),
        "stretched": float((met * np.abs(stretched)).sum() / met.sum()),
        **numbered("bent", bent[pairs.met].mean(axis=0).tolist()),
    }
    share = 1.0 if part.entire else mean_share(*shares, scale)
    return Fit(values, share=share, occlusion=_OCCLUSION)


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


def measure_refined_part(
    displaced: SurfaceMap, back: Images, met: BoolArray, strained: float, share: float
) -> Fit:
    """Measure the fit of a whole that was displaced as rigidly as possible.

    It tells candidates apart that eigenfunctions fit equally well.

    Parameters
    ----------
    displaced
        The displaced whole.
    back
        Images of all W vertices of the part.
    met
        (W,) those that have a partner.
    strained
        Mean strain of the edges of the whole.
    share
        As of :class:`.Fit`.

    Returns
    -------
    The fit, whose measures are 0 for a part cut out of the whole:

    ``apart``
        mean distance of the part from the displaced whole, over √area of the part;
    ``turned``
        root mean square distance of unit normals;
    ``strained``
        as given.
    """
    if not met.any():
        return Fit(
            {"apart": 1.0, "turned": 1.0, "strained": 1.0}, share=0.0, occlusion=_REFINED_OCCLUSION
        )
    vertices, faces, barycentric = back
    part = displaced.target
    there = points_in_triangles(displaced.positions, displaced.source, faces[met], barycentric[met])
    cosines = (displaced.normals[vertices[met]] * part.normals[met]).sum(axis=1)
    values = {
        "apart": float(np.linalg.norm(there - part.mesh.vertices[met], axis=1).mean()),
        "turned": float(np.sqrt(2.0 * max(1.0 - cosines.mean(), 0.0))),
        "strained": strained,
    }
    return Fit(values, share=share, occlusion=_REFINED_OCCLUSION)


def score_as_wholes(fit: Fit) -> float:
    """Score of a refined fit where both surfaces are expected to be whole."""
    return replace(fit, occlusion=_WHOLE_OCCLUSION).score


def changes_of_curvature(
    whole: SmoothSurface,
    part: SmoothSurface,
    vertices: IntArray,
    images: IntArray,
    scale: float,
) -> dict[str, float]:
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
    The measure ``bent`` for each diffusion time; none where there are no vertices.
    """
    if not len(vertices):
        return {}
    here = part.averages.standardised_by(whole.averages, scale, vertices)
    changes = np.abs(whole.averages.standardised[images] - here).mean(axis=0)
    return numbered("bent", changes.tolist())
