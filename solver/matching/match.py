"""Matching of two shapes: sample, enumerate, refine, orient, certify."""

from dataclasses import replace

from solver.control import Control
from solver.errors import OptionError
from solver.matching.incomplete import match_detected
from solver.matching.options import PARTS, MatchOptions
from solver.matching.part import find_part, match_part
from solver.matching.report import cut_short
from solver.matching.result import Match
from solver.matching.sampling import common_size
from solver.matching.strays import largest_components, without_strays
from solver.matching.whole import match_whole
from solver.matching.winding import wound_alike
from solver.shape import Shape

_PROGRESS = (0.0, 0.7), (0.7, 1.0)
"""Progress of a match, and of that of the largest components."""


def match(
    source: Shape,
    target: Shape,
    options: MatchOptions | None = None,
    control: Control | None = None,
) -> Match:
    """Find a minimum-distortion correspondence between samples of two shapes: problem (1), as (5).

    The stages: *sample* both shapes at every level (4.1); *enumerate* the best solutions of the
    coarsest level, the hypotheses; *refine* each from level to level; *orient*: register the
    surfaces and choose the hypothesis that agrees; *certify* that one by lower bounds at every
    level (section 4), and bound the energy over all target samples of the finest.

    Parameters
    ----------
    source, target
        The shapes X and Y.
    options
        By default ``MatchOptions()``.
    control
        Reports progress and cancels. Past its deadline, or the options' time limit, the best
        answer so far is returned with the bound known by then.

    Returns
    -------
    Match
        The same for the same shapes and options, unless a time limit cuts it short.

    Raises
    ------
    Cancelled
        Through `control`.
    OptionError
        An option does not suit these shapes.

    Examples
    --------
    >>> source, target = Shape(read_mesh(first, "cat0.off")), Shape(read_mesh(second, "cat1.off"))
    >>> found = match(source, target, MatchOptions(points=32, orientation=True))
    >>> found.best.source, found.best.target  # (32,) the user's own vertex numbers
    >>> found.certified, found.gap  # of the finest level's problem
    """
    options = options or MatchOptions()
    common_size(source, target)
    control = (control or Control()).timed().within(options.time_limit)
    with control.stage("total"):
        if options.registered:
            source, target = wound_alike(source, target, control)
        if options.partial in PARTS:
            found = _match_given_part(source, target, options, control)
        elif options.may_be_partial:
            source, target, found = _match_components(source, target, options, control)
        else:
            found, _ = match_whole(source, target, options, control)
    warnings = (
        *(f"source: {warning}" for warning in source.mesh.warnings),
        *(f"target: {warning}" for warning in target.mesh.warnings),
        *found.warnings,
        *cut_short(control),
    )
    return replace(found, warnings=warnings)


def _match_given_part(
    source: Shape, target: Shape, options: MatchOptions, control: Control
) -> Match:
    known = find_part(source, target, options.partial, options, control)
    if known is None:
        raise OptionError(
            "partial",
            "a shape has too few vertices, or nothing on the two is alike; match them as wholes",
        )
    return match_part(known, options, control)


def _match_components(
    source: Shape, target: Shape, options: MatchOptions, control: Control
) -> tuple[Shape, Shape, Match]:
    """Match what is left of two shapes without strays.

    How a part with strays fits as a whole says little, and how a body with several balls fits
    without one of them. So what has no likely answer is matched again by its largest component
    alone.
    """
    shapes = without_strays(source, target, options.landmarks, control)
    largest = largest_components(*shapes, options.landmarks)
    if largest == shapes:
        return *shapes, match_detected(*shapes, options, control)
    first, last = (control.between(*ends) for ends in _PROGRESS)
    found = match_detected(*shapes, options, first)
    if _is_likely(found) or control.expired:
        return *shapes, found
    other = match_detected(*largest, options, last)
    return (*largest, other) if _is_likely(other) else (*shapes, found)


def _is_likely(found: Match) -> bool:
    return found.confidence is not None and found.confidence.is_likely
