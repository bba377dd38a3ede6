"""Orientation stage of a match with a prototype: the hypothesis that agrees with an example.

Distributions of single distances (section 5) hardly distinguish left from right. Registrations of
the surfaces of similar examples do. Hypotheses come in; the chosen hypothesis comes out first.
"""

from collections.abc import Sequence

import numpy as np

from solver.arrays import IntArray
from solver.control import Control
from solver.matching import Hypothesis, Level, hypothesis_from_map, move_to_front
from solver.prototype.matching.surface_maps import map_points
from solver.prototype.prototype import Prototype
from solver.prototype.surfaces import SurfaceSpectra
from solver.shape import Shape

_NEAR = 0.3
"""Geodesic distance over √area within which the points of a hypothesis agree with their images,
chosen on generated shapes."""

_STAGE = "registration of examples"


def orient_by_examples(
    prototype: Prototype,
    target: Shape,
    hypotheses: Sequence[Hypothesis],
    levels: Sequence[Level],
    rho: float,
    control: Control,
    spectra: SurfaceSpectra,
) -> tuple[list[Hypothesis], tuple[str, ...]]:
    """Put the hypothesis first that agrees with the registration of an example's surface.

    It is the most likely hypothesis all of whose points are near their images. If there is none, a
    further hypothesis is begun at the images.

    Parameters
    ----------
    prototype
        With surfaces of examples.
    target
        The shape Y.
    hypotheses
        Refined to the finest level, the most likely first.
    levels
        Of the match.
    rho
        ρ of 4.1.
    control
        Reports progress and cancels; past its deadline, less is tried.
    spectra
        Computes or caches spectra of the surfaces.

    Returns
    -------
    The hypotheses and warnings.

    Raises
    ------
    Cancelled
        Through `control`.
    """
    finest, coarse = levels[-1], levels[0]
    with control.stage(_STAGE, 0.0):
        points = [one.vertices(finest) for one in hypotheses]
        found = map_points(prototype.surfaces, target, points, control, spectra=spectra)
    if found is None:
        unlike = "left and right could not be distinguished: the target is unlike all examples"
        return list(hypotheses), (unlike,)
    for place, one in enumerate(hypotheses):
        if _agrees(one, found.vertices, finest, target):
            return move_to_front(hypotheses, place), ()
    images = found.vertices[: len(coarse.source.vertices)]
    distances = target.metric("geodesic").distances(images)[:, coarse.target.vertices]
    return [hypothesis_from_map(levels, distances, hypotheses, rho, control), *hypotheses], ()


def _agrees(hypothesis: Hypothesis, images: IntArray, level: Level, target: Shape) -> bool:
    """Return whether all points of a hypothesis are near their images."""
    matched, partners = hypothesis.vertices(level)
    # Distances from the samples are known.
    between = target.metric("geodesic").distances(partners)
    apart = between[np.arange(len(matched)), images[matched]]
    return bool((apart <= _NEAR * target.size).all())
