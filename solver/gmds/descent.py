"""Equation (7): minimisation of the stress by coordinate descent, point by point."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from solver.arrays import FloatArray
from solver.control import Control, iterate
from solver.gmds.interpolation import InterpolatedMetric
from solver.gmds.stress import Fields, SingleArray, descent_step, share, stress
from solver.gmds.surface import SurfacePoints
from solver.labelling import Method, Solution

_LONGEST_STEP = 0.1
"""Longest step of a point, in units of √area."""


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
        (N, N) w of (7), symmetric, not negative; the diagonal is ignored.
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
    iterations: int = 100,
    tolerance: float = 1e-4,
    control: Control | None = None,
) -> Solution[SurfacePoints]:
    """Minimise the stress (7) over points of a surface, section 6.2.

    Points move one after the other, each by a Gauss-Newton step in its triangle's plane that goes
    on straight over edges, where that lowers the stress; the stress never rises. The result is a
    local minimum, which depends on the initial points.

    Parameters
    ----------
    terms
        The stress, or several in different metrics on the same surface, which add up.
    initial
        N points of Y to begin with.
    iterations
        Limit on the sweeps over all points, each of which takes O(N²) time and 2 N distance
        fields.
    tolerance
        The descent has converged when a sweep lowers the stress by less than this share of it.
    control
        Cancels, and ends at its deadline.

    Returns
    -------
    Solution
        N points and their stress, weighted. Its history is the stress of the initial points, then
        that after each sweep of the descent; it never increases. The lower bound is 0.

    Raises
    ------
    Cancelled
        Through `control`.
    """
    control = control or Control()
    points = _MovingPoints(terms, initial)
    ended = iterate(_Sweeps(points, tolerance, control), iterations, control)
    return Solution(
        SurfacePoints(points.faces, points.barycentric),
        ended.state.stresses[-1],
        0.0,
        ended.iterations,
        Method.GMDS,
        ended.status,
        ended.state.stresses,
    )


@dataclass(frozen=True)
class _Course:
    """Stress before and after each sweep, and whether the last sweep moved all points."""

    stresses: tuple[float, ...]
    complete: bool = True


class _Sweeps:
    """Moves of all points in turn, as an iterative method; points are moved in place."""

    def __init__(self, points: "_MovingPoints", tolerance: float, control: Control) -> None:
        self._points, self._tolerance, self._control = points, tolerance, control

    def init(self) -> _Course:
        """Return the stress of the points where they are."""
        return _Course((self._points.stress(),))

    def step(self, state: _Course) -> _Course:
        """Move every point once, or as many as the deadline allows."""
        count, moved = len(self._points.faces), 0
        for i in self._control.in_time(range(count)):
            self._points.descend(i)
            moved += 1
        return _Course((*state.stresses, self._points.stress()), moved == count)

    def done(self, state: _Course) -> bool:
        """Return whether the last sweep lowered the stress by no more than the tolerance."""
        if len(state.stresses) < 2 or not state.complete:
            return False
        before, after = state.stresses[-2:]
        return before - after <= self._tolerance * before


class _MovingPoints:
    """Moving points, with the squared distances from each to all vertices.

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

    def stress(self) -> float:
        """(7) of the points where they are."""
        return 0.5 * float(sum(self._share_here(i) for i in range(len(self.faces))))

    def descend(self, i: int) -> None:
        """Move a point by a Gauss-Newton step."""
        here = int(self.faces[i]), self.barycentric[i]
        face, u = descent_step(self.fields, i, *here, self.longest)
        self._take(i, int(face), u)

    def _take(self, i: int, face: int, u: FloatArray) -> None:
        """Move a point if that lowers the stress by the shorter of both directions' distances."""
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
