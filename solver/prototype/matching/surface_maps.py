"""Orientation-preserving maps from surfaces of a prototype's examples to a target.

A hypothesis of the most likely correspondence is right or wrong as a whole, which distributions of
single distances hardly show. Maps of all vertices do: they are made from the surfaces of the most
similar examples, and begin at a match of each with the target and at the prototype's hypotheses.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from solver.arrays import IntArray
from solver.control import Control
from solver.errors import MeshError, OptionError
from solver.functional_maps import (
    MIN_POINTS_EXTENDED,
    QUICK,
    ComparedShape,
    Comparison,
    DenseMap,
    compose_maps,
    extend_hypotheses,
    find_reflection,
    rank_maps,
)
from solver.matching import MatchOptions, match
from solver.prototype.surfaces import (
    ExampleSurface,
    SurfaceSpectra,
    compute_spectrum,
    nearest_surfaces,
)
from solver.shape import Shape

Points = tuple[IntArray, IntArray]
"""(n,) points of a prototype and (n,) vertices of the target that correspond."""

SurfaceMap = tuple[DenseMap, ExampleSurface]
"""A map, and the surface that it maps."""

# The constants are chosen on generated people and animals; `bench.animals` measures them.

_MAX_SURFACES = 3
"""Surfaces that are mapped, the most similar first."""

_MATCH = MatchOptions(points=16, alternatives=3, metric=("commute_time",), orientation=False)
"""Match of a surface with the target, by a metric that needs no fronts over the surface."""

_MAX_HYPOTHESES = 4
"""Hypotheses of the prototype's match that are extended."""

_DIFFERENT = 0.4
"""Geodesic distance over √area between partners of a point that makes hypotheses different."""

CLEAR, CERTAIN = 0.55, 0.8
"""Orientation scores of a map that is accepted, and of one that ends the search."""

_MIRROR_RATIO = 1.5
"""Ratio of the changes of a map and of its mirror image below which both preserve as much."""


@dataclass(frozen=True, eq=False)
class MappedPoints:
    """Images of a prototype's points under an orientation-preserving map.

    Parameters
    ----------
    vertices
        (N,) vertices of the target.
    orientation_score
        Of the map, at least `CLEAR`.
    surface
        The surface that is mapped.
    """

    vertices: IntArray
    orientation_score: float
    surface: ExampleSurface


def map_points(
    surfaces: Sequence[ExampleSurface],
    target: Shape,
    hypotheses: Sequence[Points],
    control: Control,
    spectra: SurfaceSpectra = compute_spectrum,
    verified: bool = False,
) -> MappedPoints | None:
    """Map a prototype's points to a target by an orientation-preserving map.

    Parameters
    ----------
    surfaces
        Of the prototype.
    target
        The shape Y.
    hypotheses
        Of the prototype's match, the most likely first.
    control
        May cancel; past its deadline, less is tried.
    spectra
        Computes spectra of surfaces, or takes them from a cache.
    verified
        Whether to reject maps that another map contradicts, where nothing else checks the answer.

    Returns
    -------
    ``None`` if no map clearly preserves orientation: for shapes unlike all examples, none does.

    Raises
    ------
    Cancelled
        Through `control`.
    """
    nearest = nearest_surfaces(surfaces, target, _MAX_SURFACES)
    if not nearest:
        return None
    found: list[SurfaceMap] = []
    compared, different = ComparedShape.of_target(target), _drop_similar(target, hypotheses)
    for surface in nearest:
        if found and control.expired:
            break
        try:
            source = surface.shape(target, spectra)
            maps = _extend(source, surface, compared, different, control)
        except (MeshError, OptionError):  # archives may hold any surface
            continue
        found += [(one, surface) for one in maps]
        if _best(found)[0].orientation_score >= CERTAIN:
            break
    if not found:
        return None
    return _choose_verified(found, compared, control) if verified else _choose(found, control)


def _choose(found: Sequence[SurfaceMap], control: Control) -> MappedPoints | None:
    """Choose the best map, or a clear mirror image that preserves more, reflected."""
    best, surface = _best(found)
    mirrored, other = _best(found, reversing=True)
    if _prefers_mirror_image(best, mirrored) and not control.expired:
        reflected = find_reflection(mirrored.source, control)
        if reflected is not None:
            images = mirrored.images(reflected.images(other.points))
            return MappedPoints(images, -mirrored.orientation_score, other)
    if best.orientation_score < CLEAR:
        return None
    return MappedPoints(best.images(surface.points), best.orientation_score, surface)


