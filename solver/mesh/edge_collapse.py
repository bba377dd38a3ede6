"""Edge collapse in order of cost, which keeps the topology.

A vertex u is collapsed into its neighbour v only if no face flips and the topology stays: the only
common neighbours of u and v are the third corners of the faces at the edge, and of a face at the
boundary one of the other two sides is not (link condition: Dey, Edelsbrunner, Guha and Nekhayev,
Publ. Inst. Math. 66, 1999). A face that hangs at single vertices may be what connects them.

No library does this with vertices that stay: fast-simplification 0.2 and pyfqmr 0.5 move them,
meshoptimizer 0.2 keeps them but does not say into which one a vertex was collapsed, and none stops
at a number of vertices.
"""

import heapq

import numpy as np

from solver.arrays import BoolArray, FloatArray, IntArray
from solver.kernel import kernel

_LEAST_COSINE = 0.3
"""Cosine of the largest angle by which a collapse may turn a face's normal."""

_LEAST_SHAPE = 0.1
"""Least height over the longest side that a collapse may leave of a face, 1 for an equilateral."""

_EQUILATERAL = 2.0 / 3.0**0.5
"""Longest side squared over twice the area of an equilateral triangle."""

_MOST_FACES = 24
"""Faces at a vertex that a collapse may produce; vertices of more are not collapsed."""


@kernel
def collapse_edges(
    positions: FloatArray,
    faces: IntArray,
    quadrics: FloatArray,
    boundary: BoolArray,
    fixed: BoolArray,
    into: IntArray,
    target: int,
) -> None:
    """Collapse edges until `target` vertices are left, or none can be collapsed.

    Parameters
    ----------
    positions
        (V, 3).
    faces
        (F, 3) int64; changed: faces that vanish become (-1, -1, -1).
    quadrics
        (V, 4, 4) symmetric; collapsing u into v costs x̃ᵀ Q_u x̃ at v, less that at u. Changed to
        the sums over collapsed vertices.
    boundary
        (V,) boundary vertices, which are only collapsed into each other.
    fixed
        (V,) vertices that are not collapsed.
    into
        (V,) each vertex's own index; changed to that of the vertex it was collapsed into.
    target
        Number of vertices to leave.
    """
    n = len(positions)
    first, links, valence = _corners(faces, n)
    version = np.zeros(n, np.int64)
    # Lower bound of the cost, vertex, version of its neighbourhood.
    queue = [
        (_least_cost(u, positions, faces, quadrics, fixed, first, links, valence), u, 0)
        for u in range(n)
    ]
    heapq.heapify(queue)
    ring = np.empty(2 * _MOST_FACES + 2, np.int64)
    left = n
    while left > target and len(queue) > 0:
        least, u, stamp = heapq.heappop(queue)
        if stamp != version[u] or into[u] != u or least == np.inf:
            continue
        # Only now are the conditions checked.
        cost, v = _best(u, positions, faces, quadrics, boundary, first, links, valence)
        if cost > least:
            if v >= 0:
                heapq.heappush(queue, (cost, u, stamp))
            continue
        _move_corners(u, v, faces, first, links, valence)
        into[u] = v
        quadrics[v] += quadrics[u]
        left -= 1
        ring[0] = v
        count = 1 + _neighbours(v, faces, first, links, ring[1:])
        for w in ring[:count]:
            version[w] += 1
            cost = _least_cost(w, positions, faces, quadrics, fixed, first, links, valence)
            heapq.heappush(queue, (cost, w, version[w]))
    for u in range(n):
        while into[into[u]] != into[u]:
            into[u] = into[into[u]]


