"""Search for the candidate that fits best: from coarse to fine, and among more when in doubt."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from solver.control import Control
from solver.errors import MeshError
from solver.registration.alignment import Pairs
from solver.registration.candidates import Points, exchanged_pairs, varied_pairs
from solver.registration.choice import (
    COARSE,
    FINE,
    Candidate,
    FirstPairs,
    Task,
    again,
    choose,
    from_hypotheses,
    meeting_landmarks,
    ranked,
)
from solver.registration.comparison import Compared, best_compared, compare, may_be_overtaken
from solver.registration.confidence import (
    EXACT,
    REFINED_EXACT,
    RIVAL_MARGIN,
    SURE,
    Confidence,
    confidence_of,
    margin_of,
    refined_confidence,
)
from solver.registration.crossing import Crossed, cross
from solver.registration.reduction import FEW_VERTICES, MANY_VERTICES, ReducedTask
from solver.registration.refinement import refine_on
from solver.registration.surface import Samples

_BEYOND_DOUBT = 0.98
"""Probability by eigenfunctions from which nothing more is searched. Of the generated answers that
they call sure, 3 of 56 are wrong, but none from here on."""

_AGREEING = 0.7
"""Mean change of the mean curvature, relative to its deviation, below which curvatures agree. For
people and animals beyond doubt it is at most 0.63; for unrelated points it is about 1."""

_ROUND = 0.55
"""Least volume of a round surface, over that of the ball of equal area. People and animals have
0.27 to 0.51, teeth 0.68, folded cortices 0.6, stones 0.8 and more."""

_BALL = 1.0 / (6.0 * np.sqrt(np.pi))
"""Volume of the ball of unit area."""

_REPEATED = 1.01
"""Ratio of eigenvalues below which they are the same; of scanned people and animals the second is
1.13 to 3.3 times the first."""

_KEPT = 16
"""Best candidates of the coarse stages that go through the fine ones. A choice: in doubt, each is
refined on few vertices as well, which takes some 25 ms."""

_ROUNDS = 2
"""How often, when in doubt, the best candidates of a population are varied and crossed; a third
time changes nothing. After the first, one in forty answers that seem sure is wrong."""

_VARIED = 3
"""Best candidates whose signs are varied. A choice: each gives 64 coarse candidates a round."""

_TELLING = 0.8
"""Difference of scores on all vertices from which the better of two exact fits is right: of six
pairs of an ellipsoid and another sampling of it, which fits in four ways, it is at most 0.42; with
knobs that tell the ways apart, 1.7."""


STAGE = "registration"
"""Name of the stage in reports of progress."""


@dataclass(frozen=True, eq=False)
class Found:
    """What a search has found.

    Parameters
    ----------
    candidates
        Those that differ, the best, which is registered finely, first.
    confidence
        In the best.
    """

    candidates: tuple[Candidate, ...]
    confidence: Confidence


def search(
    task: Task,
    reduced: Callable[[int], ReducedTask],
    hypotheses: Sequence[Points],
    control: Control,
    *,
    others: bool = True,
) -> Found:
    """Register candidates coarsely, and the best finely; when in doubt, compare and vary them.

    Unless the best is beyond doubt, candidates are chosen by their fit once they are refined on few
    vertices, and the best are varied and crossed with others. Where doubt remains, another
    population is searched, from exchanged eigenfunctions. Its candidates are not crossed with those
    known: where hypotheses begin near a wrong answer, they are so many that they crowd the others
    out.

    Parameters
    ----------
    task
        The surfaces.
    reduced
        Gives them with a number of their vertices.
    hypotheses
        Corresponding vertices, as many as there are.
    control
        May cancel, and reports progress in doubt; past its deadline, less is tried.
    others
        Whether the other population is searched.

    Raises
    ------
    Cancelled
        Through `control`.
    """
    coarse, halfway, found = _begun(task, hypotheses, control)
    known = confidence_in(found, control)
    if control.expired or _is_beyond_doubt(task, found, known):
        return Found(tuple(found), _among_fits(known, found))
    try:
        further = _FurtherSearch(task, reduced(FEW_VERTICES), known, control)
        best = best_compared(further.run(coarse, [*found, *halfway], hypotheses, others=others))
        scores = [one.fit.score for one in best]
        margin = margin_of(scores)
        said = refined_confidence(known, best[0].fit, margin, complete=not control.expired)
        told = False
        if margin < RIVAL_MARGIN and said.probability < SURE and not control.expired:
            control.report(STAGE, 0.8)
            among = _choice_of_rivals(best, reduced(MANY_VERTICES), control)
            if among is not None:
                best, margin = among
                told = margin > _TELLING
                said = refined_confidence(
                    known,
                    best[0].fit,
                    margin,
                    among_rivals=True,
                    complete=not control.expired,
                )
        if not told:
            said = said.among(scores, REFINED_EXACT)
    except MeshError:
        # The map of eigenfunctions stands, where surfaces cannot be displaced beyond them.
        return Found(tuple(found), _among_fits(known, found))
    chosen, *rest = (one.candidate for one in best)
    return Found((*register_finely(task, [chosen], control), *rest), said)


def _is_beyond_doubt(task: Task, found: Sequence[Candidate], known: Confidence) -> bool:
    """Whether nothing more is searched: no other than the best may be right.

    Where rotations keep both surfaces, the right one may not be among candidates, unless the best
    is exact. Of round surfaces, such as cells or stones, many maps have nearly equal normals and
    distances, by which the probability is high: their curvatures must agree, too.
    """
    if known.probability < _BEYOND_DOUBT or may_be_overtaken(found):
        return False
    if found[0].fit.score < EXACT:
        return True
    if _are_round(task) and found[0].fit.measures["bent_1"] >= np.log(_AGREEING):
        return False
    return not _have_rotations(task)


def _are_round(task: Task) -> bool:
    """Whether both surfaces are closed, and enclose more than half of the ball of equal area."""
    meshes = task.source.mesh, task.target.mesh
    return all(one.closed and one.volume > _ROUND * _BALL for one in meshes)


def _have_rotations(task: Task) -> bool:
    """Whether both surfaces have a repeated first eigenvalue, as those have that rotations keep.

    Any rotation of their eigenfunctions is as good: candidates by signs are few of many.
    """
    spectra = task.source.spectrum, task.target.spectrum
    return all(one.eigenvalues[2] < _REPEATED * one.eigenvalues[1] for one in spectra)


def first_found(task: Task, hypotheses: Sequence[Points], control: Control) -> Found:
    """Register candidates as a search begins: nothing more is tried in doubt.

    Parameters
    ----------
    task, hypotheses, control
        As for :func:`search`.

    Raises
    ------
    Cancelled
        Through `control`.
    """
    _, _, found = _begun(task, hypotheses, control)
    return Found(tuple(found), _among_fits(confidence_in(found, control), found))


def _among_fits(known: Confidence, found: Sequence[Candidate]) -> Confidence:
    """Confidence in the first candidate, of which others may be exact, too."""
    return known.among([one.fit.score for one in found], EXACT)


def _begun(
    task: Task, hypotheses: Sequence[Points], control: Control
) -> tuple[list[Candidate], list[Candidate], list[Candidate]]:
    """Candidates after the coarse stages, after the first of the fine ones, and after the last."""
    coarse = choose(task, from_hypotheses(task, hypotheses), COARSE, control)
    halfway = _halfway(task, coarse, control)
    return coarse, halfway, register_finely(task, halfway[: FINE[0].kept], control)


def _choice_of_rivals(
    best: Sequence[Compared], reduced: ReducedTask, control: Control
) -> tuple[list[Compared], float] | None:
    """Choose among those that fit nearly as well as the best on few vertices by more of them.

    Returns
    -------
    The chosen one and the others, and how much greater the score of the best other is; ``None``
    where the time is over before all are refined.
    """
    rivals = [one for one in best if one.fit.score < best[0].fit.score + RIVAL_MARGIN]
    scores = [
        refine_on(reduced, one.candidate, control).fit.score
        for one in control.in_time(rivals, least=1)
    ]
    if len(scores) < len(rivals):
        return None
    chosen = rivals[int(np.argmin(scores))]
    order = [chosen, *(one for one in best if one is not chosen)]
    farther = [one.fit.score - best[0].fit.score for one in best[len(rivals) :]]
    return order, min([margin_of(sorted(scores)), *farther])


@dataclass(frozen=True, eq=False)
class _FurtherSearch:
    """A search in doubt: candidates are compared once they are refined on few vertices.

    Parameters
    ----------
    task, few
        The surfaces, and the same with few of their vertices.
    known
        Confidence in the best by eigenfunctions.
    control
        May cancel; past its deadline, less is tried.
    crossed, registered
        Pairs of coarse candidates that are crossed, and coarse candidates that are registered
        halfway: neither is done twice.
    """

    task: Task
    few: ReducedTask
    known: Confidence
    control: Control
    crossed: Crossed = field(default_factory=set)
    registered: set[Candidate] = field(default_factory=set)

    def run(
        self,
        coarse: Sequence[Candidate],
        finer: Sequence[Candidate],
        hypotheses: Sequence[Points],
        *,
        others: bool,
    ) -> list[Compared]:
        """Return all candidates that were compared: those given, and those of them, and others."""
        self.control.report(STAGE, 0.2)
        self.registered.update(coarse[:_KEPT])
        back = _from_the_target(self.task, hypotheses, self.control)
        compared = self._evolved([*coarse, *back], self._compared(finer))
        if not others or self._is_sure(compared):
            return compared
        self.control.report(STAGE, 0.5)
        coarse = choose(self.task, exchanged_pairs, COARSE, self.control)
        return [*compared, *self._evolved(coarse, self._registered(coarse))]

    def _evolved(self, coarse: Sequence[Candidate], compared: list[Compared]) -> list[Compared]:
        """Vary and cross the best of a population, for some rounds."""
        task, control = self.task, self.control
        for _ in control.in_time(range(_ROUNDS)):
            best = [one.candidate for one in best_compared(compared)]
            varied = choose(task, _variations(best[:_VARIED]), COARSE, control)
            coarse = ranked([*coarse, *varied], task.positions)
            coarse = cross(task, coarse, self.crossed, control)
            compared = [*compared, *self._registered(coarse)]
        return compared

    def _registered(self, coarse: Sequence[Candidate]) -> list[Compared]:
        """Register the best of coarse candidates halfway, and the best of those finely."""
        new = [one for one in coarse[:_KEPT] if one not in self.registered]
        if not new:
            return []
        self.registered.update(new)
        halfway = self._compared(_halfway(self.task, new, self.control))
        best = [one.candidate for one in best_compared(halfway)]
        return [*halfway, *self._compared(register_finely(self.task, best, self.control))]

    def _compared(self, candidates: Sequence[Candidate]) -> list[Compared]:
        return compare(self.few, candidates, self.control)

    def _is_sure(self, compared: Sequence[Compared]) -> bool:
        best = best_compared(compared)
        margin = margin_of([one.fit.score for one in best])
        return refined_confidence(self.known, best[0].fit, margin).probability >= SURE


def _variations(candidates: Sequence[Candidate]) -> FirstPairs:
    alignments = [one.alignment for one in candidates]
    return lambda samples: varied_pairs(samples, alignments)


def _from_the_target(task: Task, hypotheses: Sequence[Points], control: Control) -> list[Candidate]:
    """Candidates found by bending the target onto the source: others than the other way round."""
    turned = task.swapped()
    swapped = [(there, here) for here, there in hypotheses]
    found = choose(turned, from_hypotheses(turned, swapped), COARSE, control)

    def back(samples: tuple[Samples, Samples]) -> Iterator[Pairs]:
        pairs = again(found, COARSE[-1].weights)(samples[::-1])
        return (Pairs.of_all(one.back, one.images) for one in pairs)

    return choose(task, back, COARSE[-1:], control)


def _halfway(task: Task, coarse: Sequence[Candidate], control: Control) -> list[Candidate]:
    every = replace(FINE[0], kept=_KEPT)
    return choose(task, again(coarse[:_KEPT], every.weights), (every,), control)


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
    Those that differ and meet the landmarks, the best first.
    """
    found = choose(task, again(halfway, FINE[-1].weights), FINE[-1:], control)
    return meeting_landmarks(found)


def confidence_in(found: Sequence[Candidate], control: Control) -> Confidence:
    """Return the confidence in the first of candidates that differ."""
    margin = margin_of([one.fit.score for one in found])
    return confidence_of(found[0].fit, margin, complete=not control.expired)
