"""Orientation stage: the hypothesis whose extension to all vertices preserves orientation.

An intrinsic symmetry, such as the exchange of left and right, leaves all distances as they are, so
that hypotheses include mirror images of one another. Their extensions to all vertices differ: only
one preserves the orientation of the surface. Hypotheses come in; the chosen hypothesis, placed at
the images of its map, and the map come out.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from solver.arrays import FloatArray
from solver.control import Control
from solver.functional_maps import DenseMap, select_map
from solver.labelling import LINF
from solver.matching.hypothesis import Hypothesis, move_to_front, rank_of
from solver.matching.level import Level
from solver.matching.options import MatchOptions
from solver.matching.placement import add_target_samples, match_near_images
from solver.matching.refinement import hypothesis_from_map, solved_level
from solver.shape import Shape


@dataclass(frozen=True, eq=False)
class Orientation:
    """Hypotheses in the order of the orientation stage.

    Parameters
    ----------
    hypotheses
        The chosen one first.
    levels
        Levels of the chosen one; the target samples of the finest include the images of its map.
    dense_map
        The chosen map of all vertices, if one was asked for and found.
    warnings
        For the user.
    """

    hypotheses: list[Hypothesis]
    levels: list[Level]
    dense_map: DenseMap | None = None
    warnings: tuple[str, ...] = ()


def orient(
    source: Shape,
    target: Shape,
    hypotheses: Sequence[Hypothesis],
    levels: Sequence[Level],
    options: MatchOptions,
    control: Control,
) -> Orientation:
    """Extend hypotheses to all vertices, and choose the best orientation-preserving map.

    Where no hypothesis has such a map and no landmarks say which symmetry is meant, further maps
    are made (:func:`.select_map`), and a hypothesis is begun there. The points of the chosen
    hypothesis are matched again near their images. With objective ``"linf"`` the hypotheses and
    their order stay as they are.

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

    Raises
    ------
    Cancelled
        Through `control`.
    """
    unchanged = Orientation(list(hypotheses), list(levels))
    if not options.extended:
        return unchanged
    with control.stage("dense map", 0.5):
        points = [one.vertices(levels[-1]) for one in hypotheses]
        minimax = options.objective == LINF
        further = not (options.landmarks or minimax)
        found = select_map(source, target, points, control, further)
    if found is None:
        return replace(
            unchanged, warnings=("too few points were matched for a map of all vertices",)
        )
    if minimax:
        return replace(unchanged, dense_map=found)
    if found.hypothesis == len(hypotheses):
        distances = _distances_from_images(target, found, levels[0])
        with control.stage("dense map"):
            further_one = hypothesis_from_map(levels, distances, hypotheses, options.rho, control)
        hypotheses = [*hypotheses, further_one]
    ordered = move_to_front(hypotheses, found.hypothesis)
    found = replace(found, hypothesis=0)
    ordered[0], finest = _place(source, target, ordered, found, levels[-1], control)
    return Orientation(ordered, [*levels[:-1], finest], found)


def _distances_from_images(target: Shape, found: DenseMap, coarse: Level) -> FloatArray:
    """(N, M) distances in space from images of coarse source samples to coarse target samples."""
    positions = target.surface.vertices
    images = positions[found.images(coarse.source.vertices)]
    samples = positions[coarse.target.vertices]
    distances: FloatArray = np.linalg.norm(images[:, None] - samples[None], axis=2)
    return distances


def _place(
    source: Shape,
    target: Shape,
    hypotheses: Sequence[Hypothesis],
    found: DenseMap,
    finest: Level,
    control: Control,
) -> tuple[Hypothesis, Level]:
    """Match the points of the first hypothesis near their images, if there is room for all."""
    first = hypotheses[0]
    with (clock := control.timed()).stage("refinement"), control.stage("refinement"):
        control.report("points of the map", 0.55)
        images = found.images(finest.source.vertices)
        wider = add_target_samples(source, target, finest, images)
        placed = match_near_images(target, wider, images)
    if placed is None:
        return first, finest
    seconds = first.levels[-1].seconds + clock.timings["refinement"]
    rank = rank_of(placed.energy, hypotheses[1:])
    return first.with_finest(solved_level(placed, rank, seconds)), wider
