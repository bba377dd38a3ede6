"""Matching of a target with a prototype (section 5), by the stages of a match of two shapes."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from solver.control import Control
from solver.errors import OptionError
from solver.labelling import CERTIFIED_GAP, L2, relative_gap
from solver.matching import (
    MAX_COARSE_POINTS,
    PARTS,
    Hypothesis,
    Match,
    MatchOptions,
    Stages,
    certify,
    cut_short,
    enumerate_hypotheses,
    refine_hypotheses,
    report_match,
)
from solver.prototype.matching.orientation import orient_by_examples
from solver.prototype.matching.sampling import sample_target
from solver.prototype.prototype import Prototype
from solver.prototype.surfaces import SurfaceSpectra, compute_spectrum
from solver.shape import Shape
from solver.shape.choices import Structure


def match_prototype(
    prototype: Prototype,
    target: Shape,
    options: MatchOptions | None = None,
    control: Control | None = None,
    surface_spectra: SurfaceSpectra = compute_spectrum,
) -> Match:
    """Find the most likely correspondence of a prototype's points with a shape: problem (6).

    The stages are those of :func:`solver.matching.match`, except that the levels hold likelihoods
    (section 5) and that surfaces of examples choose the hypothesis, by their registrations.

    Parameters
    ----------
    prototype
        The prototype 𝒳.
    target
        The shape Y.
    options
        By default ``MatchOptions()``. Orientation has no effect if the prototype has no surfaces.
        Metric and descriptor are the prototype's. By default the coarsest level has 10 points
        instead of 8: a few more on the trunk distinguish the two ways to pair arms and legs.
    control
        Reports progress and cancels. Past its deadline, or the options' time limit, the best
        answer so far is returned with the bound known by then.
    surface_spectra
        Computes spectra of the prototype's surfaces, or takes them from a cache.

    Returns
    -------
    Match
        Its source points are numbers of the prototype's points, its energies are negative
        log-likelihoods over their least values, and its distortions are those of the mean
        distances and descriptors.

    Raises
    ------
    Cancelled
        Through `control`.
    OptionError
        An option does not suit the prototype or the shape.

    Examples
    --------
    >>> found = match_prototype(prototype, Shape(read_mesh(data, "cat7.off")))
    >>> found.best.source, found.best.target  # points of the prototype, the user's vertices
    >>> found.misfit  # about 1 for a usual member of the class
    """
    options = options or MatchOptions()
    check_options(prototype, target, options)
    if options.coarse_points is None:
        options = replace(options, coarse_points=MAX_COARSE_POINTS)
    control = (control or Control()).timed().within(options.time_limit)
    unlike: tuple[str, ...] = ()
    with control.stage("total"):
        stages = Stages.of(control)
        levels, few_points = sample_target(prototype, target, options, stages.sampling)
        hypotheses, unproven = enumerate_hypotheses(levels[0], options, stages.enumeration)
        hypotheses = refine_hypotheses(hypotheses, levels[1:], options.rho, stages.refinement)
        if options.orientation and prototype.surfaces:
            hypotheses, unlike = orient_by_examples(
                prototype,
                target,
                hypotheses,
                levels,
                options.rho,
                stages.orientation,
                surface_spectra,
            )
        best = certify(hypotheses[0], levels, stages.certification)
    misfit, misfits = _misfit(prototype, best, options)
    warnings = (
        *(f"prototype: {warning}" for warning in prototype.warnings),
        *(f"target: {warning}" for warning in target.mesh.warnings),
        *_points_beyond(prototype, options),
        *few_points,
        *unproven,
        *unlike,
        *misfits,
        *cut_short(control),
    )
    vertex_ids = np.arange(prototype.points), target.mesh.vertex_ids
    found = report_match([best, *hypotheses[1:]], levels, vertex_ids, warnings, control)
    return replace(found, misfit=misfit)


def check_options(prototype: Prototype, target: Shape, options: MatchOptions) -> None:
    """Check that options suit a match with a prototype.

    Raises
    ------
    OptionError
        They do not.
    """
    for field in ("refine", "dense", "third_order"):
        if getattr(options, field):
            raise OptionError(field, f"{field} is not supported with a prototype; leave it out")
    if options.landmarks:
        raise OptionError("landmarks", "a prototype has no vertices; leave them out")
    if options.partial in PARTS:
        raise OptionError("partial", "parts are not supported with a prototype; leave it out")
    if options.objective != L2:
        raise OptionError("objective", f"a prototype is matched by likelihood; it must be {L2}")
    usual = MatchOptions()
    if options.metrics != usual.metrics and not _chosen(options.metrics, prototype.metric_choices):
        raise OptionError("metric", "a prototype has its own; leave it out")
    own = prototype.descriptor_choices
    if options.descriptors != usual.descriptors and not _chosen(options.descriptors, own):
        raise OptionError("descriptor", "a prototype has its own; leave it out")
    for field in ("normalise", "eigenpairs", "geodesic_method"):
        if getattr(target, field) != getattr(prototype, field):
            raise OptionError(
                field, f"it must be as the prototype was learned: {getattr(prototype, field)}"
            )


def _points_beyond(prototype: Prototype, options: MatchOptions) -> tuple[str, ...]:
    """Warn of points that the prototype does not have."""
    if options.points <= prototype.points:
        return ()
    return (f"{options.points} points were asked for: the prototype has {prototype.points}",)


def _chosen(given: Sequence[Structure], own: Sequence[Structure]) -> bool:
    """Return whether given structures are the prototype's, as far as parameters are given."""
    return len(given) == len(own) and all(map(_is_chosen, given, own))


def _is_chosen(given: Structure, own: Structure) -> bool:
    values = {name: getattr(given, name) for name in given.parameters()}
    known = {name: value for name, value in values.items() if value is not None}
    return type(given) is type(own) and replace(own, **known) == own


def _misfit(
    prototype: Prototype, answer: Hypothesis, options: MatchOptions
) -> tuple[float | None, tuple[str, ...]]:
    """Ratio of the least energy per point to the usual one; and a warning if it is too great.

    Both are of the coarsest level, where left-out examples were matched by energy alone. ``None``
    where either is not known, or the usual one is of other points and weights.
    """
    coarsest, usual = answer.levels[0], MatchOptions()
    points, bound = coarsest.problem.n_sources, coarsest.solution.lower_bound
    comparable = (
        points == min(prototype.points, MAX_COARSE_POINTS)
        and options.oversampling == usual.oversampling
        and options.beta == usual.beta
        and options.first_order_weight == usual.first_order_weight
        and options.occlusion_cost is None
        and relative_gap(coarsest.least_energy, bound) <= CERTIFIED_GAP
    )
    if not (comparable and len(prototype.left_out_energies)):
        return None, ()
    misfit = coarsest.least_energy / points / prototype.usual_energy
    if misfit <= prototype.greatest_misfit:
        return misfit, ()
    warning = (
        f"the target is unlike the examples of the class: it misfits them {misfit:.2g}"
        " times as much as a usual one, so check the answer"
    )
    return misfit, (warning,)
