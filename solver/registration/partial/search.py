"""Search for the registration of a whole to a part that fits best, over scales and labellings."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.control import Control
from solver.registration.alignment import Alignment
from solver.registration.candidates import NO_LANDMARKS, Points
from solver.registration.choice import LANDMARK, SAME, missed
from solver.registration.partial.alignment import WEIGHTS, PartSamples, align_to_part, find_pairs
from solver.registration.partial.candidates import (
    OF_OVERLAP,
    OF_PART,
    first_alignment,
    labelled_points,
)
from solver.registration.partial.fit import PartFit, measure_part_fit, scale_of
from solver.registration.surface import Samples, SmoothSurface, smooth_surface
from solver.shape import Shape


@dataclass(frozen=True)
class PartStage:
    """A stage of the search.

    Parameters
    ----------
    whole_samples, part_samples
        Numbers of samples.
    sizes
        Numbers of eigenfunctions to go through.
    kept
        How many candidates are kept.
    same
        Mean distance in space over √area between the images of candidates that are the same.
    """

    whole_samples: int
    part_samples: int
    sizes: tuple[int, ...]
    kept: int
    same: float = SAME


FINEST = PartStage(750, 800, (60, 70, 85), 8)

OF_PART_STAGES = (
    PartStage(200, 400, (8, 10, 12, 14, 17, 20), 24),
    PartStage(300, 600, (26, 33, 41, 50), 8),
    FINEST,
)

OF_OVERLAP_STAGES = (
    PartStage(100, 200, (8, 10, 12), 200, same=0.1),
    PartStage(200, 400, (14, 17, 20), 100, same=0.1),
    PartStage(300, 600, (26, 33, 41, 50), 50, same=0.1),
    replace(FINEST, kept=24, same=0.1),
)
"""Of surfaces that overlap. Fewer labellings are right, so that there are more candidates, and more
that differ are kept: with 20 eigenfunctions, right ones of generated pairs are often behind 60 to
100 wrong ones, which cover more. Of 10 hard pairs, a candidate that is right where it covers is
kept for 10, and for 4 with 16 candidates at the end and `same` 0.05; it is not always chosen."""

_PARTNERS = 200
"""Samples of the part whose partners are compared."""


@dataclass(frozen=True, eq=False)
class PartCandidate:
    """A registered candidate.

    Parameters
    ----------
    alignment
        Of the whole to the part.
    scale
        √area of the whole in the part's unit.
    fit
        How well it fits.
    partners
        (M,) vertices of the whole of the first samples of the part.
    """

    alignment: Alignment
    scale: float
    fit: PartFit
    partners: IntArray


def search_part(
    whole: Shape,
    part: Shape,
    control: Control,
    scale: float | None = None,
    entire: bool = True,
    landmarks: Points = NO_LANDMARKS,
) -> list[PartCandidate]:
    """Register the whole to the part: coarsely from each labelling, the best ones finely.

    Parameters
    ----------
    whole, part
        The shapes.
    control
        May cancel; past its deadline, less is tried.
    scale
        √area of the whole over √area of the part; by default it is searched for.
    entire, landmarks
        As for :func:`.register_part`.

    Returns
    -------
    Candidates that differ and meet the landmarks, the best first.

    Raises
    ------
    Cancelled
        Through `control`.
    """
    ours, theirs = smooth_surface(whole), smooth_surface(part)
    how = OF_PART if entire else OF_OVERLAP
    scales = [scale] if scale is not None else [1.0 / np.sqrt(share) for share in how.shares]
    kept = [
        (first_alignment(ours, theirs, points, one), one)
        for one in control.in_time(scales, least=1)
        for points in labelled_points(whole, part, one, how, landmarks, control)
    ]
    found: list[PartCandidate] = []
    for stage in OF_PART_STAGES if entire else OF_OVERLAP_STAGES:
        whole_samples = ours.samples.first(stage.whole_samples)
        part_samples = PartSamples.of(theirs, stage.part_samples, entire)
        found = [
            _register(whole_samples, part_samples, alignment, one, stage.sizes, scale is None)
            for alignment, one in control.in_time(kept, least=1)
        ]
        found = _ranked(_met(found, ours, theirs, landmarks), ours.mesh.vertices, stage)
        kept = [(one.alignment, one.scale) for one in found]
    return found


def _register(
    whole: Samples,
    part: PartSamples,
    alignment: Alignment,
    scale: float,
    sizes: Iterable[int],
    rescaled: bool,
) -> PartCandidate:
    aligned = align_to_part(whole, part, alignment, scale, sizes)
    if rescaled:
        scale = scale_of(whole, part, aligned, scale)
    fit = measure_part_fit(whole, part, aligned, scale)
    pairs = find_pairs(whole, part, aligned, scale, WEIGHTS)
    return PartCandidate(aligned, scale, fit, whole.vertices[pairs.back[:_PARTNERS]])


def _met(
    found: Sequence[PartCandidate], whole: SmoothSurface, part: SmoothSurface, landmarks: Points
) -> list[PartCandidate]:
    """Candidates that meet the landmarks as well as any, or nearly so."""
    positions = part.mesh.vertices
    away = [missed(whole, positions, one.alignment, landmarks) / one.scale for one in found]
    least = min(away, default=0.0)
    return [one for one, apart in zip(found, away, strict=True) if apart <= least + LANDMARK]


def _ranked(
    found: Sequence[PartCandidate], positions: FloatArray, stage: PartStage
) -> list[PartCandidate]:
    """Candidates that differ, the best first."""
    chosen: list[PartCandidate] = []
    for one in sorted(found, key=lambda one: one.fit.score):
        here = positions[one.partners]
        apart = (np.linalg.norm(positions[kept.partners] - here, axis=1).mean() for kept in chosen)
        if all(distance > stage.same for distance in apart):
            chosen.append(one)
        if len(chosen) == stage.kept:
            break
    return chosen
