"""Search for the registration of a whole to a part that fits best, over scales and labellings."""

import numpy as np

from solver.control import Control
from solver.registration.candidates import NO_LANDMARKS, Points
from solver.registration.choice import Candidate, choose
from solver.registration.partial.candidates import (
    alignment_by_distances,
    first_alignment,
    labelled_points,
)
from solver.registration.partial.task import PartTask
from solver.registration.search import STAGE


def search_part(task: PartTask, control: Control, wholly: Points = NO_LANDMARKS) -> list[Candidate]:
    """Register the whole to the part from each labelling, in stages that keep the best.

    Parameters
    ----------
    task
        The surfaces.
    control
        May cancel; past its deadline, less is tried.
    wholly
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
    shapes, kind, scale = task.shapes, task.partiality, task.scale
    labellings = [
        (points, begun)
        for one, begun in control.in_time(_scales(task), least=1)
        for points in labelled_points(*shapes, one, kind.labellings, task.landmarks, control)
    ]
    starts = [(first_alignment(task.whole, task.part, *one), one[1]) for one in labellings]
    control.report(STAGE, 0.2)
    if kind.by_distances:
        samples = task.sampled(kind.stages[0])
        starts += [(alignment_by_distances(shapes, samples, *one), one[1]) for one in labellings]
    found = choose(task, lambda samples: starts, kind.stages, control)
    if len(wholly[0]):
        size = 1.0 if scale is None else scale
        begun = [(first_alignment(task.whole, task.part, wholly, size), size)]
        found += choose(task, lambda samples: begun, kind.stages, control)
    return found


def _scales(task: PartTask) -> list[tuple[float, float]]:
    """Scales at which points are labelled, and at which the whole is displaced to these.

    Of surfaces that overlap, where few labellings are right, those of scales around a given one are
    tried as well: of seven generated pairs of a given scale, three are wrong with the labellings of
    one scale, and one with those of three. Of six parts, none is wrong with either.
    """
    around = [1.0 / np.sqrt(share) for share in task.partiality.labellings.shares]
    if task.scale is None:
        return [(one, one) for one in around]
    if task.partiality.entire:
        return [(task.scale, task.scale)]
    return [(task.scale * one, task.scale) for one in around]