def _choose_verified(
    found: Sequence[SurfaceMap], compared: ComparedShape, control: Control
) -> MappedPoints | None:
    """Choose likewise, but measure reflected maps again, and reject contradicted ones."""
    best, surface = _best(found)
    mirrored, other = _best(found, reversing=True)
    if _prefers_mirror_image(best, mirrored):
        reflected = [(one, other) for one in _reflect(mirrored, compared, control)]
        best, surface = _best([*found, *reflected])
    images = best.images(surface.points)
    if best.orientation_score < CLEAR or _is_contradicted(best, images, found, compared.shape):
        return None
    return MappedPoints(images, best.orientation_score, surface)


def _prefers_mirror_image(best: DenseMap, mirrored: DenseMap) -> bool:
    """Return whether a clear mirror image is better than a map that is unclear or changes more."""
    worse = best.orientation_score < CLEAR or best.change > _MIRROR_RATIO * mirrored.change
    return worse and mirrored.orientation_score <= -CLEAR


def _is_contradicted(
    best: DenseMap, images: IntArray, found: Sequence[SurfaceMap], target: Shape
) -> bool:
    """Return whether a map that reverses orientation as clearly has nearly the same images.

    One of the two then exchanges the front of a body with its back, which limbs do not show.
    """
    as_clear = [
        one.images(surface.points)
        for one, surface in found
        if one.orientation_score <= -best.orientation_score
        and one.change <= _MIRROR_RATIO * best.change
    ]
    if not as_clear:
        return False
    distances = target.metric("geodesic").distances(images)
    rows = np.arange(len(images))
    return any((distances[rows, there] <= _DIFFERENT * target.size).all() for there in as_clear)


def _reflect(mirrored: DenseMap, compared: ComparedShape, control: Control) -> Iterator[DenseMap]:
    """Compose a map with the reflection of its source; if that is uncertain, of its target."""
    comparison, certain = Comparison(mirrored.source, compared), False
    for shape in mirrored.source, compared.shape:
        if certain or control.expired:
            return
        reflected = find_reflection(shape, control)
        if reflected is None:
            continue
        ends = (reflected, mirrored) if shape is mirrored.source else (mirrored, reflected)
        for one in compose_maps(comparison, *ends, control):
            certain = certain or one.orientation_score >= CERTAIN
            yield one


def _best(found: Sequence[SurfaceMap], reversing: bool = False) -> SurfaceMap:
    """Return the map that :func:`.rank_maps` puts first, with its surface."""
    best = rank_maps([one for one, _ in found], reversing)[0]
    return next(entry for entry in found if entry[0] is best)


def _extend(
    source: Shape,
    surface: ExampleSurface,
    compared: ComparedShape,
    hypotheses: Sequence[Points],
    control: Control,
) -> list[DenseMap]:
    """Extend a surface's own match with the target; if that is uncertain, hypotheses as well."""
    target = compared.shape
    points = min(_MATCH.points, source.n_vertices, target.n_vertices)
    answer = match(source, target, replace(_MATCH, points=points), control.quiet())
    own = [
        (source.mesh.vertices_of(one.source), target.mesh.vertices_of(one.target))
        for one in (answer.best, *answer.alternatives)
    ][: _MATCH.alternatives]
    comparison = Comparison(source, compared)
    maps = extend_hypotheses(comparison, own, control, effort=QUICK)
    if rank_maps(maps)[0].orientation_score < CERTAIN:
        given = [(surface.points[x], y) for x, y in hypotheses]
        maps = extend_hypotheses(comparison, [*own, *given], control)
    return maps


def _drop_similar(target: Shape, hypotheses: Sequence[Points]) -> list[Points]:
    """Keep the first hypotheses that differ from all earlier ones in some point."""
    kept: list[Points] = []
    for one in hypotheses:
        if len(one[0]) >= MIN_POINTS_EXTENDED and all(
            _greatest_distance(target, one, other) > _DIFFERENT * target.size for other in kept
        ):
            kept.append(one)
        if len(kept) == _MAX_HYPOTHESES:
            break
    return kept


def _greatest_distance(target: Shape, one: Points, other: Points) -> float:
    """Greatest geodesic distance between the partners of a point in two hypotheses."""
    _, here, there = np.intersect1d(one[0], other[0], return_indices=True)
    distances = target.metric("geodesic").distances(one[1][here])
    return float(distances[np.arange(len(here)), other[1][there]].max(initial=0.0))
