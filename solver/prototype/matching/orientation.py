"""Left and right of a match with a prototype, and which legs go together, by its surfaces.

A hypothesis of the most likely correspondence is right or wrong as a whole, which distributions of
single distances hardly see. Maps of all vertices do: those from the surfaces of the most similar
examples to the target, begun at the hypotheses, and at what a match of both surfaces finds.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from solver.arrays import IntArray
from solver.control import Control
from solver.errors import MeshError, OptionError
from solver.functional_maps import (
    LEAST_EXTENDED,
    QUICK,
    Comparison,
    DenseMap,
    Side,
    composed,
    extensions,
    oriented_first,
    reflection,
)
from solver.matching import MatchOptions, match
from solver.prototype.surfaces import ExampleSurface, SurfaceSpectra, computed, nearest_surfaces
from solver.shape import Shape

_SURFACES = 3
"""That are tried, the most similar first."""

_POINTS = 16
_MATCHES = 3
"""Points and hypotheses of the match of both surfaces."""

_METRIC = "commute_time"
"""Of that match: it takes no searches over the surface."""

_HYPOTHESES = 4
"""Of the prototype's, that are tried."""

_APART = 0.4
"""Distance of some point's partners, over √area, from which on two hypotheses are different."""

CLEAR, CERTAIN = 0.55, 0.8
"""Orientation of a map that is believed, and of one that ends the search."""

_MORE = 1.5
"""Times the change of a map's mirror image from which on it is not the same, reflected."""


@dataclass(frozen=True, eq=False)
class OrientedImages:
    """Where a map that keeps orientation has a prototype's points.

    Parameters
    ----------
    vertices
        (N,) of the target.
    orientation
        Of the map, at least `CLEAR`: the more, the surer.
    surface
        That it maps.
    """

    vertices: IntArray
    orientation: float
    surface: ExampleSurface


def oriented_images(
    surfaces: Sequence[ExampleSurface],
    target: Shape,
    hypotheses: Sequence[tuple[IntArray, IntArray]],
    control: Control,
    spectrum: SurfaceSpectra = computed,
    careful: bool = False,
) -> OrientedImages | None:
    """Find where a prototype's points are on a target, by a map that keeps orientation.

    Parameters
    ----------
    surfaces
        Of the prototype.
    target
        The shape Y.
    hypotheses
        (n,) points of the prototype and (n,) vertices of Y that correspond, the most likely first.
    control
        May cancel; past its deadline, less is tried.
    spectrum
        Takes spectra of surfaces from where they are kept, or computes them.
    careful
        Whether to believe nothing that contradicts itself, as where nothing else judges the answer.

    Returns
    -------
    ``None`` if no map keeps orientation clearly: of shapes that no example is like, none does.

    Raises
    ------
    Cancelled
        Through `control`.
    """
    nearest = nearest_surfaces(surfaces, target, _SURFACES)
    if not nearest:
        return None
    found: list[tuple[DenseMap, ExampleSurface]] = []
    there, different = Side.of_target(target), _different(target, hypotheses)
    for surface in nearest:
        if found and not control.seconds_left():
            break
        try:
            source = surface.shape(target, spectrum)
            maps = _maps(source, surface, there, different, control)
        except (MeshError, OptionError):  # of a surface that anybody may have written
            continue
        found += [(one, surface) for one in maps]
        if _first(found)[0].orientation >= CERTAIN:
            break
    if not found:
        return None
    return _verified(found, there, control) if careful else _decided(found, control)


def _decided(
    found: Sequence[tuple[DenseMap, ExampleSurface]], control: Control
) -> OrientedImages | None:
    """Where the best of some maps has the points, if it keeps orientation clearly."""
    best, surface = _first(found)
    clear = best.orientation >= CLEAR
    reversing, other = _first(found, turn=-1)
    better = not clear or best.change > _MORE * reversing.change
    if better and reversing.orientation <= -CLEAR and control.seconds_left() > 0.0:
        # A clear mirror image, reflected before, rather than a mixture that preserves less.
        reflected = reflection(reversing.source, control)
        if reflected is not None:
            images = reversing.images(reflected.images(other.points))
            return OrientedImages(images, -reversing.orientation, other)
    if not clear:
        return None
    return OrientedImages(best.images(surface.points), best.orientation, surface)


