"""Search for the registration of a whole to a part that fits best, over scales and labellings."""

from dataclasses import replace
from itertools import chain

import numpy as np

from solver.control import Control
from solver.registration.candidates import NO_LANDMARKS, Points
from solver.registration.partial.candidates import (
    OF_OVERLAP,
    OF_PART,
    alignment_by_distances,
    first_alignment,
    labelled_points,
)
from solver.registration.partial.choice import PartCandidate, PartStage, PartTask, choose_parts
from solver.registration.search import STAGE
from solver.registration.surface import smooth_surface
from solver.shape import Shape

FINEST = PartStage(750, 800, (60, 70, 85), 8)
"""Last stage of surfaces that overlap; its samples are those that parts are refined from, too."""

OF_PART_STAGES = (
    PartStage(200, 400, (8, 10, 12, 14, 17, 20), 40),
    PartStage(300, 600, (26, 33, 41, 50), 40),
)
"""Of a part. What fits best here is often wrong, so that as many are kept as can be refined: of
seven halves of bodies that had wrong answers, a right candidate was the first to 34th that differs
from those before it."""

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


def search_part(
    whole: Shape,
    part: Shape,
    control: Control,
    scale: float | None = None,
    entire: bool = True,
    landmarks: Points = NO_LANDMARKS,
    wholly: Points = NO_LANDMARKS,
) -> list[PartCandidate]:
    """Register the whole to the part from each labelling, in stages that keep the best.

    Parameters
    ----------
    whole, part
        The shapes.
    control
        May cancel; past its deadline, less is tried.
    scale
        √area of the whole over √area of the part; by default it is searched for.
    entire, landmarks, wholly
        As for :func:`.register_part`.

    Returns
    -------
    Candidates that differ and meet the landmarks, the best first. After them, of surfaces that
    overlap, others that began where they lie as wholes, and do not crowd out the former.

    Raises
    ------
    Cancelled
        Through `control`.
    """
    task = PartTask(smooth_surface(whole), smooth_surface(part), entire, scale is None, landmarks)
    how = OF_PART if entire else OF_OVERLAP
    scales = [scale] if scale is not None else [1.0 / np.sqrt(share) for share in how.shares]
    labellings = [
        (points, one)
        for one in control.in_time(scales, least=1)
        for points in labelled_points(whole, part, one, how, landmarks, control)
    ]
    starts = [(first_alignment(task.whole, task.part, *one), one[1]) for one in labellings]
    control.report(STAGE, 0.2)
    if not entire:
        populations = [starts]
        if len(wholly[0]):
            size = 1.0 if scale is None else scale
            populations.append([(first_alignment(task.whole, task.part, wholly, size), size)])
        overlapping = choose_parts(task, populations, OF_OVERLAP_STAGES, control)
        return list(chain.from_iterable(overlapping))
    samples = task.samples(OF_PART_STAGES[0])
    starts += [(alignment_by_distances((whole, part), samples, *one), one[1]) for one in labellings]
    return choose_parts(task, [starts], OF_PART_STAGES, control)[0]
