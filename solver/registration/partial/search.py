"""Search for the registration of a whole to a part that fits best, over scales and labellings."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.control import Control
from solver.registration.alignment import Alignment
from solver.registration.partial.alignment import WEIGHTS, PartSamples, align_to_part, find_pairs
from solver.registration.partial.candidates import SHARES, first_alignment, labelled_points
from solver.registration.partial.fit import PartFit, measure_part_fit, scale_of
from solver.registration.surface import Samples, smooth_surface
from solver.shape import Shape


@dataclass(frozen=True)
class PartStage:
    """Numbers of samples of the whole and of the part, sizes, and how many candidates are kept."""

    whole_samples: int
    part_samples: int
    sizes: tuple[int, ...]
    kept: int


COARSE = PartStage(200, 400, (8, 10, 12, 14, 17, 20), 24)
FINE = (PartStage(300, 600, (26, 33, 41, 50), 8), PartStage(750, 800, (60, 70, 85), 8))

_SAME = 0.05
"""Mean distance in space over √area between the images of candidates that are the same."""


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
    whole: Shape, part: Shape, control: Control, scale: float | None = None
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

    Returns
    -------
    Candidates that differ, the best first.

    Raises
    ------
    Cancelled
        Through `control`.
    """
    ours, theirs = smooth_surface(whole), smooth_surface(part)
    scales = [scale] if scale is not None else [1.0 / np.sqrt(share) for share in SHARES]
    kept = [
        (first_alignment(ours, theirs, points, one), one)
        for one in control.in_time(scales, least=1)
        for points in labelled_points(whole, part, one, control)
    ]
    found: list[PartCandidate] = []
    for stage in (COARSE, *FINE):
        whole_samples = ours.samples.first(stage.whole_samples)
        part_samples = PartSamples.of(theirs, stage.part_samples)
        found = [
            _register(whole_samples, part_samples, alignment, one, stage.sizes, scale is None)
            for alignment, one in control.in_time(kept, least=1)
        ]
        found = _ranked(found, ours.mesh.vertices, stage.kept)
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
    return PartCandidate(aligned, scale, fit, whole.vertices[pairs.back[:200]])


def _ranked(
    found: Sequence[PartCandidate], positions: FloatArray, most: int
) -> list[PartCandidate]:
    """Candidates that differ, the best first."""
    chosen: list[PartCandidate] = []
    for one in sorted(found, key=lambda one: one.fit.score):
        here = positions[one.partners]
        apart = (np.linalg.norm(positions[kept.partners] - here, axis=1).mean() for kept in chosen)
        if all(distance > _SAME for distance in apart):
            chosen.append(one)
        if len(chosen) == most:
            break
    return chosen
