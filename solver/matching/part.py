"""Matches of a part and a whole, or of two parts that overlap: section 3, with occlusion.

The surfaces are registered first: that tells the scale of the part, and what has a partner. The
points are then matched near their images, at one level, by geodesic distance, which cuts change
less than what depends on the whole surface. Points without a partner stay unmatched, and so does
one whose matching would cost more than its occlusion.
"""

from dataclasses import dataclass, replace

from solver.arrays import BoolArray, IntArray
from solver.control import Control
from solver.errors import OptionError
from solver.matching.certification import certify, prove_over_samples
from solver.matching.hypothesis import Hypothesis
from solver.matching.landmarks import contradictions, landmark_vertices
from solver.matching.level import Level
from solver.matching.options import BOTH, GMDS, SOURCE, MatchOptions
from solver.matching.placement import add_target_samples, match_near_images
from solver.matching.refinement import solved_level
from solver.matching.report import report_match
from solver.matching.result import Match, Overlap
from solver.matching.sampling import too_few
from solver.matching.stages import Stages
from solver.matching.structures import build_level
from solver.registration import NO_LANDMARKS, STAGE, Confidence, Points
from solver.registration.partial import (
    OF_OVERLAP,
    OF_PART,
    PartMap,
    Side,
    are_cut_across,
    register_part,
)
from solver.shape import Shape
from solver.shape.choices import Geodesic

_OF_WHOLES = (
    "metric",
    "descriptor",
    "first_order_weight",
    "third_order",
    "orientation",
    "coarse_points",
    "level_factor",
    "rho",
    "alternatives",
)
"""Options of matches of wholes that parts do not have."""

_OCCLUSION_COST = 0.25
"""Cost of a point without partner: that of distances to all others that are wrong by half of their
root mean square."""


@dataclass(frozen=True, eq=False)
class KnownPart:
    """A part registered to the whole, or two parts.

    Parameters
    ----------
    surfaces
        The registration.
    partial
        Which shape is a part: one of :data:`.PARTS`.
    landmarks
        (L, 2) vertices of the source and of the target that are known to correspond.
    """

    surfaces: PartMap
    partial: str
    landmarks: IntArray

    @property
    def images(self) -> IntArray:
        """Nearest target vertices of all source vertices."""
        return self.surfaces.source.images[0]

    @property
    def mapped(self) -> BoolArray:
        """(V,) source vertices that have a partner."""
        return self.surfaces.source.covered

    @property
    def confidence(self) -> Confidence:
        """That the registration is right."""
        return self.surfaces.confidence


def find_part(
    source: Shape,
    target: Shape,
    partial: str,
    options: MatchOptions,
    control: Control,
    wholly: Points = NO_LANDMARKS,
) -> KnownPart | None:
    """Register a part to the whole.

    Parameters
    ----------
    source, target
        The shapes X and Y.
    partial
        Which of them is a part: one of :data:`.PARTS`.
    options
        Of the match.
    control
        Reports progress and cancels.
    wholly
        Vertices of both that correspond by a registration as wholes, which of surfaces that overlap
        becomes a candidate.

    Returns
    -------
    KnownPart
        ``None`` if a shape has too few vertices, or no vertex was found to have a partner.

    Raises
    ------
    Cancelled
        Through `control`.
    OptionError
        An option has no meaning for parts.
    MeshError
        The Laplacian of the whole cannot be factored.
    """
    if options.refine == GMDS:
        raise OptionError("refine", "a part is not refined; take `dense`, whose images lie between")
    is_source = partial == SOURCE or (partial == BOTH and _is_bent_onto(source, target))
    pairs = landmark_vertices(options.landmarks, source.mesh, target.mesh)
    ours, theirs = pairs.T

    def registered(is_source: bool, control: Control) -> PartMap | None:
        whole, part = (target, source) if is_source else (source, target)
        return register_part(
            source,
            target,
            control,
            OF_OVERLAP if partial == BOTH else OF_PART,
            source_is_part=is_source,
            scale=None if whole.normalise else whole.size / part.size,
            landmarks=(ours, theirs),
            wholly=wholly,
        )

    with control.stage(STAGE, 0.3):
        found = registered(is_source, control.between(0.3, 0.45))
        if found is not None and _may_bend_either(found, partial) and not control.expired:
            other = registered(not is_source, control.between(0.45, 0.6))
            if other is not None:
                best, worse = sorted((found, other), key=lambda one: one.score)
                found = best.among(worse, control)
    if found is None or not all(one.covered.any() for one in found.sides):
        return None
    return KnownPart(found, partial, pairs)


