"""The stress (7): how far the distances among points of Y are from those among points of X."""

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.gmds.movement import walk
from solver.gmds.surface import Charts
from solver.kernel import kernel

_LEAST_DISTANCE = 1e-12
"""Below it, the direction in which a distance grows is unknown."""

_HALVINGS = 8
_DAMPING = 1e-3
"""Share of the Gauss-Newton matrix's trace that is added to its diagonal."""


def stress(source: FloatArray, target: FloatArray, weights: FloatArray) -> float:
    """Weighted stress (7): the sum of w_ij (d_X(x_i, x_j) − d_Y(y_i, y_j))² over i > j.

    Parameters
    ----------
    source, target
        (N, N) d_X and d_Y, symmetric.
    weights
        (N, N) w, symmetric.
    """
    return 0.5 * float((weights * (source - target) ** 2).sum())


@kernel
def interpolated(field: FloatArray, corners: IntArray, edges: FloatArray, u: FloatArray) -> float:
    """Squared distance to a point from (V,) those to vertices; see ``InterpolatedMetric``."""
    square = u[0] * field[corners[0]] + u[1] * field[corners[1]] + u[2] * field[corners[2]]
    square -= u[1] * u[2] * edges[0] + u[2] * u[0] * edges[1] + u[0] * u[1] * edges[2]
    positive: float = max(square, 0.0)
    return positive


@kernel
def share(
    fields: FloatArray,
    field: FloatArray,
    charts: Charts,
    edges: FloatArray,
    faces: IntArray,
    barycentric: FloatArray,
    i: int,
    face: int,
    u: FloatArray,
    source: FloatArray,
    weights: FloatArray,
) -> float:
    """Stress of the distances of one point from all others, if it lay at a given place.

    Parameters
    ----------
    fields
        (N, V) squared distances from every point to all vertices.
    field
        (V,) the same from the place.
    charts, edges
        Of the surface; edges squared in the metric.
    faces, barycentric
        (N,), (N, 3) where the points are.
    i
        The point.
    face, u
        The place.
    source, weights
        (N,) distances d_X of point i, and their weights.
    """
    total = 0.0
    for j in range(len(faces)):
        if j == i or weights[j] == 0.0:
            continue
        other = faces[j]
        there = interpolated(field, charts.faces[other], edges[other], barycentric[j])
        here = interpolated(fields[j], charts.faces[face], edges[face], u)
        total += weights[j] * (np.sqrt(0.5 * (here + there)) - source[j]) ** 2
    return total


@kernel
def descent_model(
    fields: FloatArray,
    charts: Charts,
    edges: FloatArray,
    i: int,
    face: int,
    u: FloatArray,
    source: FloatArray,
    weights: FloatArray,
) -> tuple[float, float, float, float, float, float]:
    """One-sided share of the stress at a place, its gradient, and its Gauss-Newton matrix.

    The latter two are in the plane of the triangle: x, y, xx, xy, yy. Distances are
    interpolated at the place only, from the other points' fields: with a symmetric metric, this
    is the share itself.
    """
    base, along, height = charts.corners[face]
    e = edges[face]
    a, b, c = charts.faces[face]
    value = gx = gy = hxx = hxy = hyy = 0.0
    for j in range(len(fields)):
        if j == i or weights[j] == 0.0:
            continue
        field = fields[j]
        distance = np.sqrt(interpolated(field, charts.faces[face], e, u))
        residual = distance - source[j]
        value += weights[j] * residual * residual
        scale = 0.5 / max(distance, _LEAST_DISTANCE)
        # Derivatives of d² by the barycentric coordinates, and from them along the plane's axes.
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
    fields: FloatArray,
    charts: Charts,
    edges: FloatArray,
    i: int,
    face: int,
    u: FloatArray,
    source: FloatArray,
    weights: FloatArray,
    longest: float,
) -> tuple[float, int, FloatArray]:
    """Move one point straight downhill, all others fixed.

    The step is that of Gauss and Newton, damped, at most `longest`, and halved until the stress
    falls. A point on an edge or a vertex tries every triangle there, and takes the best.

    Returns
    -------
    value, face, u
        One-sided share of the stress and place after the step; where it began if no step helps.
    """
    best = descent_model(fields, charts, edges, i, face, u, source, weights)[0]
    best_face, best_u = face, u
    pivot = charts.faces[face, np.argmax(u)]
    for at in range(charts.first[pivot], charts.first[pivot + 1]):
        start = charts.incident[at]
        place, present = _seen_from(charts, face, u, start)
        if not present:
            continue
        _, gx, gy, hxx, hxy, hyy = descent_model(
            fields, charts, edges, i, start, place, source, weights
        )
        damping = _DAMPING * (hxx + hyy)
        hxx, hyy = hxx + damping, hyy + damping
        determinant = hxx * hyy - hxy * hxy
        if not determinant > 0.0:
            continue
        x = -(hyy * gx - hxy * gy) / determinant
        y = -(hxx * gy - hxy * gx) / determinant
        length = np.hypot(x, y)
        pace = 1.0 if length <= longest else longest / length
        for _ in range(_HALVINGS):
            end, end_u = walk(charts, start, place, pace * x, pace * y)
            reached = descent_model(fields, charts, edges, i, end, end_u, source, weights)[0]
            if reached < best:
                best, best_face, best_u = reached, end, end_u
                break
            pace *= 0.5
    return best, best_face, best_u


@kernel
def _seen_from(charts: Charts, face: int, u: FloatArray, other: int) -> tuple[FloatArray, bool]:
    """Barycentric coordinates of a point in another triangle, and whether it lies there at all."""
    place = np.zeros(3)
    found = 0.0
    for corner in range(3):
        for own in range(3):
            if charts.faces[other, corner] == charts.faces[face, own]:
                place[corner] = u[own]
                found += u[own]
    return place, found >= 1.0 - 1e-12


@kernel
def costs_of_vertices(
    fields: FloatArray, places: IntArray, i: int, source: FloatArray, weights: FloatArray
) -> FloatArray:
    """(P,) one-sided share of the stress of point i at each of (P,) vertices; i may be no point."""
    costs = np.zeros(len(places))
    for j in range(len(fields)):
        if j == i or weights[j] == 0.0:
            continue
        for p in range(len(places)):
            costs[p] += weights[j] * (np.sqrt(fields[j, places[p]]) - source[j]) ** 2
    return costs
