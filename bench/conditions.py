"""Artefacts of real scans, simulated on clean surfaces with known places of the vertices."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial import KDTree
from scipy.spatial.transform import Rotation

from solver.arrays import BoolArray, FloatArray, IntArray
from solver.mesh import TriangleMesh, largest_component, simplified, triangle_mesh, vertex_normals
from solver.shape import Shape
from synthetic import glued, near_in_space, noisy, remeshed, subdivided, with_holes

_HOLES, _HOLE_RADIUS = 5, 0.03
"""Number of holes, and their geodesic radius over √area."""
_CUT_RADIUS = 0.2
"""Geodesic radius over √area of what is cut off at the end of a limb."""
_APART = 0.6
"""Least geodesic distance over √area of points that are glued."""
_BUMPS, _BUMP_RADIUS, _BUMP_HEIGHT = 12, 0.12, 0.05
"""Number of bumps, and their radius and height over √area."""


@dataclass(frozen=True, eq=False)
class Scan:
    """A scan of a surface.

    Parameters
    ----------
    mesh
        The scan.
    places
        (N, 3) position on the clean surface of each vertex by its number in the file.
    """

    mesh: TriangleMesh
    places: FloatArray


Condition = Callable[[TriangleMesh], Scan]
"""A function that scans a closed surface of unit area."""


def scanned(mesh: TriangleMesh, condition: Condition) -> Scan:
    """Scan a surface, and keep the largest component of the scan.

    Parameters
    ----------
    mesh
        Closed, of unit area.
    condition
        One of :data:`CONDITIONS`.
    """
    scan = condition(mesh)
    return replace(scan, mesh=largest_component(scan.mesh))


def _as_it_is(mesh: TriangleMesh) -> Scan:
    return Scan(mesh, mesh.vertices)


def _coarse(vertices: int) -> Condition:
    def condition(mesh: TriangleMesh) -> Scan:
        return _near(mesh, simplified(mesh, vertices))

    return condition


def _fine(mesh: TriangleMesh) -> Scan:
    """About 50,000 vertices, by subdividing twice."""
    coarse = simplified(mesh, 50_000 // 16) if 16 * mesh.n_vertices > 50_000 else mesh
    vertices, faces = coarse.vertices, coarse.faces
    for _ in range(2):
        vertices, faces = subdivided(vertices, faces)
    return _near(mesh, triangle_mesh(vertices, faces))


def _rough(share: float) -> Condition:
    """Noise in all directions, its standard deviation a share of the bounding box's diagonal."""

    def condition(mesh: TriangleMesh) -> Scan:
        deviation = share * float(np.linalg.norm(np.ptp(mesh.vertices, axis=0))) / np.sqrt(3.0)
        moves = deviation * np.random.default_rng(5).standard_normal(mesh.vertices.shape)
        return Scan(triangle_mesh(mesh.vertices + moves, mesh.faces), mesh.vertices)

    return condition


