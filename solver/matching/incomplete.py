"""Detection of incomplete shapes: a part of a whole, or two surfaces that only overlap.

Only surfaces with a boundary may be incomplete. If only one of two surfaces has a long boundary, it
may be a part of the other. If both have one, each may lack something that the other has, and they
are registered as overlapping surfaces: a registration of wholes that lack different limbs is often
wrong with a high confidence.
"""

from dataclasses import replace

import numpy as np

from solver.control import Control
from solver.errors import MeshError
from solver.matching.options import BOTH, SOURCE, TARGET, MatchOptions
from solver.matching.part import KnownPart, find_part, match_part
from solver.matching.result import Match
from solver.matching.whole import match_whole
from solver.registration import (
    NO_LANDMARKS,
    RIGHT_ERROR,
    STAGE,
    Points,
    Registration,
    first_registration,
    smooth_surface,
)
from solver.registration.partial import are_cut_across
from solver.shape import Shape

_BOUNDARY = 0.5
"""Least length of the boundary of a part that is detected, over √area: less than the girth of a
person, and more than holes in scans of whole ones."""

_BOTH_BOUNDARIES = 0.3
"""Least length of the boundaries of two surfaces, over √area, that may overlap: of 35 pairs that
have less, and both lack ends of limbs, 33 are matched rightly as wholes."""

_LACKING = 0.075
"""Share of the area of the other that a part lacks at least by a registration of both as wholes,
which stretches it over what it lacks. Of 19 parts it is 0.085 to 0.45 in the end, and of 36 others
0.09 to 0.57 at first; in 25 matches of bodies with up to five small holes that are right 0.02 to
0.07, in one 0.14."""

_COMPLETE = 0.01
"""Share below which neither of two surfaces that are cut across the trunk lacks anything of the
other. Of 18 pairs of faces and leaves, deformed and remeshed, it is at most 0.004. Of 36 pairs of
bodies without opposite sides, many of them mirrored, the greater of both shares is 0.005 and 0.010
for the left and the right of two people, and more for all others."""

_BEGUN, _COMPARED = 500, 100
"""Samples whose images a candidate begins at, and are compared, at most."""

_PROGRESS = (0.0, 0.5), (0.3, 0.9), (0.9, 1.0)
"""Progress of the search for a part, of the match of wholes, and of what follows it."""

_OVERLAP_PROGRESS = (0.0, 0.6), (0.6, 1.0)
"""Progress of the match of wholes, and of the search for an overlap."""


def match_detected(source: Shape, target: Shape, options: MatchOptions, control: Control) -> Match:
    """Match two shapes as wholes, as a part and a whole, or as surfaces that overlap.

    Parameters
    ----------
    source, target
        The shapes X and Y.
    options
        Of the match.
    control
        Reports progress and cancels.

    Raises
    ------
    Cancelled
        Through `control`.
    OptionError
        An option does not suit these shapes.
    """
    ours, theirs = (one.mesh.relative_boundary for one in (source, target))
    clouds = source.mesh.is_cloud or target.mesh.is_cloud
    if min(ours, theirs) >= _BOTH_BOUNDARIES and not clouds:
        return _match_possible_overlap(source, target, options, control)
    if max(ours, theirs) >= _BOUNDARY:
        part = SOURCE if ours > theirs else TARGET
        return _match_possible_part(source, target, part, options, control)
    return match_whole(source, target, options, control)[0]


def _match_possible_part(
    source: Shape, target: Shape, part: str, options: MatchOptions, control: Control
) -> Match:
    """Match a shape as a part, if by a registration of both as wholes it lacks much of the other.

    A first registration may show this. If the registration as a part is sure then, it is the answer
    at once. Otherwise both are matched as wholes, and the registration of this match decides. The
    confidence of the wholes is not compared, because it was fitted to wholes: of 30 parts matched
    as wholes, three answers are right, and 24 of the same matched as parts. If a cloud and
    another surface both have a long boundary, which may be gaps, the greater confidence decides. A
    surface that cannot be displaced, or on which distances cannot be measured, is no part.
    """
    alone = min(one.mesh.relative_boundary for one in (source, target)) < _BOUNDARY
    early, wholly, last = (control.between(*ends) for ends in _PROGRESS)
    known = None
    if alone:
        with control.stage(STAGE):
            registration = first_registration(source, target, early)
        if registration is not None and _lacks(registration, part, early):
            known = _registered(source, target, part, options, early)
    if known is not None and (known.confidence.is_sure or control.expired):
        answer = _matched_part(known, options, control)
        if answer is not None:
            return answer
    # What is missing misleads wholes more than what touches, and handles of clouds are often false.
    found, registration = match_whole(source, target, options, wholly, may_be_glued=known is None)
    if registration is None or not _lacks(registration, part, last):
        return found
    known = known or _registered(source, target, part, options, last)
    if known is None or not (
        alone or known.confidence.probability > registration.confidence.probability
    ):
        return found
    return _matched_part(known, options, last) or found


