"""Registrations of surfaces of a prototype's examples to a target.

A hypothesis of the most likely correspondence is right or wrong as a whole, which distributions of
single distances hardly show. A surface does, bent onto the target. So the most similar surfaces are
registered to it, beginning at a match of each with the target and at the prototype's hypotheses.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from solver.arrays import IntArray
from solver.control import Control
from solver.errors import MeshError, OptionError
from solver.matching import CANDIDATES, MatchOptions, match
from solver.prototype.surfaces import (
    ExampleSurface,
    SurfaceSpectra,
    compute_spectrum,
    nearest_surfaces,
)
from solver.registration import Confidence, Points, Registration, register
from solver.shape import Shape

_MAX_SURFACES = 3
"""Surfaces that are registered, the most similar first: chosen on generated people and animals."""

_POINTS = 8
"""Points of a surface's own matches with the target: torso and limbs."""

_SOLUTIONS = 32
"""Best solutions that registrations begin at, in each metric: the more, the likelier is a right one
among them. With 8 in one metric, a third of generated animals less is right."""


@dataclass(frozen=True, eq=False)
class MappedPoints:
    """Images of a prototype's points under the registration of an example's surface.

    Parameters
    ----------
    vertices
        (N,) vertices of the target.
    confidence
        In the registration, which is likely to be right.
    surface
        The surface that is registered.
    """

    vertices: IntArray
    confidence: Confidence
    surface: ExampleSurface


def map_points(
    surfaces: Sequence[ExampleSurface],
    target: Shape,
    hypotheses: Sequence[Points],
    control: Control,
    spectra: SurfaceSpectra = compute_spectrum,
) -> MappedPoints | None:
    """Map a prototype's points to a target by the surface that is registered best.

    Parameters
    ----------
    surfaces
        Of the prototype.
    target
        The shape Y.
    hypotheses
        (n,) points of the prototype and (n,) vertices of the target that correspond, as many as
        there are.
    control
        May cancel, and reports progress in doubt; past its deadline, less is tried.
    spectra
        Computes spectra of surfaces, or takes them from a cache.

    Returns
    -------
    ``None`` if no registration is likely to be right: for shapes unlike all examples, none is.

    Raises
    ------
    Cancelled
        Through `control`.
    """
    found: list[tuple[Registration, IntArray, ExampleSurface]] = []
    for number, surface in enumerate(nearest_surfaces(surfaces, target, _MAX_SURFACES)):
        part = control.between(number / _MAX_SURFACES, (number + 1) / _MAX_SURFACES)
        if found and control.expired:
            break
        try:
            source = surface.shape(target, spectra)
            known = [(surface.points, images) for _, images, _ in found]
            given = [(surface.points[x], y) for x, y in hypotheses]
            starts = [*known, *given, *_own_matches(source, target, control.quiet())]
            # The other surfaces are other ways to the answer.
            registration = register(source, target, starts, part, others=False)
        except (MeshError, OptionError):  # archives may hold any surface
            continue
        if registration is None:
            continue
        found.append((registration, registration.images(surface.points, part), surface))
    if not found:
        return None
    best, images, surface = min(found, key=lambda one: one[0].score)
    if not best.confidence.is_likely:
        return None
    return MappedPoints(images, best.confidence, surface)


def _own_matches(source: Shape, target: Shape, control: Control) -> Iterator[Points]:
    """Yield corresponding vertices of a surface and the target, by matches of a few points."""
    points = min(_POINTS, source.n_vertices, target.n_vertices)
    for metric in "commute_time", "geodesic":
        options = MatchOptions(
            points=points,
            alternatives=_SOLUTIONS,
            metric=(metric,),
            orientation=False,
            proof=CANDIDATES,
        )
        found = match(source, target, options, control)
        for one in (found.best, *found.alternatives):
            yield source.mesh.vertices_of(one.source), target.mesh.vertices_of(one.target)