def _remeshed(mesh: TriangleMesh) -> Scan:
    return _near(mesh, remeshed(mesh, 3 * mesh.n_vertices // 5, seed=3).mesh)


def _irregular(mesh: TriangleMesh) -> Scan:
    """Simplified, then with vertices inserted into random triangles, twice."""
    coarse, rng = simplified(mesh, 1500), np.random.default_rng(7)
    vertices, faces = coarse.vertices, coarse.faces
    for _ in range(2):
        split = rng.random(len(faces)) < 0.3
        a, b, c = faces[split].T
        new = len(vertices) + np.arange(len(a))
        vertices = np.concatenate([vertices, vertices[faces[split]].mean(axis=1)])
        three = [np.stack(corners, axis=1) for corners in ((a, b, new), (b, c, new), (c, a, new))]
        faces = np.concatenate([faces[~split], *three])
    return _near(mesh, triangle_mesh(vertices, faces))


def _with_holes(mesh: TriangleMesh) -> Scan:
    """As many of the holes as fit."""
    return _near(mesh, with_holes(mesh, _HOLES, _HOLE_RADIUS, least=0).mesh)


def _cut(count: int) -> Condition:
    """Ends of limbs cut off, by farthest point sampling."""

    def condition(mesh: TriangleMesh) -> Scan:
        shape = Shape(mesh)
        ends = shape.sampling("geodesic", count).indices
        return _kept(mesh, shape.metric("geodesic").distances(ends).min(axis=0) > _CUT_RADIUS)

    return condition


def _unit(factor: float) -> Condition:
    def condition(mesh: TriangleMesh) -> Scan:
        return Scan(
            triangle_mesh(mesh.vertices * factor + 100.0 * factor, mesh.faces), mesh.vertices
        )

    return condition


def _upside_down(mesh: TriangleMesh) -> Scan:
    turn = Rotation.from_euler("xyz", (170.0, 25.0, 40.0), degrees=True).as_matrix()
    return Scan(triangle_mesh(mesh.vertices @ turn.T, mesh.faces), mesh.vertices)


def _inside_out(mesh: TriangleMesh) -> Scan:
    return Scan(triangle_mesh(mesh.vertices, mesh.faces[:, ::-1]), mesh.vertices)


def _glued(count: int) -> Condition:
    """Glued where distant parts come near in space, as a hand and a hip do."""

    def condition(mesh: TriangleMesh) -> Scan:
        return _near(mesh, glued(mesh, near_in_space(mesh, count, _APART), 0.02).mesh)

    return condition


def _clothed(mesh: TriangleMesh) -> Scan:
    """Smooth bumps, as of hair, bags and clothes."""
    centres = np.random.default_rng(4).choice(mesh.n_vertices, _BUMPS, replace=False)
    apart = np.linalg.norm(mesh.vertices[:, None] - mesh.vertices[centres], axis=2)
    height = _BUMP_HEIGHT * np.exp(-0.5 * (apart / (0.5 * _BUMP_RADIUS)) ** 2).sum(axis=1)
    normals = vertex_normals(mesh.vertices, mesh.faces)
    return Scan(triangle_mesh(mesh.vertices + height[:, None] * normals, mesh.faces), mesh.vertices)


def _everything(mesh: TriangleMesh) -> Scan:
    """Holes, glue, noise, few vertices."""
    first = _with_holes(mesh).mesh
    second = glued(first, near_in_space(first, 1, _APART), 0.02).mesh
    return _near(mesh, simplified(noisy(second, 0.2, seed=2).mesh, 2000))


CONDITIONS: Mapping[str, Condition] = {
    "as it is": _as_it_is,
    "1,000 vertices": _coarse(1000),
    "500 vertices": _coarse(500),
    "50,000 vertices": _fine,
    "noise of 0.5 %": _rough(0.005),
    "noise of 1 %": _rough(0.01),
    "remeshed": _remeshed,
    "irregular": _irregular,
    "five holes": _with_holes,
    "one end cut off": _cut(1),
    "three ends cut off": _cut(3),
    "in another unit": _unit(1000.0),
    "upside down": _upside_down,
    "inside out": _inside_out,
    "glued once": _glued(1),
    "glued twice": _glued(2),
    "clothed": _clothed,
    "holes, glue, noise": _everything,
}


def _near(clean: TriangleMesh, mesh: TriangleMesh) -> Scan:
    """Scan whose vertices have hardly moved: their places are the nearest clean vertices."""
    places = np.empty((int(mesh.vertex_ids.max()) + 1, 3))
    places[:] = np.nan
    nearest = KDTree(clean.vertices).query(mesh.vertices)[1]
    places[mesh.vertex_ids] = clean.vertices[nearest]
    return Scan(mesh, places)


def _kept(mesh: TriangleMesh, kept: BoolArray) -> Scan:
    """Scan without the triangles at the vertices that are not kept."""
    faces: IntArray = mesh.faces[kept[mesh.faces].all(axis=1)]
    return Scan(triangle_mesh(mesh.vertices, faces), mesh.vertices)
