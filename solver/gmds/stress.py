"""Equation (7): stress of points on Y for the distances of points on X, and its derivatives."""

from typing import NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from solver.arrays import FloatArray, IntArray
from solver.gmds.movement import walk
from solver.gmds.surface import Charts
from solver.kernel import kernel

_LEAST_STEP = 1e-12
"""Least length that a step is compared with, in longest steps: a step may vanish."""

_HALVINGS = 8
"""Most halvings of a step that raises the stress."""
_DAMPING = 1e-3
"""Share of the trace of the Gauss-Newton matrix that is added to its diagonal."""


def stress(source: FloatArray, target: FloatArray, weights: FloatArray) -> float:
    """Equation (7): the sum of w_ij (d_X(x_i, x_j) − d_Y(y_i, y_j))² over i > j.

    Parameters
    ----------
    source, target
        (N, N) d_X and d_Y, symmetric.
    weights
        (N, N) w, symmetric.
    """
    return 0.5 * float((weights * (source - target) ** 2).sum())


SingleArray: TypeAlias = npt.NDArray[np.float32]
"""float32 array of squared distances: a relative precision of 6e-8 is enough for them."""


class Fields(NamedTuple):
    """Distance fields of N points, and the terms of the stress, in each of T metrics.

    Parameters
    ----------
    charts
        Of the surface.
    edges
        (T, F, 3) squared lengths of the triangles' edges.
    squares
        (T, N, V) squared distances from every point to all vertices.
    source, weights
        (T, N, N) d_X and w of (7), the latter zero on the diagonal.
    """

    charts: Charts
    edges: FloatArray
    squares: SingleArray
    source: FloatArray
    weights: FloatArray


@kernel
def interpolated(field: SingleArray, corners: IntArray, edges: FloatArray, u: FloatArray) -> float:
    """Squared distance to a point from (V,) those to vertices; see ``InterpolatedMetric``."""
    square = u[0] * field[corners[0]] + u[1] * field[corners[1]] + u[2] * field[corners[2]]
    square -= u[1] * u[2] * edges[0] + u[2] * u[0] * edges[1] + u[0] * u[1] * edges[2]
    positive: float = max(square, 0.0)
    return positive


@kernel
def share(
    fields: Fields,
    faces: IntArray,
    barycentric: FloatArray,
    i: int,
    own: SingleArray,
    face: int,
    u: FloatArray,
) -> float:
    """Stress of the distances between one point, at a given place, and all others.

    Parameters
    ----------
    fields
        Of all points at their present positions.
    faces, barycentric
        (N,), (N, 3) these positions.
    i
        The point.
    own
        (T, V) squared distances from the place to all vertices.
    face, u
        The place.
    """
    total = 0.0
    corners = fields.charts.faces
    for t in range(len(own)):
        edges, squares = fields.edges[t], fields.squares[t]
        source, weights = fields.source[t, i], fields.weights[t, i]
        for j in range(len(faces)):
            if weights[j] > 0.0:
                other = faces[j]
                there = interpolated(own[t], corners[other], edges[other], barycentric[j])
                here = interpolated(squares[j], corners[face], edges[face], u)
                total += weights[j] * (np.sqrt(min(here, there)) - source[j]) ** 2
    return total


@kernel
def descent_model(
    fields: Fields, i: int, face: int, u: FloatArray
) -> tuple[float, float, float, float, float, float]:
    """One-sided share of the stress at a place, its gradient, and its Gauss-Newton matrix.

    The latter two are in the plane of the triangle: x, y, xx, xy, yy. Distances are
    interpolated at the place only, from the other points' fields: with a symmetric metric, this
    is the share itself.
    """
    base, along, height = fields.charts.corners[face]
    corners = fields.charts.faces[face]
    a, b, c = corners
    value = gx = gy = hxx = hxy = hyy = 0.0
    for t in range(len(fields.squares)):
        e = fields.edges[t, face]
        source, weights = fields.source[t, i], fields.weights[t, i]
        for j in range(len(source)):
            if not weights[j] > 0.0:
                continue
            field = fields.squares[t, j]
            distance = np.sqrt(interpolated(field, corners, e, u))
            residual = distance - source[j]
            value += weights[j] * residual * residual
            # The distance of a point from another at the same place has no gradient.
            scale = 0.5 / distance if distance > 0.0 else 0.0
            # Derivatives of d² by the barycentric coordinates, then along the plane's axes.
            to_a = field[a] - u[1] * e[2] - u[2] * e[1]
            x = scale * (field[b] - u[0] * e[2] - u[2] * e[0] - to_a) / base
            y = scale * (field[c] - u[0] * e[1] - u[1] * e[0] - to_a)
            y = (y - x * along) / height
            gx += weights[j] * residual * x
            gy += weights[j] * residual * y
            hxx += weights[j] * x * x
            hxy += weights[j] * x * y
            hyy += weights[j] * y * y
    return value, 2.0 * gx, 2.0 * gy, 2.0 * hxx, 2.0 * hxy, 2.0 * hyy


@kernel
def descent_step(
    fields: Fields, i: int, face: int, u: FloatArray, longest: float
) -> tuple[int, FloatArray]:
    """Damped Gauss-Newton step of one point, all others fixed.

    The step is at most `longest`, and halved until the stress falls. For a point on an edge or a
    vertex, the best step of all its triangles is taken.

    Returns
    -------
    face, u
        New position; the old one if no step lowers the stress.
    """
    charts = fields.charts
    best = descent_model(fields, i, face, u)[0]
    best_face, best_u = face, u
    pivot = charts.faces[face, np.argmax(u)]
    for at in range(charts.first[pivot], charts.first[pivot + 1]):
        start = charts.incident[at]
        place, present = _located(charts, face, u, start)
        if not present:
            continue
        x, y = _newton_step(descent_model(fields, i, start, place), longest)
        for _ in range(_HALVINGS):
            end, end_u = walk(charts, start, place, x, y)
            reached = descent_model(fields, i, end, end_u)[0]
            if reached < best:
                best, best_face, best_u = reached, end, end_u
                break
            x, y = 0.5 * x, 0.5 * y
    return best_face, best_u


@kernel
def _newton_step(
    model: tuple[float, float, float, float, float, float], longest: float
) -> tuple[float, float]:
    """Damped Gauss-Newton step in the plane, at most `longest`; zero if there is none."""
    _, gx, gy, hxx, hxy, hyy = model
    damping = _DAMPING * (hxx + hyy)
    hxx, hyy = hxx + damping, hyy + damping
    determinant = hxx * hyy - hxy * hxy
    if not determinant > 0.0:
        return 0.0, 0.0
    x = -(hyy * gx - hxy * gy) / determinant
    y = -(hxx * gy - hxy * gx) / determinant
    shorter = min(1.0, longest / max(np.hypot(x, y), _LEAST_STEP * longest))
    return x * shorter, y * shorter


@kernel
def _located(charts: Charts, face: int, u: FloatArray, other: int) -> tuple[FloatArray, bool]:
    """Barycentric coordinates of a point in another triangle, and whether it lies in that."""
    place = np.zeros(3)
    found = 0.0
    for corner in range(3):
        for own in range(3):
            if charts.faces[other, corner] == charts.faces[face, own]:
                place[corner] = u[own]
                found += u[own]
    return place, found >= 1.0 - 1e-12
