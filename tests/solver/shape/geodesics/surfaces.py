"""Surfaces on which shortest paths are known in closed form, with all their distances."""

from functools import cache

import numpy as np
from scipy.spatial import Delaunay

from solver.arrays import FloatArray, IntArray
from solver.mesh import TriangleMesh, triangle_mesh
from tests.solver import shapes


@cache
def random_rectangle(width: float = 1.5, points: int = 400) -> TriangleMesh:
    """Flat rectangle of `width` x 1, triangulated at random."""
    rng = np.random.default_rng(3)
    corners = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]])
    plane = np.concatenate([corners, rng.random((points, 2))])
    faces = Delaunay(plane).simplices
    return triangle_mesh(
        np.column_stack([plane * [width, 1.0], np.zeros(len(plane))]), faces.astype(np.int64)
    )


def straight(mesh: TriangleMesh, sources: IntArray) -> FloatArray:
    """(S, V) straight lines in space."""
    lines: FloatArray = np.linalg.norm(mesh.vertices[sources][:, None] - mesh.vertices, axis=2)
    return lines


@cache
def prism() -> tuple[TriangleMesh, FloatArray]:
    """Tube of seven flat sides, a strip of the plane rolled up, and its (V, V) distances."""
    around, radius = 7, 0.15
    mesh = shapes.tube(around, 15, radius)
    side = 2.0 * radius * np.sin(np.pi / around)
    across = side * (np.arange(mesh.n_vertices) % around)
    apart = np.abs(across[:, None] - across)
    apart = np.minimum(apart, around * side - apart)
    exact = np.hypot(apart, mesh.vertices[:, None, 2] - mesh.vertices[:, 2])
    return mesh, exact


@cache
def cone(sectors: int, angle: float, rings: int = 6) -> tuple[TriangleMesh, FloatArray, FloatArray]:
    """Polyhedral cone: the mesh, and each vertex's distance from the apex and its angle round it.

    It is glued of triangular sectors, flat each, of which `angle` is taken at the apex; more than
    2π in all make a saddle.
    """
    rim_angle = 2.0 * np.pi * np.arange(sectors) / sectors
    # Neighbouring points of the rim, at distance 1 from the apex, are 2 sin(angle/2) apart.
    if sectors * angle < 2.0 * np.pi:
        radius = np.sin(angle / 2) / np.sin(np.pi / sectors)
        height = np.full(sectors, np.sqrt(1.0 - radius**2))
    else:
        # By turns up and down by h: (2h)² + (2r sin(π/n))² = 4 sin²(angle/2), h² + r² = 1.
        s = np.sin(np.pi / sectors) ** 2
        h2 = (np.sin(angle / 2) ** 2 - s) / (1.0 - s)
        radius = np.sqrt(1.0 - h2)
        height = np.sqrt(h2) * (-1.0) ** np.arange(sectors)
    rim = np.column_stack([radius * np.cos(rim_angle), radius * np.sin(rim_angle), height])
    places: dict[tuple[int, int, int], int] = {(0, 0, 0): 0}
    points, distance, direction = [np.zeros(3)], [0.0], [0.0]
    faces = []

    def vertex(sector: int, i: int, j: int) -> int:
        """The point i/rings of the way to the sector's first rim point and j/rings to its next."""
        if i + j == 0:
            return 0
        if i == 0:
            sector, i, j = (sector + 1) % sectors, j, 0
        if (sector, i, j) not in places:
            places[sector, i, j] = len(points)
            points.append((i * rim[sector] + j * rim[(sector + 1) % sectors]) / rings)
            flat = (i + j * np.exp(1j * angle)) / rings
            distance.append(float(np.abs(flat)))
            direction.append(sector * angle + float(np.angle(flat)))
        return places[sector, i, j]

    for sector in range(sectors):
        for i in range(rings):
            for j in range(rings - i):
                corner = [vertex(sector, i, j), vertex(sector, i + 1, j), vertex(sector, i, j + 1)]
                faces.append(corner)
                if i + j < rings - 1:
                    faces.append([corner[1], vertex(sector, i + 1, j + 1), corner[2]])
    mesh = triangle_mesh(np.array(points), np.array(faces))
    return mesh, np.array(distance), np.array(direction)


def cone_distances(
    distance: FloatArray, direction: FloatArray, total: float, sources: IntArray
) -> FloatArray:
    """(S, V) straight lines on the unrolled cone, or by way of its apex, `total` being its angle.

    Its rim is convex, so that no straight line leaves it.
    """
    apart = np.abs(direction[sources][:, None] - direction)
    apart = np.minimum(apart, total - apart)
    r, s = distance[sources][:, None], distance[None, :]
    lines = np.sqrt(np.maximum(r * r + s * s - 2.0 * r * s * np.cos(apart), 0.0))
    found: FloatArray = np.where(apart < np.pi, lines, r + s)
    return found


def cube_from_corner(vertices: FloatArray) -> FloatArray:
    """(V,) from the corner at 0 of [0, 1]³: straight, or over one edge to the far sides."""
    x, y, z = np.sort(vertices, axis=1).T  # on a side far from the corner, z = 1
    beside = np.isclose(x, 0.0)
    near: FloatArray = np.sqrt(y * y + z * z)
    # Of the two unfolded ways to (x, y, 1), the one over the edge where x runs is shorter.
    far = np.sqrt(y * y + (z + x) ** 2)
    return np.where(beside, near, far)


@cache
def bent_rectangle() -> TriangleMesh:
    """L-shaped flat domain: the square [0, 2]² without (1, 2] x (1, 2]."""
    grid = shapes.plane_grid(21, 21, 1.0)
    points = grid.vertices * 2.0
    centres = points[grid.faces].mean(axis=1)
    kept = ~((centres[:, 0] > 1.0) & (centres[:, 1] > 1.0))
    return triangle_mesh(points, grid.faces[kept])


def around_the_corner(mesh: TriangleMesh, sources: IntArray) -> FloatArray:
    """(S, V) distances in the L-shaped domain: straight, or by way of its reflex corner."""
    corner = np.array([1.0, 1.0, 0.0])
    lines = straight(mesh, sources)
    arms = np.linalg.norm(mesh.vertices - corner, axis=1)
    a, b = mesh.vertices[sources][:, None, :2] - 1.0, mesh.vertices[None, :, :2] - 1.0
    # The corner is in the way if the line passes it on the outer side; both ends must be in
    # different arms for that.
    turn = a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]
    from_right = (a[..., 0] > 0) & (b[..., 1] > 0) & (turn > 0)
    from_above = (a[..., 1] > 0) & (b[..., 0] > 0) & (turn < 0)
    found: FloatArray = np.where(from_right | from_above, arms[sources][:, None] + arms, lines)
    return found
