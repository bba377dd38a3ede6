"""Named small meshes that tests share: generated, deterministic, with known properties."""

from collections.abc import Callable, Mapping
from functools import cache

import numpy as np
import trimesh
from scipy.spatial import ConvexHull, Delaunay

from solver.arrays import FloatArray, IntArray
from solver.mesh import TriangleMesh, triangle_mesh


@cache
def icosphere(subdivisions: int = 3) -> TriangleMesh:
    """Unit sphere of 10 · 4ⁿ + 2 vertices."""
    sphere = trimesh.creation.icosphere(subdivisions=subdivisions)
    return triangle_mesh(sphere.vertices, sphere.faces)


@cache
def plane_grid(columns: int = 16, rows: int = 11, width: float = 1.5) -> TriangleMesh:
    """Flat rectangle of `width` x 1; vertex (i, j) has index i + j · columns."""
    x, y = np.meshgrid(np.linspace(0.0, width, columns), np.linspace(0.0, 1.0, rows))
    vertices = np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], axis=1)
    return triangle_mesh(vertices, _grid_faces(columns, rows, wrap=(False, False)))


@cache
def torus(
    around: int = 24, across: int = 12, radius: float = 1.0, tube: float = 0.4
) -> TriangleMesh:
    """Torus of revolution on a periodic grid."""
    u, v = np.meshgrid(_circle(around), _circle(across))
    distance = radius + tube * np.cos(v)
    vertices = np.stack([distance * np.cos(u), distance * np.sin(u), tube * np.sin(v)], axis=-1)
    return triangle_mesh(vertices.reshape(-1, 3), _grid_faces(around, across, wrap=(True, True)))


@cache
def tube(around: int = 8, along: int = 200, radius: float = 0.01) -> TriangleMesh:
    """Open cylinder of length 1, so thin that its first eigenfunctions are those of a string."""
    u, z = np.meshgrid(_circle(around), np.linspace(0.0, 1.0, along))
    vertices = np.stack([radius * np.cos(u), radius * np.sin(u), z], axis=-1)
    return triangle_mesh(vertices.reshape(-1, 3), _grid_faces(around, along, wrap=(True, False)))


@cache
def cube(cells: int = 6) -> TriangleMesh:
    """Surface of [0, 1]³, each side a grid of `cells` x `cells` squares."""
    side = plane_grid(cells + 1, cells + 1, 1.0)
    u, v = side.vertices[:, 0], side.vertices[:, 1]
    zero, one = np.zeros_like(u), np.ones_like(u)
    sides = [(v, u, zero), (u, v, one), (zero, v, u), (one, u, v), (u, zero, v), (v, one, u)]
    soup = np.concatenate([np.stack(axes, axis=1) for axes in sides])
    faces = np.concatenate([side.faces + number * side.n_vertices for number in range(6)])
    places, inverse = np.unique(np.round(soup * cells), axis=0, return_inverse=True)
    return triangle_mesh(places / cells, inverse.reshape(-1)[faces])


@cache
def blob(subdivisions: int = 3) -> TriangleMesh:
    """Sphere with bumps of different sizes and heights: no symmetry, extremities well apart."""
    sphere = icosphere(subdivisions)
    return triangle_mesh(with_bumps(sphere.vertices), sphere.faces)


def with_bumps(directions: FloatArray) -> FloatArray:
    """(V, 3) where the blob's surface is, in (V, 3) directions of unit length from its centre."""
    bumps = [
        ((1.0, 0.2, 0.1), 1.5, 0.30),
        ((-0.5, 0.9, 0.3), 1.0, 0.25),
        ((-0.4, -0.5, 0.9), 0.7, 0.35),
        ((0.1, -0.8, -0.7), 1.2, 0.20),
    ]
    height = np.ones(len(directions))
    for direction, size, width in bumps:
        axis = np.array(direction) / np.linalg.norm(direction)
        height += size * np.exp(-((1.0 - directions @ axis) / width**2))
    places: FloatArray = directions * height[:, None]
    return places


@cache
def uneven_sphere(count: int = 2500) -> TriangleMesh:
    """Unit sphere on random points: triangles of all sizes, many of them obtuse."""
    points = np.random.default_rng(5).standard_normal((count, 3))
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    hull = ConvexHull(points)
    return triangle_mesh(points, hull.simplices.astype(np.int64))


