"""Search for the candidate that fits best: from coarse to fine, and further while in doubt."""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from solver.arrays import FloatArray
from solver.control import Control
from solver.registration.alignment import Pairs
from solver.registration.candidates import (
    Points,
    first_pairs,
    pairs_from_points,
    varied_pairs,
)
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
    register_candidate,
)
from solver.registration.confidence import CLOSE, SURE, Confidence, confidence_of
from solver.registration.crossing import cross
from solver.registration.extremities import matched_extremities
from solver.registration.surface import Samples
from solver.registration.surface_map import SurfaceMap

_KEPT = 16
"""Best candidates of the coarse stages that go through the fine ones."""

_AGAIN = replace(FINE[-1], sizes=(50, 60, *FINE[-1].sizes))
"""Stage in which refined candidates are aligned."""

_ROUNDS = 2
"""How often, when in doubt, the best candidates are varied and crossed; a third changes nothing."""

_VARIED = 3
"""Best candidates whose signs are varied."""

_REFINED = 5, 3
"""Best candidates that are refined when in doubt, and once more. Of 28 generated pairs in doubt, 16
are wrong without, 13 after the first and 11 after the second."""

_MOST_VERTICES = 20_000
"""Vertices of both surfaces above which candidates are not refined, which takes 0.1 ms for each."""


def search(
    task: Task, hypotheses: Sequence[Points], control: Control
) -> tuple[list[Candidate], Confidence]:
    """Register candidates coarsely, the best finely; in doubt, add, cross and refine candidates.

    Parameters
    ----------
    task
        The surfaces.
    hypotheses
        Corresponding vertices, as many as there are.
    control
        May cancel; past its deadline, less is tried.

    Returns
    -------
    Candidates that differ, the best first, and the confidence in that one.

    Raises
    ------
    Cancelled
        Through `control`.
    MeshError
        The source's Laplacian cannot be factored.
    """

    def first(samples: tuple[Samples, Samples]) -> Iterator[Pairs]:
        return first_pairs((task.source, task.target), samples, hypotheses)

    positions = task.target.mesh.vertices
    coarse = choose(task, first, COARSE, control)
    found = _finely(task, coarse, control)
    for number in range(_ROUNDS):
        if _confidence(found, control).probability >= SURE or control.expired:
            break
        varied = choose(task, _variations(found[:_VARIED]), COARSE, control)
        if number == 0:
            varied += choose(task, _from_extremities(task), COARSE, control)
        coarse = cross(task, ranked([*coarse, *varied], positions), control)
        further = ranked([*found, *_finely(task, coarse, control)], positions)
        found = unless_it_is_close(found[0], further, positions)
    for count in _REFINED:
        if _confidence(found, control).probability >= SURE:
            break
        best = found[:count] if _is_small(task) else []
        refined = [refine_candidate(task, one, control) for one in control.in_time(best)]
        found = ranked([*found, *refined], positions)
    return found, _confidence(found, control)


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


def refine_candidate(task: Task, candidate: Candidate, control: Control) -> Candidate:
    """Register a candidate again, from its images refined beyond the eigenfunctions.

    Local rotations put right what is off by less than a limb: a right candidate fits much better
    then, a wrong one little.

    Parameters
    ----------
    task
        The surfaces.
    candidate
        Of the last stage.
    control
        May cancel; past its deadline, less is refined.

    Raises
    ------
    Cancelled
        Through `control`.
    MeshError
        The source's Laplacian cannot be factored.
    """
    rough = SurfaceMap.of(task.source, task.target, candidate.alignment, task.is_reflected)
    refined, _ = rough.refined(control)
    samples = task.sampled(_AGAIN)
    return register_candidate(task, samples, refined.pairs(*samples), _AGAIN)


def _variations(candidates: Sequence[Candidate]) -> Start:
    alignments = [one.alignment for one in candidates]
    return lambda samples: varied_pairs(samples, alignments)


def _from_extremities(task: Task) -> Start:
    surfaces = task.source, task.target

    def pairs(samples: tuple[Samples, Samples]) -> Iterator[Pairs]:
        matched = matched_extremities(*samples)
        return (pairs_from_points(surfaces, samples, points) for points in matched)

    return pairs


def _is_small(task: Task) -> bool:
    return task.source.mesh.n_vertices + task.target.mesh.n_vertices <= _MOST_VERTICES


def _finely(task: Task, coarse: Sequence[Candidate], control: Control) -> list[Candidate]:
    return choose(task, again(coarse[:_KEPT], FINE[0].weights), FINE, control)


def _confidence(found: Sequence[Candidate], control: Control) -> Confidence:
    best, *others = (one.fit for one in found)
    margin = min((one.score for one in others), default=np.inf) - best.score
    return confidence_of(best, margin, complete=not control.expired)
