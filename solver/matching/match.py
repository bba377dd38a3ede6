"""Matching of two shapes: sample, enumerate, refine, orient, certify."""

from dataclasses import replace

from solver.control import Control
from solver.errors import MeshError, OptionError
from solver.gmds import GmdsRefinement, refine_by_gmds
from solver.labelling import LINF
from solver.matching.certification import certify, prove_over_samples, replaces
from solver.matching.enumeration import enumerate_hypotheses
from solver.matching.gromov_hausdorff import UNPROVEN_DISTANCE, gromov_hausdorff
from solver.matching.hypothesis import Hypothesis, drop_duplicates
from solver.matching.options import GMDS, PARTS, SOURCE, TARGET, MatchOptions
from solver.matching.orientation import Orientation, orient
from solver.matching.part import KnownPart, find_part, match_part
from solver.matching.refinement import refine_hypotheses
from solver.matching.report import report_match
from solver.matching.result import Match
from solver.matching.sampling import common_size, sample
from solver.registration import STAGE, DenseCorrespondence, Registration, first_registration
from solver.shape import Shape

_BOUNDARY = 0.5
"""Least length of the boundary of a part that is detected, over √area: less than the girth of a
person, and more than holes in scans of whole ones."""

_LACKING = 0.075
"""Share of the area of the other that a part lacks at least by a registration of both as wholes,
which stretches it over what it lacks. Of 19 parts it is 0.085 to 0.45 in the end, and of 36 others
0.09 to 0.57 at first; in 25 matches of bodies with up to five small holes that are right 0.02 to
0.07, in one 0.14."""

_PROGRESS = (0.0, 0.5), (0.3, 0.9), (0.9, 1.0)
"""Progress of the search for a part, of the match of wholes, and of what follows it."""


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
        if options.partial in PARTS:
            found = _match_given_part(source, target, options, control)
        elif (part := _possible_part(source, target, options)) is not None:
            found = _match_possible_part(source, target, part, options, control)
        else:
            found, _ = _match_whole(source, target, options, control)
    warnings = (
        *(f"source: {warning}" for warning in source.mesh.warnings),
        *(f"target: {warning}" for warning in target.mesh.warnings),
        *found.warnings,
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


def _possible_part(source: Shape, target: Shape, options: MatchOptions) -> str | None:
    """Which of the shapes, that with more boundary, may be a part of the other, if either may."""
    lengths = [one.mesh.relative_boundary for one in (source, target)]
    if not options.may_be_partial or max(lengths) < _BOUNDARY:
        return None
    return SOURCE if lengths[0] > lengths[1] else TARGET


def _match_possible_part(
    source: Shape, target: Shape, part: str, options: MatchOptions, control: Control
) -> Match:
    """Match a shape as a part, if by a registration of both as wholes it lacks much of the other.

    It is the answer at once if it lacks as much by a first registration, and the part that is found
    then is sure. Else both are matched as wholes, and the registration of that tells what it lacks.
    The confidence of wholes counts for nothing then: it was fitted to wholes. Of 30 parts matched
    as wholes, three answers are right, and 24 of the same matched as parts. But where both have a
    long boundary, neither may be a part: the greater confidence decides. What cannot be displaced,
    or measured along, is no part.
    """
    alone = min(one.mesh.relative_boundary for one in (source, target)) < _BOUNDARY
    early, wholly, last = (control.between(*ends) for ends in _PROGRESS)
    known = None
    if alone:
        with control.stage(STAGE):
            registration = first_registration(source, target, early)
        if registration is not None:
            known = _detected(registration, source, target, part, options, early)
    if known is not None and (known.sure or control.expired):
        answer = _matched_part(known, options, control)
        if answer is not None:
            return answer
    found, registration = _match_whole(source, target, options, wholly)
    if registration is None:
        return found
    known = _detected(registration, source, target, part, options, last, known)
    if known is None:
        return found
    if not alone and known.probability <= registration.confidence.probability:
        return found
    return _matched_part(known, options, last) or found


def _detected(
    registration: Registration,
    source: Shape,
    target: Shape,
    part: str,
    options: MatchOptions,
    control: Control,
    known: KnownPart | None = None,
) -> KnownPart | None:
    """Register a part, unless it is known, if it lacks much of the other by a registration."""
    if control.expired:
        return None
    try:
        if registration.share_lacking(control, of_source=part == TARGET) < _LACKING:
            return None
        return known or find_part(source, target, part, options, control)
    except MeshError:
        return None


def _matched_part(known: KnownPart, options: MatchOptions, control: Control) -> Match | None:
    """Match a registered part; ``None`` where distances along a shape cannot be computed."""
    try:
        return match_part(known, options, control)
    except MeshError:
        return None


def _match_whole(
    source: Shape, target: Shape, options: MatchOptions, control: Control
) -> tuple[Match, Registration | None]:
    options = options.settled(common_size(source, target))
    levels, few_points = sample(source, target, options, control)
    hypotheses, unproven = enumerate_hypotheses(levels[0], options, control)
    hypotheses = refine_hypotheses(hypotheses, levels[1:], options.rho, control)
    hypotheses = drop_duplicates(hypotheses)
    oriented = orient(source, target, hypotheses, levels, options, control)
    best, *others = oriented.hypotheses
    if options.objective != LINF:  # else enumeration has bounded the only level
        best = certify(best, oriented.levels, control)
    proof = prove_over_samples([best, *others], oriented.levels[-1], options, control)
    if proof is not None and replaces(proof, best, oriented.levels[-1], options):
        best = best.with_finest(proof)
    distance = gromov_hausdorff(source, target, levels[0], options, control)
    dense, refinement = _extend(oriented, best, options, control)
    warnings = (
        *few_points,
        *unproven,
        *(() if distance is None or distance.certified else (UNPROVEN_DISTANCE,)),
        *oriented.warnings,
    )
    vertex_ids = source.mesh.vertex_ids, target.mesh.vertex_ids
    found = report_match([best, *others], oriented.levels, vertex_ids, warnings, control, proof)
    registration = oriented.registration
    found = replace(
        found,
        gromov_hausdorff_distance=distance,
        dense=dense,
        refinement=refinement,
        confidence=None if registration is None else registration.confidence,
    )
    return found, registration


def _extend(
    oriented: Orientation, best: Hypothesis, options: MatchOptions, control: Control
) -> tuple[DenseCorrespondence | None, GmdsRefinement | None]:
    """Map all vertices, and refine the answer between vertices (7.1), as far as asked for."""
    registration = oriented.registration
    if registration is None:
        return None, None
    dense = None
    if options.dense:
        with control.stage("dense map", 0.85):
            dense = replace(registration.dense(control), hypothesis=oriented.place)
    if options.refine != GMDS:
        return dense, None
    with control.stage("refinement between vertices", 0.9):
        matched, _ = best.vertices(oriented.levels[-1])
        return dense, refine_by_gmds(registration, matched, oriented.place, control)
