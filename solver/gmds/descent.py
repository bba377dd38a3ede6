"""Generalized multidimensional scaling: minimise the stress (7), point by point."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.control import Control
from solver.gmds.interpolation import InterpolatedMetric
from solver.gmds.stress import Fields, SingleArray, costs_of_vertices, descent_step, share, stress
from solver.gmds.surface import SurfacePoints

_LONGEST_STEP = 0.1
"""Of √area."""

_MOST_PLACES = 2500
"""Vertices to which a point may leap; on larger meshes, every n-th."""


class Status(StrEnum):
    """Why a descent ended."""

    CONVERGED = "converged"
    ITERATIONS = "iterations"
    DEADLINE = "deadline"


@dataclass(frozen=True, eq=False)
class GmdsSolution:
    """Points of Y whose distances are like those of X's points.

    Parameters
    ----------
    points
        N of Y's surface.
    stress
        (7) there, weighted.
    initial_stress
        (7) where the descent began; never less than `stress`.
    history
        (7) after each sweep over all points; never increasing.
    status
        Why it ended.
    """

    points: SurfacePoints
    stress: float
    initial_stress: float
    history: tuple[float, ...]
    status: Status

    @property
    def iterations(self) -> int:
        """Sweeps over all points."""
        return len(self.history)


@dataclass(frozen=True, eq=False)
class Term:
    """The stress (7) in one metric.

    Parameters
    ----------
    source
        (N, N) d_X, symmetric.
    target
        d_Y.
    weights
        (N, N) w of (7), symmetric, not negative; what is on the diagonal does not matter.
    """

    source: FloatArray
    target: InterpolatedMetric
    weights: FloatArray

    def stress(self, points: SurfacePoints) -> float:
        """(7) of N points of the surface."""
        return stress(self.source, self.target.between(points), self.weights)


def gmds(
    terms: Sequence[Term],
    initial: SurfacePoints,
    *,
    leaps: int = 0,
    iterations: int = 100,
    tolerance: float = 1e-4,
    control: Control | None = None,
) -> GmdsSolution:
    """Minimise the stress (7) over points of a surface, section 6.2.

    Points move one after the other, each by a Gauss-Newton step in its triangle's plane that goes
    on straight over edges, where that lowers the stress; the stress never rises. It finds a local
    minimum, and what it finds depends on where it begins.

    Parameters
    ----------
    terms
        The stress, or several in different metrics on the same surface, which add up.
    initial
        N points of Y to begin with.
    leaps
        How many times, before the descent, every point may leap to whichever vertex of Y lowers
        the stress most.
    iterations
        Sweeps over all points, at most.
    tolerance
        The descent has converged when a sweep lowers the stress by less than this share of it.
    control
        Cancels, and ends at its deadline.

    Returns
    -------
    GmdsSolution

    Raises
    ------
    Cancelled
        Through `control`.
    """
    run = _Descent(terms, initial)
    control = control or Control()
    before = run.stress()
    for _ in range(leaps):
        if not run.sweep(run.leap, control):
            break
    history: list[float] = []
    status, last = Status.ITERATIONS, before if not leaps else run.stress()
    while len(history) < iterations:
        complete = run.sweep(run.step, control)
        history.append(run.stress())
        if not complete:
            status = Status.DEADLINE
            break
        if last - history[-1] <= tolerance * last:
            status = Status.CONVERGED
            break
        last = history[-1]
    points = SurfacePoints(run.faces, run.barycentric)
    return GmdsSolution(points, history[-1] if history else last, before, tuple(history), status)


class _Descent:
    """Points on their way, with the squared distances from each to all vertices.

    These take 4 TNV bytes, 640 MB for two metrics and 400 points of a mesh of 200,000 vertices.
    """

    def __init__(self, terms: Sequence[Term], initial: SurfacePoints) -> None:
        count = len(initial)
        for term in terms:
            if term.source.shape != (count, count) or term.weights.shape != (count, count):
                raise ValueError(f"{count} points need ({count}, {count}) distances and weights")
        self.targets = [term.target for term in terms]
        surface = self.targets[0].surface
        weights = np.stack([term.weights for term in terms])
        weights[:, np.arange(count), np.arange(count)] = 0.0
        self.faces, self.barycentric = initial.faces.copy(), initial.barycentric.copy()
        self.fields = Fields(
            self.targets[0].charts,
            np.stack([target.edges for target in self.targets]),
            np.empty((len(terms), count, surface.n_vertices), dtype=np.float32),
            np.stack([term.source for term in terms]),
            weights,
        )
        for i in range(count):
            self.fields.squares[:, i] = self._squares(int(self.faces[i]), self.barycentric[i])
        self.longest = _LONGEST_STEP * float(np.sqrt(surface.area))
        stride = -(-surface.n_vertices // _MOST_PLACES)
        self.places: IntArray = np.arange(0, surface.n_vertices, stride)

    def stress(self) -> float:
        """(7) of the points where they are."""
        return 0.5 * float(sum(self._share_here(i) for i in range(len(self.faces))))

    def sweep(self, move: Callable[[int], None], control: Control) -> bool:
        """Move every point once; return whether there was time for all of them."""
        for i in range(len(self.faces)):
            control.check()
            if control.seconds_left() <= 0.0:
                return False
            move(i)
        return True

    def step(self, i: int) -> None:
        """Move a point downhill."""
        here = int(self.faces[i]), self.barycentric[i]
        face, u = descent_step(self.fields, i, *here, self.longest)
        self._take(i, int(face), u)

    def leap(self, i: int) -> None:
        """Move a point to the vertex at which the stress is least, if it is less than here."""
        costs = costs_of_vertices(self.fields, self.places, i)
        vertex = int(self.places[np.argmin(costs)])
        charts = self.fields.charts
        face = int(charts.incident[charts.first[vertex]])
        self._take(i, face, (charts.faces[face] == vertex).astype(np.float64))

    def _take(self, i: int, face: int, u: FloatArray) -> None:
        """Move a point to a place, unless the stress, by both directions' distances, rises."""
        if face == self.faces[i] and (u == self.barycentric[i]).all():
            return
        squares = self._squares(face, u)
        if self._share(i, squares, face, u) < self._share_here(i):
            self.faces[i], self.barycentric[i] = face, u
            self.fields.squares[:, i] = squares

    def _squares(self, face: int, u: FloatArray) -> SingleArray:
        """(T, V) squared distances from a place to all vertices."""
        return np.stack(
            [target.squares_from(face, u).astype(np.float32) for target in self.targets]
        )

    def _share_here(self, i: int) -> float:
        here = int(self.faces[i]), self.barycentric[i]
        return self._share(i, np.ascontiguousarray(self.fields.squares[:, i]), *here)

    def _share(self, i: int, squares: SingleArray, face: int, u: FloatArray) -> float:
        return share(self.fields, self.faces, self.barycentric, i, squares, face, u)