def _match_possible_overlap(
    source: Shape, target: Shape, options: MatchOptions, control: Control
) -> Match:
    """Match two shapes as surfaces that overlap, unless they are wholes.

    They are wholes if, registered as wholes, they lack little of one another, and if both
    registrations agree on the overlap. The registration as wholes, if it is likely, is one
    candidate of the overlap, and preferred to others that fit as well. If both agree, the answer
    has the greater confidence of the two, but is in doubt if another candidate fits better on its
    overlap. Where both are cut across the trunk, they are wholes if they lack nothing of one
    another, as two faces with the same rim do, or sheets; otherwise only the confidence in the
    overlap counts.
    Surfaces that are equal but for their sampling lack nothing, however many symmetries they have.
    """
    wholly, last = (control.between(*ends) for ends in _OVERLAP_PROGRESS)
    found, registration = match_whole(source, target, options, wholly)
    if registration is None or registration.is_exact:
        return found
    lacking = max(_share_lacking(registration, part, last) for part in (SOURCE, TARGET))
    across = are_cut_across(source, target)
    if across and lacking < _COMPLETE:
        return found
    vertices = smooth_surface(source).samples.vertices[:_BEGUN]
    points = vertices, registration.images(vertices, last)
    begun = points if registration.confidence.is_likely else NO_LANDMARKS
    known = _registered(source, target, BOTH, options, last, begun)
    if known is None:
        return found
    if lacking >= _LACKING or not _agree(registration, known, points):
        return _matched_part(known, options, last) or found
    agreed = known.confidence
    if registration.confidence.is_contradicted:
        agreed = agreed.against_landmarks()
    surer = registration.confidence.probability >= agreed.probability
    if known.confidence.margin > 0.0 and surer and not across:
        return found
    return replace(found, confidence=agreed)


def _lacks(registration: Registration, part: str, control: Control) -> bool:
    """Return whether a part lacks much of the other shape by a registration."""
    return _share_lacking(registration, part, control) >= _LACKING


def _share_lacking(registration: Registration, part: str, control: Control) -> float:
    """Share of the other shape that a part lacks by a registration; 0 if it cannot be measured."""
    if control.expired:
        return 0.0
    try:
        return registration.share_lacking(control, of_source=part == TARGET)
    except MeshError:
        return 0.0


def _agree(registration: Registration, known: KnownPart, points: Points) -> bool:
    """Return whether two registrations agree on the overlap.

    Parameters
    ----------
    registration
        Of both as wholes.
    known
        Of both as surfaces that overlap.
    points
        Vertices of both that correspond by the former.
    """
    try:
        return _apart(registration.target, known, points) < RIGHT_ERROR
    except MeshError:
        return True


def _apart(target: Shape, known: KnownPart, points: Points) -> float:
    """Mean geodesic distance over √area from where points correspond to where the overlap has them.

    Of those that have a partner there. Distances in space would not tell two legs apart.
    """
    vertices, images = (one[:_COMPARED] for one in points)
    met = known.mapped[vertices]
    if not met.any():
        return np.inf
    distances = target.metric("geodesic").distances(images[met])
    away = distances[np.arange(len(distances)), known.images[vertices[met]]]
    return float(away.mean() / target.size)


def _registered(
    source: Shape,
    target: Shape,
    part: str,
    options: MatchOptions,
    control: Control,
    wholly: Points = NO_LANDMARKS,
) -> KnownPart | None:
    """Register shapes as parts; ``None`` where that is not possible."""
    if control.expired:
        return None
    try:
        return find_part(source, target, part, options, control, wholly)
    except MeshError:
        return None


def _matched_part(known: KnownPart, options: MatchOptions, control: Control) -> Match | None:
    """Match a registered part; ``None`` where distances along a shape cannot be computed."""
    try:
        return match_part(known, options, control)
    except MeshError:
        return None
