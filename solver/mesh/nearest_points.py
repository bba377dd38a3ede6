"""Nearest points of a surface in an embedding, by descent over its vertices and in its triangles.

An exhaustive search among all vertices takes quadratic time. Where an image is known nearly,
descent from neighbour to neighbour finds the nearest vertex in time proportional to their number.
"""

import numpy as np

from solver.arrays import FloatArray, IntArray, RealArray
from solver.kernel import inlined, kernel


@kernel
def descend(
    queries: RealArray, points: RealArray, first: IntArray, neighbours: IntArray, start: IntArray
) -> IntArray:
    """Descend from vertex to neighbouring vertex while that is nearer to the query.

    Parameters
    ----------
    queries, points
        (S, d) and (V, d) embedded queries and vertices.
    first, neighbours
        Neighbours of vertex v are ``neighbours[first[v]:first[v + 1]]``.
    start
        (S,) vertices to begin at.

    Returns
    -------
    (S,) vertices that are nearer to their query than all their neighbours, or as near.
    """
    found = np.empty(len(queries), dtype=np.int64)
    for place in range(len(queries)):
        found[place] = nearby_vertex(queries[place], points, first, neighbours, start[place])
    return found


@kernel
def nearby_vertex(
    query: RealArray, points: RealArray, first: IntArray, neighbours: IntArray, start: int
) -> int:
    """Descend as :func:`descend` does, for one query.

    Parameters
    ----------
    query
        (d,).
    points, first, neighbours
        As for :func:`descend`.
    start
        The vertex to begin at.

    Returns
    -------
    A vertex that is nearer to the query than all its neighbours, or as near.
    """
    here, least = start, 0.0
    for d in range(len(query)):
        offset = query[d] - points[here, d]
        least += offset * offset
    moved = True
    while moved:
        moved = False
        nearest = here
        for entry in range(first[here], first[here + 1]):
            other = neighbours[entry]
            square = 0.0
            for d in range(len(query)):
                offset = query[d] - points[other, d]
                square += offset * offset
                if square >= least:
                    break
            if square < least:
                least, nearest, moved = square, other, True
        here = nearest
    return here


@kernel
def project(
    queries: RealArray,
    points: RealArray,
    triangles: IntArray,
    first: IntArray,
    incident: IntArray,
    vertices: IntArray,
) -> tuple[IntArray, FloatArray]:
    """Project queries to the nearest embedded triangle round a vertex.

    Parameters
    ----------
    queries, points
        As for :func:`descend`.
    triangles
        (F, 3) vertices of the triangles.
    first, incident
        Triangles round vertex v are ``incident[first[v]:first[v + 1]]``; there is at least one.
    vertices
        (S,) vertex of each query.

    Returns
    -------
    (S,) triangles and (S, 3) barycentric coordinates, none negative, with sum 1.
    """
    chosen = np.empty(len(queries), dtype=np.int64)
    weights = np.empty((len(queries), 3))
    for place in range(len(queries)):
        chosen[place], weights[place] = nearest_in_fan(
            queries[place], points, triangles, first, incident, vertices[place]
        )
    return chosen, weights


@kernel
def nearest_in_fan(
    query: RealArray,
    points: RealArray,
    triangles: IntArray,
    first: IntArray,
    incident: IntArray,
    vertex: int,
) -> tuple[int, tuple[float, float, float]]:
    """Project a query to the nearest embedded triangle round a vertex.

    Parameters
    ----------
    query
        (d,).
    points, triangles, first, incident
        As for :func:`project`.
    vertex
        The vertex.

    Returns
    -------
    The triangle, and the barycentric coordinates, none negative, with sum 1.
    """
    best, chosen, weights = np.inf, -1, (0.0, 0.0, 0.0)
    for entry in range(first[vertex], first[vertex + 1]):
        face = incident[entry]
        own = 0
        if triangles[face, 1] == vertex:
            own = 1
        elif triangles[face, 2] == vertex:
            own = 2
        a, b = triangles[face, (own + 1) % 3], triangles[face, (own + 2) % 3]
        square, s, t = nearest_in_triangle(query, points, vertex, a, b)
        if square < best:
            best, chosen = square, face
            rest = max(1.0 - s - t, 0.0)
            if own == 0:
                weights = (rest, s, t)
            elif own == 1:
                weights = (t, rest, s)
            else:
                weights = (s, t, rest)
    return chosen, weights


@inlined
def nearest_in_triangle(
    query: RealArray | tuple[float, float, float], points: RealArray, a: int, b: int, c: int
) -> tuple[float, float, float]:
    """Return the squared distance of a (d,) query from a triangle of (n, d) points, and (s, t).

    The nearest point is (1 − s − t) a + s b + t c.
    """
    uu, uv, vv, ud, vd, dd = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for d in range(len(query)):
        u = points[b, d] - points[a, d]
        v = points[c, d] - points[a, d]
        w = query[d] - points[a, d]
        uu += u * u
        uv += u * v
        vv += v * v
        ud += u * w
        vd += v * w
        dd += w * w
    s, t = _nearest_coordinates(uu, uv, vv, ud, vd)
    return dd - 2.0 * (s * ud + t * vd) + s * s * uu + 2.0 * s * t * uv + t * t * vv, s, t


@kernel
def _nearest_coordinates(
    uu: float, uv: float, vv: float, ud: float, vd: float
) -> tuple[float, float]:
    """Return (s, t) ≥ 0 with s + t ≤ 1 that minimise ‖d − s u − t v‖, from inner products."""
    determinant = uu * vv - uv * uv
    if determinant > 1e-12 * uu * vv:
        s = (vv * ud - uv * vd) / determinant
        t = (uu * vd - uv * ud) / determinant
        if s >= 0.0 and t >= 0.0 and s + t <= 1.0:
            return s, t
    # On one of the three edges: of these the nearest.
    s = min(max(ud / uu, 0.0), 1.0) if uu > 0.0 else 0.0
    best, found = s * s * uu - 2.0 * s * ud, (s, 0.0)
    t = min(max(vd / vv, 0.0), 1.0) if vv > 0.0 else 0.0
    square = t * t * vv - 2.0 * t * vd
    if square < best:
        best, found = square, (0.0, t)
    edge = uu - 2.0 * uv + vv
    along = min(max((vd - ud + uu - uv) / edge, 0.0), 1.0) if edge > 0.0 else 0.0
    s, t = 1.0 - along, along
    square = s * s * uu + 2.0 * s * t * uv + t * t * vv - 2.0 * (s * ud + t * vd)
    if square < best:
        found = (s, t)
    return found
