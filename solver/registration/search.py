"""Search for the candidate that fits best: from coarse to fine, and among others when in doubt."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from solver.arrays import FloatArray
from solver.control import Control
from solver.registration.alignment import Pairs
from solver.registration.candidates import Points, exchanged_pairs, first_pairs, varied_pairs
from solver.registration.choice import (
    COARSE,
    FINE,
    LANDMARK,
    Candidate,
    Start,
    Task,
    again,
    choose,
    ranked,
)
from solver.registration.confidence import CLOSE, SURE, Confidence, confidence_of
from solver.registration.crossing import cross
from solver.registration.surface import Samples

_KEPT = 16
"""Best candidates of the coarse stages that go through the fine ones."""

_ROUNDS = 2
"""How often, when in doubt, the best candidates of a population are varied and crossed; a third
time changes nothing."""

_VARIED = 3
"""Best candidates whose signs are varied."""


@dataclass(frozen=True, eq=False)
class Found:
    """What a search has found.

    Parameters
    ----------
    candidates
        Registered finely, those that differ, the best first.
    halfway
        All that were registered in the first of the fine stages.
    confidence
        In the best.
    """

    candidates: tuple[Candidate, ...]
    halfway: tuple[Candidate, ...]
    confidence: Confidence


def search(task: Task, hypotheses: Sequence[Points], control: Control) -> Found:
    """Register candidates coarsely, the best finely; when in doubt, vary and cross the best ones.

    Parameters
    ----------
    task
        The surfaces.
    hypotheses
        Corresponding vertices, as many as there are.
    control
        May cancel; past its deadline, less is tried.

    Raises
    ------
    Cancelled
        Through `control`.
    """

    def first(samples: tuple[Samples, Samples]) -> Iterator[Pairs]:
        return first_pairs((task.source, task.target), samples, hypotheses)

    found, halfway = _population(task, first, hypotheses, control)
    return Found(tuple(found), tuple(halfway), confidence_in(found, control))


def search_others(task: Task, known: Found, control: Control) -> Found:
    """Search another population, from exchanged eigenfunctions, if the best known is in doubt.

    Its candidates do not compete with those known: where hypotheses begin near a wrong answer, they
    are so many that they crowd the others out.

    Parameters
    ----------
    task, control
        As for :func:`search`.
    known
        What that has found.

    Raises
    ------
    Cancelled
        Through `control`.
    """
    if not _in_doubt(known.candidates, control):
        return known
    others, halfway = _population(task, exchanged_pairs, (), control)
    found = _joined(task, known.candidates, others)
    return Found(tuple(found), (*known.halfway, *halfway), confidence_in(found, control))


def _population(
    task: Task, first: Start, hypotheses: Sequence[Points], control: Control
) -> tuple[list[Candidate], list[Candidate]]:
    """Candidates registered finely, and those registered halfway."""
    coarse = choose(task, first, COARSE, control)
    found, halfway = _finely(task, coarse, control)
    for number in range(_ROUNDS):
        if not _in_doubt(found, control):
            break
        varied = choose(task, _variations(found[:_VARIED]), COARSE, control)
        if number == 0:
            varied += _from_the_target(task, hypotheses, control)
        coarse = cross(task, ranked([*coarse, *varied], task.positions), control)
        others, further = _finely(task, coarse, control)
        found, halfway = _joined(task, found, others), [*halfway, *further]
    return found, halfway


def _joined(task: Task, known: Sequence[Candidate], others: Sequence[Candidate]) -> list[Candidate]:
    further = ranked([*known, *others], task.positions)
    return unless_it_is_close(known[0], further, task.positions)


def unless_it_is_close(
    known: Candidate, found: Sequence[Candidate], positions: FloatArray
) -> list[Candidate]:
    """Candidates with a known one first, unless another one is clearly better.

    Of many candidates, some wrong ones fit nearly as well as the right one by chance: the more are
    tried, the more of them. Where the known one was dropped for one that is the same but fits
    better, that one stands for it.

    Parameters
    ----------
    known
        The best candidate so far.
    found
        Candidates that differ, the best first; one of them is the known one, or the same.
    positions
        (V, 3) vertices of the target, at √area 1.
    """
    best = found[0]
    same = next(one for one in found if len(ranked([one, known], positions)) == 1)
    close = best.fit.score > same.fit.score - CLOSE and same.missed <= best.missed + LANDMARK
    return [same, *(one for one in found if one is not same)] if close else list(found)


def _variations(candidates: Sequence[Candidate]) -> Start:
    alignments = [one.alignment for one in candidates]
    return lambda samples: varied_pairs(samples, alignments)


def _from_the_target(task: Task, hypotheses: Sequence[Points], control: Control) -> list[Candidate]:
    """Candidates found by bending the target onto the source: others than the other way round."""
    turned = task.swapped()

    def first(samples: tuple[Samples, Samples]) -> Iterator[Pairs]:
        swapped = [(there, here) for here, there in hypotheses]
        return first_pairs((turned.source, turned.target), samples, swapped)

    found = choose(turned, first, COARSE, control)

    def back(samples: tuple[Samples, Samples]) -> Iterator[Pairs]:
        pairs = again(found, COARSE[-1].weights)(samples[::-1])
        return (Pairs(one.back, one.images) for one in pairs)

    return choose(task, back, COARSE[-1:], control)


def _finely(
    task: Task, coarse: Sequence[Candidate], control: Control
) -> tuple[list[Candidate], list[Candidate]]:
    every = replace(FINE[0], kept=_KEPT)
    halfway = choose(task, again(coarse[:_KEPT], every.weights), (every,), control)
    return register_finely(task, halfway[: FINE[0].kept], control), halfway


def register_finely(task: Task, halfway: Sequence[Candidate], control: Control) -> list[Candidate]:
    """Register candidates in the last of the fine stages.

    Parameters
    ----------
    task
        The surfaces.
    halfway
        Candidates after the stage before.
    control
        May cancel; past its deadline, one is registered.

    Returns
    -------
    Those that differ, the best first.
    """
    return choose(task, again(halfway, FINE[-1].weights), FINE[-1:], control)


def _in_doubt(found: Sequence[Candidate], control: Control) -> bool:
    return not control.expired and confidence_in(found, control).probability < SURE


def confidence_in(found: Sequence[Candidate], control: Control) -> Confidence:
    """Return the confidence in the first of candidates that differ."""
    best, *others = (one.fit for one in found)
    margin = min((one.score for one in others), default=np.inf) - best.score
    return confidence_of(best, margin, complete=not control.expired)
