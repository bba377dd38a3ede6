"""Relaxation of the folds of a mesh that lies on a surface, by moves of its vertices along it.

With the normals m of the surface, a triangle of the mesh with normal n (of the length of twice its
area) and squared edges of sum l has the quality q = 2√3 ⟨n, m⟩ / l: 1 if it is equilateral, 0 if it
is degenerate, negative if it is flipped. The sum of l/χ over the triangles round a vertex, where
χ = (d + √(d² + ε²a²)) / 2 for d = q l and the area a at rest, is finite for flipped triangles, too,
and as ε falls it becomes a barrier that no triangle crosses (Garanzha, Kaporin, Kudryavtseva,
Protais, Ray and Sokolov, "Foldover-free maps in 50 lines of code", ACM TOG 40(4), 2021). Vertices
round bad triangles move one by one, to the best of several points of the surface, so that the sum
never rises for a given ε.

A patch that has collapsed inside out is embedded anew: each vertex at the mean of its neighbours,
which in the plane, in a convex patch, flips no triangle (Tutte 1963, Floater 1997).
"""

from typing import NamedTuple

import numpy as np

from solver.arrays import BoolArray, FloatArray, IntArray
from solver.kernel import kernel
from solver.mesh import SurfaceTree, nearby_vertex, nearest_in_fan, nearest_triangles

_STEPS = 1.0, 0.5, 0.25
"""Steps of a vertex towards the mean of its neighbours."""

_RADII = 0.5, 0.15, 0.04
"""Radii of the circles that further points are tried on, over the mean length of its edges."""

_DIRECTIONS = 6
"""Points tried on each circle."""

_GOLDEN_ANGLE = np.pi * (3.0 - np.sqrt(5.0))
"""By which the circles of one vertex, or round, are turned against those of the next."""

_SCALE = 2.0 * np.sqrt(3.0)

_DECREASE = 1e-4
"""Least relative decrease of the sum for which a vertex moves."""


class Surface(NamedTuple):
    """A surface Y that a mesh lies on.

    Parameters
    ----------
    vertices, faces, normals
        (W, 3), (G, 3), and (W, 3) unit normals of the vertices.
    first, neighbours, first_face, incident
        As :attr:`.TriangleMesh.neighbours` and :attr:`.TriangleMesh.incident_faces` have them.
    tree
        Of its triangles.
    """

    vertices: FloatArray
    faces: IntArray
    normals: FloatArray
    first: IntArray
    neighbours: IntArray
    first_face: IntArray
    incident: IntArray
    tree: SurfaceTree


class Connectivity(NamedTuple):
    """Connectivity of the mesh that is relaxed.

    Parameters
    ----------
    faces
        (F, 3), wound as those of the surface.
    areas
        (V,) mean area at rest of the triangles round each vertex, on a surface of unit area.
    on_boundary
        (V,) whether a vertex lies on the boundary.
    first, neighbours, first_face, incident
        Neighbours over edges, not over links, and triangles round vertices.
    """

    faces: IntArray
    areas: FloatArray
    on_boundary: BoolArray
    first: IntArray
    neighbours: IntArray
    first_face: IntArray
    incident: IntArray


class Placement(NamedTuple):
    """Vertices of a mesh on a surface, changed in place.

    Parameters
    ----------
    positions, normals
        (V, 3) positions, and unit normals of the surface there, interpolated.
    nearest
        (V,) vertices of the surface near them.
    """

    positions: FloatArray
    normals: FloatArray
    nearest: IntArray

    def copied(self) -> "Placement":
        """Return a copy, which changes apart."""
        return Placement(self.positions.copy(), self.normals.copy(), self.nearest.copy())


@kernel
def placed(points: FloatArray, starts: IntArray, surface: Surface) -> Placement:
    """Return vertices at the points of the surface nearest to given ones.

    Parameters
    ----------
    points
        (V, 3) near the surface.
    starts
        (V,) vertices of the surface where descents begin.
    surface
        The surface.
    """
    placement = Placement(np.empty_like(points), np.empty_like(points), starts.copy())
    for vertex in range(len(points)):
        x, y, z = points[vertex]
        place(placement, vertex, x, y, z, starts[vertex], surface)
    return placement


