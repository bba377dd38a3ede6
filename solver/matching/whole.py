"""Matches of two whole shapes: enumerate, refine, orient, certify."""

from dataclasses import replace

from solver.control import Control
from solver.gmds import GmdsRefinement, refine_by_gmds
from solver.labelling import LINF
from solver.matching.certification import certify, prove_over_samples, replaces
from solver.matching.enumeration import enumerate_hypotheses
from solver.matching.gromov_hausdorff import UNPROVEN_DISTANCE, gromov_hausdorff
from solver.matching.hypothesis import Hypothesis
from solver.matching.options import GMDS, MatchOptions
from solver.matching.orientation import Orientation, orient
from solver.matching.refinement import refine_hypotheses
from solver.matching.report import report_match
from solver.matching.result import Match
from solver.matching.sampling import common_size, sample
from solver.matching.stages import Stages
from solver.registration import DenseCorrespondence, Registration
from solver.shape import Shape


def match_whole(
    source: Shape,
    target: Shape,
    options: MatchOptions,
    control: Control,
    *,
    may_be_glued: bool = True,
) -> tuple[Match, Registration | None]:
    """Match two shapes of which each has all that the other has.

    Parameters
    ----------
    source, target
        The shapes X and Y.
    options
        Of the match.
    control
        Reports progress and cancels.
    may_be_glued
        Whether surfaces with handles are opened in doubt.

    Returns
    -------
    match
        The answer.
    registration
        Of the surfaces, if one was asked for and found.

    Raises
    ------
    Cancelled
        Through `control`.
    OptionError
        An option does not suit these shapes.
    """
    options = options.settled(common_size(source, target))
    stages = Stages.of(control)
    levels, few_points = sample(source, target, options, stages.sampling)
    hypotheses, unproven = enumerate_hypotheses(levels[0], options, stages.enumeration)
    hypotheses = refine_hypotheses(hypotheses, levels[1:], options.rho, stages.refinement)
    oriented = orient(
        source, target, hypotheses, levels, options, stages.orientation, may_be_glued=may_be_glued
    )
    best, *others = oriented.hypotheses
    if options.objective != LINF:  # else enumeration has bounded the only level
        best = certify(best, oriented.levels, stages.certification)
    proof = prove_over_samples([best, *others], oriented.levels[-1], options, stages.proof)
    if proof is not None and replaces(proof, best, oriented.levels[-1], options):
        best = best.with_finest(proof)
    distance = gromov_hausdorff(source, target, levels[0], options, stages.proof)
    dense, refinement = _extend(oriented, best, options, stages.extension)
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
        with control.stage("dense map", 0.0):
            dense = replace(registration.dense(control), hypothesis=oriented.place)
    if options.refine != GMDS:
        return dense, None
    with control.stage("refinement between vertices", 0.3):
        matched, _ = best.vertices(oriented.levels[-1])
        refined = refine_by_gmds(registration, matched, control)
        return dense, replace(refined, hypothesis=oriented.place)