def _is_bent_onto(source: Shape, target: Shape) -> bool:
    """Return whether the target is bent onto the source, of two parts.

    The one with less boundary is bent: its eigenfunctions know less of cuts. Of two with as much,
    it is the larger one. So the roles of the two in the match do not matter.
    """
    ours, theirs = ((one.mesh.relative_boundary, -one.mesh.area) for one in (source, target))
    return ours > theirs


def _may_bend_either(found: PartMap, partial: str) -> bool:
    """Return whether the other of two parts is bent as well: in doubt, where both may lack much."""
    doubtful = not found.confidence.is_likely
    return partial == BOTH and doubtful and are_cut_across(found.source.shape, found.target.shape)


def match_part(known: KnownPart, options: MatchOptions, control: Control) -> Match:
    """Match a registered part.

    Parameters
    ----------
    known
        The registration.
    options
        Of the match. Of the structures only the metric between points is kept: geodesic distance.
    control
        Reports progress and cancels.

    Raises
    ------
    Cancelled
        Through `control`.
    MeshError
        Distances along a shape cannot be computed.
    """
    found = known.surfaces
    source, target = (_at_one_scale(one) for one in found.sides)
    given, options = options, _of_parts(options).settled(1.0)
    with control.stage("structures", 0.6):
        count = min(options.points, source.n_vertices, target.n_vertices)
        targets = min(count * options.oversampling, target.n_vertices)
        level = build_level(source, target, 0, (count, targets), options, known.landmarks)
    best, level = _placed(source, target, known, level, control)
    stages = Stages.of(control)
    best = certify(best, [level], stages.certification)
    proof = prove_over_samples([best], level, options, stages.proof)
    ids = source.mesh.vertex_ids, target.mesh.vertex_ids
    missed = _contradictions(target, known)
    warnings = (*too_few(count, options), *_without_effect(given), *missed)
    report = report_match([best], [level], ids, warnings, control, proof)
    return replace(
        report,
        dense=found.dense() if options.dense else None,
        confidence=found.confidence.against_landmarks() if missed else found.confidence,
        overlap=_overlap(known),
    )


def _of_parts(options: MatchOptions) -> MatchOptions:
    cost = options.occlusion_cost
    return replace(
        options,
        metric=(Geodesic(),),
        first_order_weight=0.0,
        third_order=0.0,
        occlusion_cost=_OCCLUSION_COST if cost is None else cost,
    )


def _without_effect(given: MatchOptions) -> tuple[str, ...]:
    """Name the options that were given, and that parts do not have."""
    usual = MatchOptions()
    named = [
        f"`{name}`"
        for name in _OF_WHOLES
        if getattr(given, name) != getattr(usual, name)
        and not (name == "metric" and all(one == Geodesic() for one in given.metrics))
    ]
    if not named:
        return ()
    last = f"{', '.join(named[:-1])} and {named[-1]} have" if named[1:] else f"{named[0]} has"
    return (
        "a part is registered, and its points are matched near their images, at one level, by"
        f" geodesic distance: {last} no effect",
    )


def _at_one_scale(side: Side) -> Shape:
    """A shape at the scale where the surface that was bent has unit area."""
    shape = side.shape
    mesh = shape.mesh.scaled(1.0 / side.unit)
    return Shape(mesh, normalise=False, geodesic_method=shape.geodesic_method)


def _placed(
    source: Shape, target: Shape, known: KnownPart, level: Level, control: Control
) -> tuple[Hypothesis, Level]:
    """Match the points near their images, at the scale where the whole has unit area."""
    points = level.source.vertices
    images = known.images[points]
    mapped = known.mapped[points]
    with (clock := control.timed()).stage("refinement"), control.stage("refinement"):
        wider = add_target_samples(source, target, level, images)
        placed = match_near_images(target, wider, images, 1.0, mapped)
    assert placed is not None  # as points may stay unmatched
    return Hypothesis((solved_level(placed, clock.timings["refinement"]),)), wider


def _contradictions(target: Shape, known: KnownPart) -> tuple[str, ...]:
    """Landmarks that the registration contradicts, at the scale where the whole has unit area."""
    here, there = known.landmarks.T
    positions = target.mesh.vertices
    return contradictions(positions[known.images[here]], positions[there], 1.0)


def _overlap(known: KnownPart) -> Overlap:
    ours, theirs = known.surfaces.sides
    return Overlap(known.partial, theirs.unit / ours.unit, ours.share, theirs.share)