@kernel
def place(
    placement: Placement, vertex: int, x: float, y: float, z: float, start: int, surface: Surface
) -> None:
    """Move a vertex to the point of the surface nearest to (x, y, z), by descent from `start`."""
    point, vertices = np.array([x, y, z]), surface.vertices
    here = nearby_vertex(point, vertices, surface.first, surface.neighbours, start)
    face, (one, two, three) = nearest_in_fan(
        point, vertices, surface.faces, surface.first_face, surface.incident, here
    )
    a, b, c = surface.faces[face]
    length = 0.0
    for d in range(3):
        placement.positions[vertex, d] = (
            one * vertices[a, d] + two * vertices[b, d] + three * vertices[c, d]
        )
        normal = (
            one * surface.normals[a, d]
            + two * surface.normals[b, d]
            + three * surface.normals[c, d]
        )
        placement.normals[vertex, d] = normal
        length += normal * normal
    for d in range(3):
        placement.normals[vertex, d] /= np.sqrt(length) + 1e-30
    placement.nearest[vertex] = here


@kernel
def qualities(
    placement: Placement, faces: IntArray, chosen: IntArray, surface: Surface, everywhere: bool
) -> FloatArray:
    """Qualities q of triangles.

    Parameters
    ----------
    placement, surface
        Of a mesh on its surface.
    faces, chosen
        (F, 3), and (n,) those of which the qualities are returned.
    everywhere
        Whether to compare with the surface's normal nearest to the centre, besides the mean of
        those at the corners.

    Returns
    -------
    (n, 2) qualities by the mean of the normals at the corners, and by the normal at the centre, if
    asked for, else 1.
    """
    found = np.ones((len(chosen), 2))
    for number in range(len(chosen)):
        corners = faces[chosen[number]]
        double_area, squares = _at_corners(placement, corners)
        found[number, 0] = double_area / squares
        if everywhere:
            found[number, 1] = _at_centre(placement, corners, surface) / squares
    return found


@kernel
def corner_qualities(placement: Placement, faces: IntArray) -> FloatArray:
    """(F,) qualities q of (F, 3) triangles, by the mean of the normals at the corners."""
    found = np.empty(len(faces))
    for face in range(len(faces)):
        double_area, squares = _at_corners(placement, faces[face])
        found[face] = double_area / squares
    return found


@kernel
def _at_corners(placement: Placement, corners: IntArray) -> tuple[float, float]:
    """Return d by the mean of the surface's normals at the corners, and l."""
    a, b, c = corners
    p, m = placement.positions, placement.normals
    ux, uy, uz = p[b, 0] - p[a, 0], p[b, 1] - p[a, 1], p[b, 2] - p[a, 2]
    vx, vy, vz = p[c, 0] - p[a, 0], p[c, 1] - p[a, 1], p[c, 2] - p[a, 2]
    nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    mx = m[a, 0] + m[b, 0] + m[c, 0]
    my = m[a, 1] + m[b, 1] + m[c, 1]
    mz = m[a, 2] + m[b, 2] + m[c, 2]
    mean = np.sqrt(mx * mx + my * my + mz * mz) + 1e-30
    squares = (ux - vx) ** 2 + (uy - vy) ** 2 + (uz - vz) ** 2
    squares += ux * ux + uy * uy + uz * uz + vx * vx + vy * vy + vz * vz
    return _SCALE * (nx * mx + ny * my + nz * mz) / mean, squares + 1e-30


@kernel
def _at_centre(placement: Placement, corners: IntArray, surface: Surface) -> float:
    """Return d by the surface's normal nearest to the centre: of several, by the worst."""
    a, b, c = corners
    p = placement.positions
    ux, uy, uz = p[b, 0] - p[a, 0], p[b, 1] - p[a, 1], p[b, 2] - p[a, 2]
    vx, vy, vz = p[c, 0] - p[a, 0], p[c, 1] - p[a, 1], p[c, 2] - p[a, 2]
    nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    sx, sy, sz = (ux + vx) / 3.0, (uy + vy) / 3.0, (uz + vz) / 3.0
    # The corners are on the surface, so that the centre is no farther from it than from the first.
    bound = sx * sx + sy * sy + sz * sz
    x, y, z = p[a, 0] + sx, p[a, 1] + sy, p[a, 2] + sz
    _, least, _, _ = nearest_triangles(x, y, z, nx, ny, nz, surface.tree, bound)
    return float(_SCALE * least)


@kernel
def _cost(
    placement: Placement,
    vertex: int,
    mesh: Connectivity,
    surface: Surface,
    everywhere: bool,
    epsilon: float,
    most: float,
) -> float:
    """Sum of l/χ round a vertex; of a sum that is more than `most`, a part."""
    cost, square = 0.0, (epsilon * mesh.areas[vertex]) ** 2
    around = mesh.incident[mesh.first_face[vertex] : mesh.first_face[vertex + 1]]
    for face in around:
        d, squares = _at_corners(placement, mesh.faces[face])
        cost += 2.0 * squares / max(d + np.sqrt(d * d + square), 1e-30)
    if not everywhere:
        return cost
    for face in around:
        # Centres are searched for only where the corners leave the sum small enough.
        if cost > most:
            return cost
        _, squares = _at_corners(placement, mesh.faces[face])
        d = _at_centre(placement, mesh.faces[face], surface)
        cost += 2.0 * squares / max(d + np.sqrt(d * d + square), 1e-30)
    return cost