def _verified(
    found: Sequence[tuple[DenseMap, ExampleSurface]], there: Side, control: Control
) -> OrientedImages | None:
    """The same, where what is reflected is looked at again, and no other map contradicts it."""
    best, surface = _first(found)
    reversing, other = _first(found, turn=-1)
    better = best.orientation < CLEAR or best.change > _MORE * reversing.change
    if better and reversing.orientation <= -CLEAR:
        # A clear mirror image, reflected, rather than a mixture that preserves less.
        reflected = [(one, other) for one in _reflected(reversing, there, control)]
        best, surface = _first([*found, *reflected])
    images = best.images(surface.points)
    if best.orientation < CLEAR or _contradicted(best, images, found, there.shape):
        return None
    return OrientedImages(images, best.orientation, surface)


def _contradicted(
    best: DenseMap,
    images: IntArray,
    found: Sequence[tuple[DenseMap, ExampleSurface]],
    target: Shape,
) -> bool:
    """Whether a map that reverses orientation as clearly has the points at the same places.

    One of both then has the front of a body at its back: limbs do not tell which.
    """
    as_clear = [
        one.images(surface.points)
        for one, surface in found
        if one.orientation <= -best.orientation and one.change <= _MORE * best.change
    ]
    if not as_clear:
        return False
    distances = target.metric("geodesic").distances(images)
    rows = np.arange(len(images))
    return any((distances[rows, there] <= _APART * target.size).all() for there in as_clear)


def _reflected(reversing: DenseMap, there: Side, control: Control) -> Iterator[DenseMap]:
    """Compose a map with the reflection of its source; if that leaves doubt, of its target."""
    comparison, sure = Comparison(reversing.source, there), False
    for shape in reversing.source, there.shape:
        if sure or not control.seconds_left():
            return
        mirrored = reflection(shape, control)
        if mirrored is None:
            continue
        ends = (mirrored, reversing) if shape is reversing.source else (reversing, mirrored)
        for one in composed(comparison, *ends, control):
            sure = sure or one.orientation >= CERTAIN
            yield one


def _first(
    found: Sequence[tuple[DenseMap, ExampleSurface]], turn: int = 1
) -> tuple[DenseMap, ExampleSurface]:
    """Return the map that :func:`oriented_first` has first, and where it comes from."""
    best = oriented_first([one for one, _ in found], turn)[0]
    return next(entry for entry in found if entry[0] is best)


def _maps(
    source: Shape,
    surface: ExampleSurface,
    there: Side,
    hypotheses: Sequence[tuple[IntArray, IntArray]],
    control: Control,
) -> list[DenseMap]:
    """Maps from one surface: of its own match with the target.

    If they leave doubt, more careful ones of that, and of the prototype's hypotheses.
    """
    target = there.shape
    points = min(_POINTS, source.n_vertices, target.n_vertices)
    options = MatchOptions(points=points, alternatives=_MATCHES, metric=(_METRIC,))
    quiet = Control(is_cancelled=control.is_cancelled, deadline=control.deadline)
    answer = match(source, target, options, quiet)
    own = [
        (source.mesh.vertices_of(one.source), target.mesh.vertices_of(one.target))
        for one in (answer.best, *answer.alternatives)
    ]
    comparison = Comparison(source, there)
    maps = extensions(comparison, own[:_MATCHES], control, effort=QUICK)
    if oriented_first(maps)[0].orientation < CERTAIN:
        given = [(surface.points[x], y) for x, y in hypotheses]
        maps = extensions(comparison, [*own[:_MATCHES], *given], control)
    return maps


def _different(
    target: Shape, hypotheses: Sequence[tuple[IntArray, IntArray]]
) -> list[tuple[IntArray, IntArray]]:
    """The first hypotheses that are not nearly the same as one before."""
    kept: list[tuple[IntArray, IntArray]] = []
    for one in hypotheses:
        if len(one[0]) >= LEAST_EXTENDED and all(
            _apart(target, one, other) > _APART * target.size for other in kept
        ):
            kept.append(one)
        if len(kept) == _HYPOTHESES:
            break
    return kept


def _apart(
    target: Shape, one: tuple[IntArray, IntArray], other: tuple[IntArray, IntArray]
) -> float:
    """Greatest distance of a point's partners in two hypotheses."""
    _, here, there = np.intersect1d(one[0], other[0], return_indices=True)
    distances = target.metric("geodesic").distances(one[1][here])
    return float(distances[np.arange(len(here)), other[1][there]].max(initial=0.0))
