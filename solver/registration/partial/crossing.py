"""Crossing of candidates of a part: each is taken where it fits better.

As :mod:`solver.registration.crossing`, but on the part: each of its points has a partner, whichever
candidate is taken there, while a point of the whole may have one with one candidate only.
"""

from collections.abc import Iterator, Sequence

import numpy as np

from solver.arrays import IntArray
from solver.control import Control
from solver.registration.crossing import GENERATIONS, Crossed, crossings, uncrossed
from solver.registration.partial.alignment import PartPairs, PartSamples, fit_to_part
from solver.registration.partial.choice import (
    PartCandidate,
    PartStage,
    PartTask,
    Start,
    ranked_parts,
    register_part_candidate,
)
from solver.registration.partial.fit import fit_at_part
from solver.registration.seams import neighbours_of
from solver.registration.surface import Samples

_SIZES = (14, 17, 20)
"""Numbers of eigenfunctions of a crossed candidate."""


def cross_parts(
    task: PartTask, candidates: Sequence[PartCandidate], stage: PartStage, control: Control
) -> list[PartCandidate]:
    """Cross candidates with one another for some generations.

    Parameters
    ----------
    task
        The surfaces; every point of the part has a partner.
    candidates
        The best first.
    stage
        In which they were found.
    control
        May cancel; past its deadline, fewer are crossed.

    Returns
    -------
    The best of all that differ, the best first.

    Raises
    ------
    Cancelled
        Through `control`.
    """
    samples = task.samples(stage)
    neighbours = neighbours_of(task.part.samples.first(stage.part_samples))
    found = list(candidates)
    crossed: Crossed = set()
    for _ in range(GENERATIONS):
        children = [
            register_part_candidate(task, samples, start, _SIZES)
            for start in control.in_time(_crossed(samples, neighbours, found, crossed))
        ]
        found = ranked_parts(task, [*found, *children], stage)
    return found


def _crossed(
    samples: tuple[Samples, PartSamples],
    neighbours: IntArray,
    candidates: Sequence[PartCandidate],
    crossed: Crossed,
) -> Iterator[Start]:
    """Yield the best candidates crossed with each of those that they are not crossed with yet."""
    whole, part = samples
    fits, partners = zip(
        *(fit_at_part(whole, part, one.alignment, one.scale) for one in candidates), strict=True
    )
    places = [whole.positions[back] for back in partners]
    parents = uncrossed(candidates, crossed)
    for first, second, taken in crossings(parents, fits, places, neighbours):
        scale = float(np.sqrt(candidates[first].scale * candidates[second].scale))
        back = np.where(taken, partners[second], partners[first])
        pairs = PartPairs.of_part(back, len(whole))
        yield fit_to_part(whole, part, pairs, scale, _SIZES[0]), scale