@kernel
def relax(
    placement: Placement,
    vertices: IntArray,
    mesh: Connectivity,
    surface: Surface,
    everywhere: bool,
    epsilon: float,
    turn: float,
) -> BoolArray:
    """Move each vertex to the best of several points of the surface, if that lowers the cost.

    Tried are steps towards the mean of its neighbours, this mean as sought from each neighbour,
    which may lie on another sheet of the surface, and points on circles in the tangent plane.

    Parameters
    ----------
    placement
        Changed.
    vertices
        (n,) vertices that may move, in this order.
    mesh, surface
        The mesh, and what it lies on.
    everywhere
        As for :func:`qualities`.
    epsilon
        ε.
    turn
        Angle by which the circles are turned.

    Returns
    -------
    (n,) whether each vertex has moved.
    """
    moved = np.zeros(len(vertices), dtype=np.bool_)
    positions, normals, nearest = placement
    for entry in range(len(vertices)):
        vertex = vertices[entry]
        old, normal, start = positions[vertex].copy(), normals[vertex].copy(), nearest[vertex]
        cost = _cost(placement, vertex, mesh, surface, everywhere, epsilon, np.inf)
        best, chosen = cost * (1.0 - _DECREASE), -1
        points, starts = _tried(placement, vertex, mesh, turn + vertex * _GOLDEN_ANGLE)
        for number in range(len(points)):
            x, y, z = points[number]
            place(placement, vertex, x, y, z, starts[number], surface)
            cost = _cost(placement, vertex, mesh, surface, everywhere, epsilon, best)
            if cost < best:
                best, chosen = cost, number
        positions[vertex], normals[vertex], nearest[vertex] = old, normal, start
        if chosen >= 0:
            x, y, z = points[chosen]
            place(placement, vertex, x, y, z, starts[chosen], surface)
            moved[entry] = True
    return moved


@kernel
def _tried(
    placement: Placement, vertex: int, mesh: Connectivity, turn: float
) -> tuple[FloatArray, IntArray]:
    """(n, 3) points that a vertex may move to, and (n,) where their descents begin."""
    here, normal = placement.positions[vertex], placement.normals[vertex]
    ring = mesh.neighbours[mesh.first[vertex] : mesh.first[vertex + 1]]
    mean, length = np.zeros(3), 0.0
    for other in ring:
        mean += placement.positions[other]
        length += np.sqrt(((placement.positions[other] - here) ** 2).sum())
    mean /= len(ring)
    length /= len(ring)
    count = len(_STEPS) + len(ring) + len(_RADII) * _DIRECTIONS
    points, starts = np.empty((count, 3)), np.full(count, placement.nearest[vertex])
    number = 0
    for step in _STEPS:
        points[number] = here + step * (mean - here)
        number += 1
    for other in ring:
        points[number], starts[number] = mean, placement.nearest[other]
        number += 1
    axis = np.zeros(3)
    axis[np.argmin(np.abs(normal))] = 1.0
    one = np.cross(normal, axis)
    one /= np.sqrt((one * one).sum()) + 1e-30
    two = np.cross(normal, one)
    for radius in _RADII:
        for direction in range(_DIRECTIONS):
            angle = turn + direction * (2.0 * np.pi / _DIRECTIONS)
            points[number] = here + radius * length * (np.cos(angle) * one + np.sin(angle) * two)
            number += 1
    return points, starts


@kernel
def embed(placement: Placement, vertices: IntArray, mesh: Connectivity, surface: Surface) -> None:
    """Move vertices, one after another, to the points nearest to the means of their neighbours.

    The mean is sought from the neighbour whose normal agrees most with those of all, as it may lie
    between two sheets of the surface.

    Parameters
    ----------
    placement
        Changed.
    vertices
        (n,) vertices that move; all others stay.
    mesh, surface
        The mesh, and what it lies on.
    """
    for vertex in vertices:
        ring = mesh.neighbours[mesh.first[vertex] : mesh.first[vertex + 1]]
        mean, normal = np.zeros(3), np.zeros(3)
        for other in ring:
            mean += placement.positions[other]
            normal += placement.normals[other]
        mean /= len(ring)
        best, start = -np.inf, 0
        for other in ring:
            cosine = (placement.normals[other] * normal).sum()
            if cosine > best:
                best, start = cosine, placement.nearest[other]
        x, y, z = mean
        place(placement, vertex, x, y, z, start, surface)
