"""Registration of a pair of shapes: directly, reflected, opened, or from a given map."""

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import partial

from solver.arrays import IntArray
from solver.control import Control
from solver.errors import MeshError
from solver.registration.alignment import GLOBAL
from solver.registration.candidates import FEWEST, NO_LANDMARKS, Points
from solver.registration.choice import (
    COARSE,
    FINE,
    LANDMARK_TOLERANCE,
    Candidate,
    Task,
    again,
    choose,
    from_hypotheses,
    mapped,
)
from solver.registration.glued import Rematch, search_opened
from solver.registration.reduction import ReducedTask
from solver.registration.registration import Registration
from solver.registration.search import confidence_in, first_found, search
from solver.shape import Shape

_REFLECTED_MARGIN = 3.0
"""How much less the score of the reflected source must be for the shapes to be called reflected:
the six local measures less by two fifths each. A choice: a symmetric body in a mirrored pose fits
somewhat better reflected, too."""

_OPENED_MARGIN = 0.2
"""How much less the refined score of opened surfaces has to be. Of 28 answers in doubt for scans
with handles that are more probable opened, but by less, three would become wrong and none right; of
15 by more, seven become right and none wrong."""

_PROGRESS = (0.0, 0.5), (0.5, 0.75), (0.75, 1.0)
"""Progress of the direct registration, of the reflected one, and of that of opened surfaces."""

_REFLECTED_KEPT = 4
"""Candidates of the reflected source that are kept after the first stage: a reflected copy fits far
better than any other."""


def register(
    source: Shape,
    target: Shape,
    hypotheses: Sequence[Points],
    control: Control,
    landmarks: Points = NO_LANDMARKS,
    *,
    others: bool = True,
    rematch: Rematch | None = None,
) -> Registration | None:
    """Register a source to a target: deform it onto the target in space, and measure the fit.

    Candidates start from the hypotheses, from signs of eigenfunctions, and from a rotation in
    space. The best of them are registered more finely, and the one of best fit is chosen. It
    preserves the orientation wherever the surfaces distinguish left from right and front from back,
    because displacements cannot reflect. If landmarks are given, or if it fits better coarsely, the
    reflected source is registered as well: it is the answer if it alone meets the landmarks, or
    fits far better. In doubt, more candidates are searched, and the refined fit chooses among them
    (:mod:`.search`).

    Parameters
    ----------
    source, target
        The shapes X and Y.
    hypotheses
        (n,) vertices of X and (n,) vertices of Y that correspond, as many as there are.
    control
        May cancel, and reports progress in doubt; past its deadline, less is tried.
    landmarks
        Vertices of X and Y that are known to correspond: candidates that miss them come last.
    others
        Whether another population of candidates is searched when the answer is in doubt.
    rematch
        Finds hypotheses on surfaces that are opened where parts of them touch: where a surface has
        handles, and the refined answer is still in doubt, it is searched there as well
        (:func:`.search_opened`). Not where landmarks are given, or the answer is reflected.

    Returns
    -------
    Registration
        ``None`` if a surface has too few eigenfunctions to tell how it lies in space.

    Raises
    ------
    Cancelled
        Through `control`.

    References
    ----------
    Compare Eisenberger, Lähner and Cremers, "Smooth Shells: Multi-scale shape registration with
    functional maps", CVPR 2020, whose first candidates are random.
    """
    task = Task.of(source, target, landmarks)
    if min(one.size for one in task.samples) < FEWEST:
        return None
    first, second, third = (control.between(*part) for part in _PROGRESS)
    found = _registered(source, target, task, hypotheses, first, others=others)
    if len(landmarks[0]):
        # Landmarks may mean the mirror image; hardly where the direct answer surely meets them.
        doubted = found.candidate.missed > LANDMARK_TOLERANCE or not found.confidence.is_sure
        mirrored = _registered(
            source, target, task.reflected(), hypotheses, second, others=False, further=doubted
        )
        return mirrored if _is_meant(mirrored, found) else found
    if control.expired:
        return found
    if _may_be_reflected(task, found.candidate, control):
        mirrored = _registered(source, target, task.reflected(), hypotheses, second, others=others)
        if mirrored.score < found.score - _REFLECTED_MARGIN:
            return replace(mirrored, confidence=mirrored.confidence.of_reflection())
    return found if rematch is None else _opened(found, rematch, third)


