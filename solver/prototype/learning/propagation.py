"""Propagation of the reference's points through a class, from each shape to the most similar ones.

A match of two shapes errs where they differ much, but in a class most shapes are similar to some
other one. So points go from the reference to the shape nearest to it by its eigenvalues, and on
from all shapes that have them. Each registration must be cycle-consistent: a second one, made
without knowledge of the first, brings the points back.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.control import Control
from solver.prototype.matching import MappedPoints, map_points
from solver.prototype.surfaces import EIGENVALUES, ExampleSurface, first_eigenvalues, surface_of
from solver.shape import Shape

_STAGE = "matches of the examples"

_MAX_CYCLE_ERROR = 0.3
"""Geodesic distance over √area within which every point must come back, chosen on generated
shapes."""


@dataclass(frozen=True, eq=False)
class PropagatedPoints:
    """Images of the reference's points on the shapes of a class.

    Parameters
    ----------
    vertices
        By place, (N,) vertices of the reference and of every shape that was reached.
    unreached
        Places of the shapes to which no registration is accepted.
    """

    vertices: Mapping[int, IntArray]
    unreached: tuple[int, ...]


def propagate_points(
    shapes: Sequence[Shape], reference: int, own: IntArray, control: Control
) -> PropagatedPoints:
    """Propagate points to all shapes that accepted registrations reach.

    Certain ones come first, as further shapes may be more similar to theirs. Those that are
    accepted but not certain follow, the likeliest first.

    Parameters
    ----------
    shapes
        M shapes.
    reference
        Place of the shape that has the points.
    own
        (N,) its vertices.
    control
        Reports progress and cancels.

    Raises
    ------
    Cancelled
        Through `control`.
    """
    eigenvalues = {n: first_eigenvalues(shape) for n, shape in enumerate(shapes)}
    front = _Front(
        shapes,
        control.quiet(),
        {n: np.log(one) for n, one in eigenvalues.items() if len(one) == EIGENVALUES},
    )
    front.reach(reference, own)
    while front.waiting and front.surfaces:
        control.report(_STAGE, len(front.reached) / len(shapes))
        place = front.next_to_try()
        if place is not None:
            found = front.try_map(place)
            if found is None or not found.confidence.is_sure:
                continue
        elif front.uncertain:
            place = max(front.uncertain, key=lambda n: front.uncertain[n].confidence.probability)
            found = front.uncertain[place]
        else:
            break
        front.reach(place, found.vertices)
    unreached = tuple(sorted(front.waiting)) if front.surfaces else ()
    return PropagatedPoints(front.reached, unreached)


@dataclass
class _Front:
    """State of a propagation.

    Parameters
    ----------
    shapes
        The class.
    control
        May cancel.
    logarithms
        By place, logarithms of the first eigenvalues of the shapes that have enough of them.
    reached
        By place, (N,) vertices of the shapes that have the points.
    surfaces
        Surfaces of these, with their places.
    uncertain
        By place, accepted points of waiting shapes that are not certain.
    waiting
        Places of the shapes that may still get the points.
    nearest
        By place of a waiting shape, distance of its eigenvalues from those of the nearest shape
        with a surface; `tried` has that distance when points of it were last sought.
    """

    shapes: Sequence[Shape]
    control: Control
    logarithms: Mapping[int, FloatArray]
    reached: dict[int, IntArray] = field(default_factory=dict)
    surfaces: list[tuple[ExampleSurface, int]] = field(default_factory=list)
    uncertain: dict[int, MappedPoints] = field(default_factory=dict)
    waiting: set[int] = field(init=False)
    nearest: dict[int, float] = field(init=False)
    tried: dict[int, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.waiting = set(self.logarithms)
        self.nearest = dict.fromkeys(self.waiting, np.inf)

    def reach(self, place: int, vertices: IntArray) -> None:
        """Give a shape the points, and let its surface serve further shapes."""
        self.reached[place] = vertices
        self.uncertain.pop(place, None)
        if place not in self.waiting:
            return
        self.waiting.discard(place)
        surface = surface_of(self.shapes[place], vertices)
        if surface is None:
            return
        self.surfaces.append((surface, place))
        for n in self.waiting:
            distance = float(np.linalg.norm(self.logarithms[n] - self.logarithms[place]))
            self.nearest[n] = min(self.nearest[n], distance)

    def next_to_try(self) -> int | None:
        """Return the waiting shape nearest to a surface, if it was not tried from as near."""
        nearest, tried = self.nearest, self.tried
        nearer = [n for n in sorted(self.waiting) if nearest[n] < tried.get(n, np.inf)]
        return min(nearer, key=lambda n: (n in tried, nearest[n])) if nearer else None

    def try_map(self, place: int) -> MappedPoints | None:
        """Map the points to a shape; return the likeliest accepted images so far."""
        self.tried[place] = self.nearest[place]
        surfaces = [surface for surface, _ in self.surfaces]
        found = map_points(surfaces, self.shapes[place], (), self.control)
        known = self.uncertain.get(place)
        if found is None:
            return known
        if known is not None and found.confidence.probability < known.confidence.probability:
            return known
        start = next(n for surface, n in self.surfaces if surface is found.surface)
        ends = (self.shapes[start], self.reached[start]), (self.shapes[place], found.vertices)
        if is_cycle_consistent(*ends, self.control) is False:
            return known
        self.uncertain[place] = found
        return found


def is_cycle_consistent(
    start: tuple[Shape, IntArray], end: tuple[Shape, IntArray], control: Control
) -> bool | None:
    """Return whether a registration back brings points to where they were.

    Parameters
    ----------
    start, end
        Both shapes, and corresponding (N,) vertices of them.
    control
        May cancel.

    Returns
    -------
    ``None`` if no registration back is accepted.

    Raises
    ------
    Cancelled
        Through `control`.
    """
    surface = surface_of(*end)
    if surface is None:
        return None
    shape, own = start
    back = map_points([surface], shape, (), control)
    if back is None:
        return None
    distances = shape.metric("geodesic").distances(own)[np.arange(len(own)), back.vertices]
    return bool((distances <= _MAX_CYCLE_ERROR * shape.size).all())