@kernel
def _corners(faces: IntArray, n_vertices: int) -> tuple[IntArray, IntArray, IntArray]:
    """Doubly linked lists of the corners (3 · face + 0..2) at each vertex: first, links, length."""
    first = np.full(n_vertices, -1)
    links = np.full((3 * len(faces), 2), -1)
    valence = np.zeros(n_vertices, np.int64)
    for corner in range(3 * len(faces)):
        _put_in(faces[corner // 3, corner % 3], corner, first, links, valence)
    return first, links, valence


@kernel
def _least_cost(
    u: int,
    positions: FloatArray,
    faces: IntArray,
    quadrics: FloatArray,
    fixed: BoolArray,
    first: IntArray,
    links: IntArray,
    valence: IntArray,
) -> float:
    """Least cost of collapsing u into a neighbour, conditions aside; ∞ if u is not collapsed."""
    if fixed[u] or valence[u] > _MOST_FACES:
        return np.inf
    ring = np.empty(2 * _MOST_FACES + 2, np.int64)
    here = _error(quadrics[u], positions[u])
    least = np.inf
    for v in ring[: _neighbours(u, faces, first, links, ring)]:
        least = min(least, _error(quadrics[u], positions[v]) - here)
    return least


@kernel
def _best(
    u: int,
    positions: FloatArray,
    faces: IntArray,
    quadrics: FloatArray,
    boundary: BoolArray,
    first: IntArray,
    links: IntArray,
    valence: IntArray,
) -> tuple[float, int]:
    """Least cost of collapsing u into a neighbour under the conditions, and that one; -1: none."""
    ring = np.empty(2 * _MOST_FACES + 2, np.int64)
    ring = ring[: _neighbours(u, faces, first, links, ring)]
    here = _error(quadrics[u], positions[u])
    least, best = np.inf, -1
    for i in range(len(ring)):
        v = int(ring[i])
        cost = _error(quadrics[u], positions[v]) - here
        if (
            cost < least
            and _keeps_topology(u, v, ring, faces, boundary, first, links, valence)
            and _keeps_shape(u, v, positions, faces, first, links)
        ):
            least, best = cost, v
    return least, best


@kernel
def _error(quadric: FloatArray, place: FloatArray) -> float:
    x, y, z, q = place[0], place[1], place[2], quadric
    error: float = (
        x * (q[0, 0] * x + 2.0 * (q[0, 1] * y + q[0, 2] * z + q[0, 3]))
        + y * (q[1, 1] * y + 2.0 * (q[1, 2] * z + q[1, 3]))
        + z * (q[2, 2] * z + 2.0 * q[2, 3])
        + q[3, 3]
    )
    return error


@kernel
def _keeps_topology(
    u: int,
    v: int,
    ring: IntArray,
    faces: IntArray,
    boundary: BoolArray,
    first: IntArray,
    links: IntArray,
    valence: IntArray,
) -> bool:
    """Link condition: common neighbours of u and v are only the third corners of their faces."""
    shared = _faces_with(u, v, faces, first, links)
    if shared != (1 if boundary[u] else 2) or (boundary[u] and not boundary[v]):
        return False
    # Around a vertex within the surface there are three faces at least.
    if not (1 if boundary[v] else 3) <= valence[u] + valence[v] - 2 * shared <= _MOST_FACES:
        return False
    common = 0
    for w in ring:
        if w != v:
            a, b = (w, v) if valence[w] < valence[v] else (v, w)
            faces_at_side = _faces_with(a, b, faces, first, links)
            if faces_at_side > 0:
                common += 1
            if shared == 1 and faces_at_side == 1 and _faces_with(u, w, faces, first, links) == 1:
                return False
    return common == shared


@kernel
def _keeps_shape(
    u: int, v: int, positions: FloatArray, faces: IntArray, first: IntArray, links: IntArray
) -> bool:
    """Return whether u can move to v so that no face flips or becomes a sliver."""
    corner = first[u]
    while corner >= 0:
        f, k = corner // 3, corner % 3
        corner = links[corner, 0]
        p, q = faces[f, (k + 1) % 3], faces[f, (k + 2) % 3]
        if p == v or q == v:
            continue
        before, shape = _normal(positions[u], positions[p], positions[q])
        after, new_shape = _normal(positions[v], positions[p], positions[q])
        cosine = before[0] * after[0] + before[1] * after[1] + before[2] * after[2]
        if cosine < _LEAST_COSINE or new_shape < min(_LEAST_SHAPE, shape):
            return False
    return True


@kernel
def _normal(
    a: FloatArray, b: FloatArray, c: FloatArray
) -> tuple[tuple[float, float, float], float]:
    """Unit normal of a triangle, and its shape, 1 for an equilateral one."""
    ux, uy, uz = b[0] - a[0], b[1] - a[1], b[2] - a[2]
    vx, vy, vz = c[0] - a[0], c[1] - a[1], c[2] - a[2]
    x, y, z = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    length = np.sqrt(x * x + y * y + z * z)
    third = (ux - vx) ** 2 + (uy - vy) ** 2 + (uz - vz) ** 2
    longest = max(ux * ux + uy * uy + uz * uz, vx * vx + vy * vy + vz * vz, third)
    if length == 0.0 or longest == 0.0:
        return (0.0, 0.0, 0.0), 0.0
    return (x / length, y / length, z / length), _EQUILATERAL * length / longest


@kernel
def _neighbours(v: int, faces: IntArray, first: IntArray, links: IntArray, ring: IntArray) -> int:
    """Write the neighbours of v, each once, and return their number."""
    count = 0
    corner = first[v]
    while corner >= 0:
        f, k = corner // 3, corner % 3
        for step in range(1, 3):
            w = faces[f, (k + step) % 3]
            known = False
            for i in range(count):
                known = known or ring[i] == w
            if not known:
                ring[count] = w
                count += 1
        corner = links[corner, 0]
    return count


@kernel
def _faces_with(u: int, v: int, faces: IntArray, first: IntArray, links: IntArray) -> int:
    count = 0
    corner = first[u]
    while corner >= 0:
        f = corner // 3
        if faces[f, 0] == v or faces[f, 1] == v or faces[f, 2] == v:
            count += 1
        corner = links[corner, 0]
    return count


@kernel
def _move_corners(
    u: int, v: int, faces: IntArray, first: IntArray, links: IntArray, valence: IntArray
) -> None:
    """Move the faces at u to v; faces at both vanish."""
    corner = first[u]
    while corner >= 0:
        f, after = corner // 3, links[corner, 0]
        if faces[f, 0] == v or faces[f, 1] == v or faces[f, 2] == v:
            for k in range(3):
                if faces[f, k] != u:
                    _take_out(faces[f, k], 3 * f + k, first, links, valence)
                faces[f, k] = -1
        else:
            faces[f, corner % 3] = v
            _put_in(v, corner, first, links, valence)
        corner = after
    first[u] = -1
    valence[u] = 0


@kernel
def _put_in(v: int, corner: int, first: IntArray, links: IntArray, valence: IntArray) -> None:
    """Put a corner into the list of a vertex."""
    links[corner, 0], links[corner, 1] = first[v], -1
    if first[v] >= 0:
        links[first[v], 1] = corner
    first[v] = corner
    valence[v] += 1


@kernel
def _take_out(v: int, corner: int, first: IntArray, links: IntArray, valence: IntArray) -> None:
    """Take a corner out of the list of its vertex."""
    after, before = links[corner, 0], links[corner, 1]
    if before < 0:
        first[v] = after
    else:
        links[before, 0] = after
    if after >= 0:
        links[after, 1] = before
    valence[v] -= 1