def first_registration(source: Shape, target: Shape, control: Control) -> Registration | None:
    """Register a source to a target as :func:`register` begins, without hypotheses.

    It takes a second, and measures what one of them lacks as well as the full search does: for a
    part, the full search only finds better ways to deform it onto missing regions.

    Parameters
    ----------
    source, target, control
        As for :func:`register`.

    Returns
    -------
    Registration
        ``None`` if a surface has too few eigenfunctions to tell how it lies in space.

    Raises
    ------
    Cancelled
        Through `control`.
    """
    task = Task.of(source, target, NO_LANDMARKS)
    if min(one.size for one in task.samples) < FEWEST:
        return None
    found = first_found(task, (), control)
    return Registration.of(source, target, found.candidates[0], found.confidence)


def first_score(source: Shape, target: Shape, control: Control) -> tuple[float, bool]:
    """Return the score of a first registration, and whether its answer is sure.

    Parameters
    ----------
    source, target, control
        As for :func:`register`.

    Returns
    -------
    Infinity and false for surfaces that cannot be registered.

    Raises
    ------
    Cancelled
        Through `control`.
    """
    try:
        found = first_registration(source, target, control)
    except MeshError:
        found = None
    return (math.inf, False) if found is None else (found.score, found.confidence.is_sure)


def register_map(
    source: Shape, target: Shape, images: IntArray, back: IntArray, control: Control
) -> Registration:
    """Register a source to a target from a map of all vertices, in the last stage alone.

    Parameters
    ----------
    source, target
        The shapes X and Y, of V and W vertices.
    images, back
        (V,) vertices of Y, and (W,) vertices of X.
    control
        May cancel.

    Returns
    -------
    Registration
        With the confidence in this map alone; :meth:`.Registration.among` compares it with another.

    Raises
    ------
    Cancelled
        Through `control`.
    """
    task = Task.of(source, target)
    candidate = choose(task, mapped(task, images, back), FINE[-1:], control)[0]
    return Registration.of(source, target, candidate, confidence_in([candidate], control))


def _is_meant(mirrored: Registration, direct: Registration) -> bool:
    """Return whether landmarks mean the mirror image: it alone meets them, or fits far better."""
    nearer = direct.candidate.missed - mirrored.candidate.missed
    if abs(nearer) > LANDMARK_TOLERANCE:
        return nearer > 0.0
    return mirrored.score < direct.score - _REFLECTED_MARGIN


def _may_be_reflected(task: Task, direct: Candidate, control: Control) -> bool:
    """Return whether the reflected source fits better than the direct answer, coarsely.

    Without hypotheses: signs of eigenfunctions tell a reflected copy, which is an isometric one.
    """
    signs = from_hypotheses(task, ())
    stages = replace(COARSE[0], kept=_REFLECTED_KEPT), *COARSE[1:]
    mirrored = choose(task.reflected(), signs, stages, control)[0].fit.score
    coarse = choose(task, again([direct], GLOBAL), COARSE, control)[0].fit.score
    return mirrored < coarse - _REFLECTED_MARGIN


def _registered(
    source: Shape,
    target: Shape,
    task: Task,
    hypotheses: Sequence[Points],
    control: Control,
    *,
    others: bool,
    further: bool = True,
) -> Registration:
    """Search, in doubt for `others`, too; or, not `further`, only as a search begins."""
    if further:
        reduced = partial(ReducedTask.of, source, target, task)
        found = search(task, reduced, hypotheses, control, others=others)
    else:
        found = first_found(task, hypotheses, control)
    return Registration.of(
        source, target, found.candidates[0], found.confidence, reflected=task.is_reflected
    )


def _opened(known: Registration, rematch: Rematch, control: Control) -> Registration:
    """Register what is left of surfaces that are glued, in doubt, if that fits better, refined.

    A surface is glued if it has handles. Of opened surfaces, and of two that are glued, wrong
    candidates often fit somewhat better than the right one did: what is opened is not compared.
    """
    glued = any(shape.mesh.genus > 0.0 for shape in (known.source, known.target))
    score = known.confidence.refined_score
    if score is None or not glued or known.confidence.is_sure or control.expired:
        return known
    least = score - _OPENED_MARGIN
    try:
        maps = known.opened.vertex_maps()
        found = search_opened(known.source, known.target, maps, rematch, least, control)
    except MeshError:
        # What cannot be opened stays closed; the answer for it stands.
        return known
    if found is None or found[1].probability < known.confidence.probability:
        return known
    opened, confidence = found
    return replace(known, opened=opened, confidence=confidence.of_opened())