@cache
def disc(rings: int = 40) -> TriangleMesh:
    """Flat unit disc of nearly equilateral triangles; vertex 0 is its centre."""
    places = [np.zeros((1, 2))]
    for ring in range(1, rings + 1):
        angle = _circle(6 * ring)
        places.append(ring / rings * np.stack([np.cos(angle), np.sin(angle)], axis=1))
    points = np.concatenate(places)
    vertices = np.column_stack([points, np.zeros(len(points))])
    return triangle_mesh(vertices, Delaunay(points).simplices.astype(np.int64))


@cache
def spherical_cap(angle: float = 1.0, rings: int = 40) -> TriangleMesh:
    """Part of the unit sphere within `angle` of its pole, vertex 0; an open disc."""
    flat = disc(rings)
    radius = np.linalg.norm(flat.vertices, axis=1)
    aside = flat.vertices * (angle * np.sinc(angle * radius / np.pi))[:, None]
    return triangle_mesh(aside + np.cos(angle * radius)[:, None] * [0.0, 0.0, 1.0], flat.faces)


@cache
def cone(share: float = 0.6, rings: int = 40) -> TriangleMesh:
    """Cone of slant height 1 whose apex, vertex 0, has `share` of the angle 2π; an open disc."""
    flat = disc(rings)
    depth = np.sqrt(1.0 - share**2) * np.linalg.norm(flat.vertices, axis=1)
    return triangle_mesh(share * flat.vertices - depth[:, None] * [0.0, 0.0, 1.0], flat.faces)


@cache
def moebius_strip(around: int = 30, across: int = 4) -> TriangleMesh:
    """One-sided band: faces cannot be oriented alike."""
    u, s = np.meshgrid(_circle(around), np.linspace(-0.3, 0.3, across))
    distance = 1.0 + s * np.cos(u / 2)
    points = np.stack([distance * np.cos(u), distance * np.sin(u), s * np.sin(u / 2)], axis=-1)
    faces = _grid_faces(around, across, wrap=(True, False))
    column, row = faces % around, faces // around
    seam = (column.max(axis=1) - column.min(axis=1)) > 1
    mirrored = seam[:, None] & (column == 0)
    faces = np.where(mirrored, (across - 1 - row) * around, faces)
    return triangle_mesh(points.reshape(-1, 3), faces)


@cache
def three_sheets() -> TriangleMesh:
    """Three half planes that meet in a line: every edge on it has three faces."""
    sheet = plane_grid(5, 5, 1.0)
    points, faces = [], []
    for number, angle in enumerate((0.0, 2.0, 4.0)):
        x, y = sheet.vertices[:, 0], sheet.vertices[:, 1]
        points.append(np.stack([x * np.cos(angle), x * np.sin(angle), y], axis=1))
        faces.append(sheet.faces + number * sheet.n_vertices)
    places, inverse = np.unique(np.round(np.concatenate(points), 9), axis=0, return_inverse=True)
    return triangle_mesh(places, inverse.reshape(-1)[np.concatenate(faces)])


@cache
def two_components() -> TriangleMesh:
    """A unit sphere, and a cube of edge 1 beside it; the sphere is the larger."""
    sphere, box = icosphere(2), cube(3)
    return triangle_mesh(
        np.concatenate([sphere.vertices, box.vertices + np.array([3.0, 0.0, 0.0])]),
        np.concatenate([sphere.faces, box.faces + sphere.n_vertices]),
    )


@cache
def tetrahedron() -> TriangleMesh:
    """Regular tetrahedron of edge √2."""
    vertices = np.array([[0.0, 0, 0], [1, 1, 0], [1, 0, 1], [0, 1, 1]])
    return triangle_mesh(vertices, np.array([[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]]))


@cache
def fine_tetrahedron(subdivisions: int = 4) -> TriangleMesh:
    """Regular tetrahedron of edge √2, every face cut into 4ⁿ: closed, flat but at corners."""
    solid = trimesh.Trimesh(tetrahedron().vertices, tetrahedron().faces, process=False)
    for _ in range(subdivisions):
        solid = solid.subdivide()
    return triangle_mesh(solid.vertices, solid.faces)


FLAT_TORUS_SIDES = 7
FLAT_TORUS_SHIFTS = (0, 2)


