"""Orientation stage: the hypothesis that agrees with a registration of the surfaces.

An intrinsic symmetry, such as the exchange of left and right, leaves all distances as they are, so
that hypotheses include mirror images of one another. Bent onto the target in space, only one fits.
Hypotheses come in; the chosen one, with its points matched near the images of the registration, and
the registration come out.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.control import Control
from solver.labelling import LINF
from solver.matching.enumeration import further_solutions
from solver.matching.hypothesis import Hypothesis, move_to_front
from solver.matching.landmarks import contradictions
from solver.matching.level import Level
from solver.matching.options import MatchOptions
from solver.matching.placement import add_target_samples, match_near_images
from solver.matching.refinement import hypothesis_from_map, solved_level
from solver.matching.sampling import common_size, sample
from solver.registration import RIGHT_ERROR, STAGE, Points, Registration, register
from solver.shape import Shape

_COARSE_SOLUTIONS = 32
"""Coarse solutions that registrations begin at, in the first and in the last metric each: the more,
the likelier is a right one among them."""


@dataclass(frozen=True, eq=False)
class Orientation:
    """Hypotheses in the order of the orientation stage.

    Parameters
    ----------
    hypotheses
        The chosen one first.
    levels
        Levels of the chosen one; the target samples of the finest include the images of its map.
    registration
        Of the shapes, if one was asked for and found.
    place
        Place of the hypothesis that agrees best with the registration.
    warnings
        For the user.
    """

    hypotheses: list[Hypothesis]
    levels: list[Level]
    registration: Registration | None = None
    place: int = 0
    warnings: tuple[str, ...] = ()


def orient(
    source: Shape,
    target: Shape,
    hypotheses: Sequence[Hypothesis],
    levels: Sequence[Level],
    options: MatchOptions,
    control: Control,
    *,
    may_be_glued: bool = True,
) -> Orientation:
    """Register the surfaces, and choose the hypothesis that agrees with the registration.

    Where none does, a hypothesis is begun there. The points of the chosen one are matched again
    near their images. With objective ``"linf"`` the hypotheses and their order stay as they are.

    Parameters
    ----------
    source, target
        The shapes X and Y.
    hypotheses
        Refined to the finest level, the likeliest first.
    levels
        Of the match.
    options
        Of the match.
    control
        Reports progress and cancels; past its deadline, less is tried.
    may_be_glued
        Whether surfaces with handles are opened in doubt.

    Raises
    ------
    Cancelled
        Through `control`.
    """
    unchanged = Orientation(list(hypotheses), list(levels))
    if not options.registered:
        return unchanged
    with control.stage(STAGE, 0.0):
        starts = _starts(hypotheses, levels, options, control)
        landmarks = _landmarks(levels[0])
        again = partial(_rematched, options=options, control=control)
        rematch = again if may_be_glued else None
        found = register(source, target, starts, control, landmarks, rematch=rematch)
    if found is None:
        return replace(unchanged, warnings=("the shapes have too few vertices to be registered",))
    apart = [_distance(target, one.vertices(levels[-1]), found, control) for one in hypotheses]
    nearest = int(np.argmin(apart))
    missed = _contradictions(target, landmarks, found, control)
    if missed:
        found = replace(found, confidence=found.confidence.against_landmarks())
    warnings = (
        *missed,
        *((_REFLECTED,) if found.reflected and not len(landmarks[0]) else ()),
        *((_GLUED,) if found.glued else ()),
    )
    if options.objective == LINF:
        return replace(unchanged, registration=found, place=nearest, warnings=warnings)
    if apart[nearest] > RIGHT_ERROR:
        distances = _distances_from_images(target, found, levels[0], control)
        with control.stage(STAGE):
            further = hypothesis_from_map(levels, distances, hypotheses, options.rho, control)
        hypotheses, nearest = [*hypotheses, further], len(hypotheses)
    ordered = move_to_front(hypotheses, nearest)
    ordered[0], finest = _place(source, target, ordered, found, levels[-1], control)
    return Orientation(ordered, [*levels[:-1], finest], found, warnings=warnings)


_REFLECTED = (
    "the source fits the target only as its mirror image: one of the two seems to be reflected in"
    " space"
)

_GLUED = (
    "parts of the shapes that touch seem to be glued together; they were taken apart for the"
    " registration"
)


def _starts(
    hypotheses: Sequence[Hypothesis],
    levels: Sequence[Level],
    options: MatchOptions,
    control: Control,
) -> list[Points]:
    """Corresponding vertices of the hypotheses, and of further solutions for the same samples."""
    refined = [one.vertices(levels[-1]) for one in hypotheses]
    if options.objective == LINF:
        return refined
    return [*refined, *_further(levels, control)]


def _rematched(
    source: Shape, target: Shape, options: MatchOptions, control: Control
) -> list[Points]:
    """Coarse solutions of shapes that were opened, which no level of the match knows."""
    silent = control.quiet()
    levels, _ = sample(source, target, options.settled(common_size(source, target)), silent)
    return _further(levels, silent)


def _further(levels: Sequence[Level], control: Control) -> list[Points]:
    coarse = levels[0]
    found = further_solutions(coarse, coarse, _COARSE_SOLUTIONS, control)
    if levels[-1] is not coarse:
        found += further_solutions(coarse, levels[-1], _COARSE_SOLUTIONS, control)
    return found


def _landmarks(level: Level) -> Points:
    count = level.landmarks
    return level.source.vertices[:count], level.target.vertices[:count]


def _distance(target: Shape, points: Points, found: Registration, control: Control) -> float:
    """Mean distance in space of partners from images, over √area."""
    here, there = points
    if not len(here):
        return np.inf
    positions = target.surface.vertices
    apart = positions[found.images(here, control)] - positions[there]
    return float(np.linalg.norm(apart, axis=1).mean()) / target.size


def _contradictions(
    target: Shape, landmarks: Points, found: Registration, control: Control
) -> tuple[str, ...]:
    here, there = landmarks
    if not len(here):
        return ()
    positions = target.surface.vertices
    return contradictions(positions[found.images(here, control)], positions[there], target.size)


def _distances_from_images(
    target: Shape, found: Registration, coarse: Level, control: Control
) -> FloatArray:
    """(N, M) distances in space from images of coarse source samples to coarse target samples."""
    positions = target.surface.vertices
    images = positions[found.images(coarse.source.vertices, control)]
    samples = positions[coarse.target.vertices]
    distances: FloatArray = np.linalg.norm(images[:, None] - samples[None], axis=2)
    return distances


def _place(
    source: Shape,
    target: Shape,
    hypotheses: Sequence[Hypothesis],
    found: Registration,
    finest: Level,
    control: Control,
) -> tuple[Hypothesis, Level]:
    """Match the points of the first hypothesis near their images, if there is room for all."""
    first = hypotheses[0]
    with (clock := control.timed()).stage("refinement"), control.stage("refinement"):
        control.report("points of the map", 1.0)
        images: IntArray = found.images(finest.source.vertices, control)
        wider = add_target_samples(source, target, finest, images)
        placed = match_near_images(target, wider, images, target.size)
    if placed is None:
        return first, finest
    seconds = first.levels[-1].seconds + clock.timings["refinement"]
    return first.with_finest(solved_level(placed, seconds)), wider
