"""Generalized multidimensional scaling: minimise the stress (7), point by point."""

from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.control import Control
from solver.gmds.interpolation import InterpolatedMetric
from solver.gmds.stress import costs_of_vertices, descent_step, share
from solver.gmds.surface import SurfacePoints

_LONGEST_STEP = 0.1
"""Of √area."""

_MOST_PLACES = 5000
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


def gmds(
    source_distances: FloatArray,
    target: InterpolatedMetric,
    initial: SurfacePoints,
    *,
    weights: FloatArray | None = None,
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
    source_distances
        (N, N) d_X, symmetric.
    target
        d_Y.
    initial
        N points of Y to begin with.
    weights
        (N, N) w of (7), symmetric, not negative; all 1 by default.
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
    run = _Descent(source_distances, target, initial, weights)
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
    """Points on their way, with the squared distances from each to all vertices: 8 NV bytes."""

    def __init__(
        self,
        source_distances: FloatArray,
        target: InterpolatedMetric,
        initial: SurfacePoints,
        weights: FloatArray | None,
    ) -> None:
        count = len(initial)
        if source_distances.shape != (count, count):
            raise ValueError(f"{count} points need ({count}, {count}) distances")
        self.source = np.ascontiguousarray(source_distances)
        self.weights = np.ones((count, count)) if weights is None else weights.copy()
        np.fill_diagonal(self.weights, 0.0)
        self.target = target
        self.charts = target.charts
        self.faces, self.barycentric = initial.faces.copy(), initial.barycentric.copy()
        self.longest = _LONGEST_STEP * float(np.sqrt(target.surface.area))
        self.fields = np.empty((count, target.surface.n_vertices))
        for i in range(count):
            self.fields[i] = target.squares_from(int(self.faces[i]), self.barycentric[i])
        stride = -(-target.surface.n_vertices // _MOST_PLACES)
        self.places: IntArray = np.arange(0, target.surface.n_vertices, stride)

    def stress(self) -> float:
        """(7) of the points where they are."""
        shares = [
            self._share(i, self.fields[i], int(self.faces[i]), self.barycentric[i])
            for i in range(len(self.faces))
        ]
        return 0.5 * float(sum(shares))

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
        face, u = int(self.faces[i]), self.barycentric[i]
        _, new_face, new_u = descent_step(
            self.fields,
            self.charts,
            self.target.edges,
            i,
            face,
            u,
            self.source[i],
            self.weights[i],
            self.longest,
        )
        self._take(i, int(new_face), new_u)

    def leap(self, i: int) -> None:
        """Move a point to the vertex at which the stress is least, if it is less than here."""
        costs = costs_of_vertices(self.fields, self.places, i, self.source[i], self.weights[i])
        vertex = int(self.places[np.argmin(costs)])
        face = int(self.charts.incident[self.charts.first[vertex]])
        self._take(i, face, (self.charts.faces[face] == vertex).astype(np.float64))

    def _take(self, i: int, face: int, u: FloatArray) -> None:
        """Move a point to a place, unless the stress, by both directions' distances, rises."""
        if face == self.faces[i] and (u == self.barycentric[i]).all():
            return
        here = self._share(i, self.fields[i], int(self.faces[i]), self.barycentric[i])
        field = self.target.squares_from(face, u)
        if self._share(i, field, face, u) < here:
            self.faces[i], self.barycentric[i], self.fields[i] = face, u, field

    def _share(self, i: int, field: FloatArray, face: int, u: FloatArray) -> float:
        return share(
            self.fields,
            field,
            self.charts,
            self.target.edges,
            self.faces,
            self.barycentric,
            i,
            face,
            u,
            self.source[i],
            self.weights[i],
        )