def flat_torus_corners() -> tuple[FloatArray, FloatArray]:
    """Corners A_k and B_k of two regular polygons, one above the other, half a step apart."""
    angle = 2.0 * np.pi * np.arange(FLAT_TORUS_SIDES) / FLAT_TORUS_SIDES
    polygons = (
        np.stack([np.cos(a), np.sin(a), np.full(FLAT_TORUS_SIDES, height)], axis=1)
        for a, height in ((angle, 0.0), (angle + np.pi / FLAT_TORUS_SIDES, 1.0))
    )
    below, above = polygons
    return below, above


@cache
def flat_torus(subdivisions: int = 3) -> TriangleMesh:
    """Diplotorus (Arnoux, Lelièvre and Márquez, 2021): exactly flat, and polyhedral in space.

    Two regular polygons are joined by two bands of triangles, whose edges are A_k B_{k+s} and
    A_k B_{k+s-1} for the two shifts s. All corners are alike by symmetry, and the angle defects
    of a torus sum up to 0: so each is 0. Cutting faces into 4ⁿ changes nothing.
    """
    below, above = flat_torus_corners()
    n, k = FLAT_TORUS_SIDES, np.arange(FLAT_TORUS_SIDES)
    faces = []
    for number, shift in enumerate(FLAT_TORUS_SHIFTS):
        a, a_next = k, (k + 1) % n
        b, b_next = n + (k + shift) % n, n + (k + shift + 1) % n
        band = [np.stack(corners, axis=1) for corners in ((a, a_next, b), (a_next, b_next, b))]
        faces += [strip[:, :: -1 if number else 1] for strip in band]
    solid = trimesh.Trimesh(np.concatenate([below, above]), np.concatenate(faces), process=False)
    for _ in range(subdivisions):
        solid = solid.subdivide()
    return triangle_mesh(solid.vertices, solid.faces)


@cache
def triangle() -> TriangleMesh:
    """Half of the unit square."""
    vertices = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]])
    return triangle_mesh(vertices, np.array([[0, 1, 2]]))


CONNECTED: Mapping[str, Callable[[], TriangleMesh]] = {
    "icosphere": icosphere,
    "plane_grid": plane_grid,
    "torus": torus,
    "tube": tube,
    "cube": cube,
    "blob": blob,
    "moebius_strip": moebius_strip,
    "three_sheets": three_sheets,
    "tetrahedron": tetrahedron,
    "triangle": triangle,
}
"""Connected meshes by name, some with boundaries, one that is not a manifold."""


def permuted(mesh: TriangleMesh, seed: int) -> tuple[TriangleMesh, IntArray]:
    """Renumber vertices and faces; vertex v of `mesh` becomes vertex ``where[v]``."""
    random = np.random.default_rng(seed)
    where = random.permutation(mesh.n_vertices)
    back = np.argsort(where)
    faces = random.permutation(where[mesh.faces])
    colors = None if mesh.colors is None else mesh.colors[back]
    return triangle_mesh(mesh.vertices[back], faces, colors), where.astype(np.int64)


def moved(mesh: TriangleMesh, seed: int, scale: float = 1.0) -> TriangleMesh:
    """Rotate, scale and shift a mesh."""
    random = np.random.default_rng(seed)
    rotation, _ = np.linalg.qr(random.standard_normal((3, 3)))
    vertices = scale * mesh.vertices @ rotation + scale * random.standard_normal(3)
    return triangle_mesh(vertices, mesh.faces, mesh.colors)


def painted(mesh: TriangleMesh) -> TriangleMesh:
    """Give a mesh colours that differ from place to place."""
    waves = mesh.vertices @ np.array([[3.0, 1.0, 0.0], [0.0, 2.0, 1.0], [1.0, 0.0, 4.0]])
    return triangle_mesh(mesh.vertices, mesh.faces, 0.5 + 0.5 * np.sin(waves))


def _circle(count: int) -> FloatArray:
    return np.linspace(0.0, 2.0 * np.pi, count, endpoint=False)


def _grid_faces(columns: int, rows: int, wrap: tuple[bool, bool]) -> IntArray:
    """Two triangles for every cell of a grid, periodic along its rows, columns, both or neither."""
    i, j = np.meshgrid(np.arange(columns - (not wrap[0])), np.arange(rows - (not wrap[1])))
    right, up = (i + 1) % columns, (j + 1) % rows
    cells = [(x + y * columns).ravel() for x, y in ((i, j), (right, j), (right, up), (i, up))]
    a, b, c, d = cells
    faces = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    return faces.astype(np.int64)
