"""The reference's points carried to the other examples, from each to those most similar to it.

A match of two shapes errs where they differ much. In a class, most shapes are like some other one;
so points go from the reference to the shape nearest to it, and on from whatever has them already.
Where there are few examples nothing overrules one that is wrong; so each time they are carried back
as well, by maps that know nothing of those on the way there, and what contradicts itself is not
believed.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from solver.arrays import IntArray
from solver.control import Control
from solver.prototype.matching import CERTAIN, OrientedImages, oriented_images
from solver.prototype.surfaces import EIGENVALUES, ExampleSurface, first_eigenvalues, surface_of
from solver.shape import Shape

_STAGE = "matches of the examples"

_LEAST = 0.65
"""Orientation of maps that are believed. Of generated animals those of less are wrong as often as
right; those of more, up to what is certain, are right if points come back."""

_BACK = 0.3
"""Distance over √area from where it was within which every point must come back."""


@dataclass(frozen=True, eq=False)
class CarriedPoints:
    """Where the points are on the shapes that they reached.

    Parameters
    ----------
    vertices
        By place, (N,) vertices of the reference and of every shape that was reached; left is left
        on all of them.
    unreached
        Places of those to which no map was sure.
    """

    vertices: Mapping[int, IntArray]
    unreached: tuple[int, ...]


def carried_points(
    shapes: Sequence[Shape], reference: int, own: IntArray, control: Control
) -> CarriedPoints:
    """Carry points to the shapes that maps which keep orientation reach.

    What is certain comes first, for the rest may be nearer to that. Maps that leave some doubt
    follow, the clearest of them first.

    Parameters
    ----------
    shapes
        M shapes.
    reference
        Place of the one that has the points.
    own
        (N,) its vertices.
    control
        Reports progress and cancels.

    Raises
    ------
    Cancelled
        Through `control`.
    """
    carrying = _Carrying(shapes, control)
    carrying.add(reference, own)
    while carrying.waiting and carrying.surfaces:
        control.report(_STAGE, len(carrying.carried) / len(shapes))
        place = carrying.to_be_tried()
        if place is not None:
            found = carrying.tried(place)
            if found is None or found.orientation < CERTAIN:
                continue
        elif carrying.clear:
            place = max(carrying.clear, key=lambda n: carrying.clear[n].orientation)
            found = carrying.clear[place]
        else:
            break
        carrying.add(place, found.vertices)
    tried = tuple(sorted(carrying.waiting)) if carrying.surfaces else ()
    return CarriedPoints(carrying.carried, tried)


class _Carrying:
    """Points on their way through a class.

    Parameters
    ----------
    shapes
        The class.
    control
        May cancel.

    Attributes
    ----------
    carried
        By place, (N,) vertices of the shapes that have the points.
    surfaces
        Of these, with their places.
    waiting
        Places of those that may come to have them.
    clear
        Where maps that leave some doubt have the points on those.
    """

    def __init__(self, shapes: Sequence[Shape], control: Control) -> None:
        self._shapes = shapes
        self._control = Control(is_cancelled=control.is_cancelled, deadline=control.deadline)
        described = [first_eigenvalues(shape) for shape in shapes]
        self.waiting = {n for n, one in enumerate(described) if len(one) == EIGENVALUES}
        self._logarithms = {n: np.log(described[n]) for n in self.waiting}
        self.carried: dict[int, IntArray] = {}
        self.surfaces: list[tuple[ExampleSurface, int]] = []
        self.clear: dict[int, OrientedImages] = {}
        self._nearest: dict[int, float] = dict.fromkeys(self.waiting, np.inf)
        # How near the nearest one was that had the points when it was tried.
        self._tried: dict[int, float] = {}

    def add(self, place: int, vertices: IntArray) -> None:
        """Let a shape have the points."""
        self.carried[place] = vertices
        self.clear.pop(place, None)
        if place not in self.waiting:
            return
        self.waiting.discard(place)
        surface = surface_of(self._shapes[place], vertices)
        if surface is None:
            return
        self.surfaces.append((surface, place))
        for n in self.waiting:
            apart = float(np.linalg.norm(self._logarithms[n] - self._logarithms[place]))
            self._nearest[n] = min(self._nearest[n], apart)

    def to_be_tried(self) -> int | None:
        """Find the shape nearest to one that has the points, if it was not tried from so near."""
        nearest, tried = self._nearest, self._tried
        nearer = [n for n in sorted(self.waiting) if nearest[n] < tried.get(n, np.inf)]
        return min(nearer, key=lambda n: (n in tried, nearest[n])) if nearer else None

    def tried(self, place: int) -> OrientedImages | None:
        """Carry points to a shape and back."""
        self._tried[place] = self._nearest[place]
        surfaces = [surface for surface, _ in self.surfaces]
        found = oriented_images(surfaces, self._shapes[place], (), self._control, careful=True)
        known = self.clear.get(place)
        least = _LEAST if known is None else known.orientation
        if found is None or found.orientation < least:
            return known
        start = next(n for surface, n in self.surfaces if surface is found.surface)
        ends = (self._shapes[start], self.carried[start]), (self._shapes[place], found.vertices)
        if comes_back(*ends, self._control) is False:
            return known
        self.clear[place] = found
        return found


def comes_back(
    start: tuple[Shape, IntArray], end: tuple[Shape, IntArray], control: Control
) -> bool | None:
    """Whether points that were carried from a shape to another come back to where they were.

    Parameters
    ----------
    start, end
        Either shape, and its (N,) vertices.
    control
        May cancel.

    Returns
    -------
    ``None`` if no map back is sure.

    Raises
    ------
    Cancelled
        Through `control`.
    """
    surface = surface_of(*end)
    back = (
        None if surface is None else oriented_images([surface], start[0], (), control, careful=True)
    )
    if back is None:
        return None
    shape, own = start
    apart = shape.metric("geodesic").distances(own)[np.arange(len(own)), back.vertices]
    return bool((apart <= _BACK * shape.size).all())
