"""Transformations τ of a surface with known correspondence (section 3)."""

from dataclasses import dataclass

import numpy as np

from solver.arrays import BoolArray, FloatArray, IntArray
from solver.mesh import TriangleMesh, triangle_mesh, vertex_normals
from synthetic.nearest_surface import NearestSurface
from synthetic.remeshing import collapse_short_edges, flip_edges, relax


@dataclass(frozen=True, eq=False)
class Transformed:
    """A transformed surface τ(X), and the images of the vertices of X.

    Attributes
    ----------
    mesh
        τ(X), n vertices.
    image
        (V,) int64, for every vertex of X the vertex of τ(X) at, or nearest to, its image.
    kept
        (V,) bool, whether the image is on the surface, and not in a hole.
    """

    mesh: TriangleMesh
    image: IntArray
    kept: BoolArray


def scaled(mesh: TriangleMesh, factor: float) -> Transformed:
    """Multiply all lengths, about the origin.

    Parameters
    ----------
    mesh
        X.
    factor
        Positive.
    """
    return _with_vertices(mesh, factor * mesh.vertices)


def noisy(mesh: TriangleMesh, amount: float, seed: int = 0) -> Transformed:
    """Move every vertex along its normal by a normally distributed distance.

    Parameters
    ----------
    mesh
        X.
    amount
        Standard deviation of the distance, in mean lengths of edges.
    seed
        Of the distances.
    """
    ends = mesh.vertices[mesh.edges]
    edge = float(np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1).mean())
    distance = amount * edge * np.random.default_rng(seed).standard_normal(mesh.n_vertices)
    normals = vertex_normals(mesh.vertices, mesh.faces)
    return _with_vertices(mesh, mesh.vertices + distance[:, None] * normals)


def remeshed(mesh: TriangleMesh, resolution: int, seed: int = 0) -> Transformed:
    """Remesh the surface with edges of nearly equal length.

    Parameters
    ----------
    mesh
        X, closed and oriented.
    resolution
        Number of vertices of the new triangulation; they lie on the surface of the old one.
    seed
        Another seed gives another triangulation.

    Raises
    ------
    ValueError
        The surface has a boundary.
    """
    if not mesh.closed:
        raise ValueError("only closed surfaces can be remeshed")
    rng = np.random.default_rng(seed)
    surface = NearestSurface(mesh)
    vertices, faces = mesh.vertices, mesh.faces
    while len(vertices) < 2 * resolution:
        vertices, faces = subdivided(vertices, faces)
    while len(vertices) > resolution:
        before = len(vertices)
        count = max(resolution, before * 2 // 3)
        vertices, faces = collapse_short_edges(vertices, faces, surface, count, rng)
        if len(vertices) == before:
            break
        faces = flip_edges(vertices, faces, rng)
        vertices = relax(vertices, faces, surface, 2)
    for _ in range(4):
        faces = flip_edges(vertices, faces, rng)
        vertices = relax(vertices, faces, surface, 2)
    new = triangle_mesh(surface.nearest(vertices).points, flip_edges(vertices, faces, rng))
    image = NearestSurface(new).nearest(mesh.vertices)
    kept = np.ones(mesh.n_vertices, dtype=np.bool_)
    return Transformed(new, image.vertices, kept)


def _with_vertices(mesh: TriangleMesh, vertices: FloatArray) -> Transformed:
    moved = triangle_mesh(vertices, mesh.faces, mesh.colors)
    every = np.arange(mesh.n_vertices)
    return Transformed(moved, every, np.ones(mesh.n_vertices, dtype=np.bool_))


def subdivided(vertices: FloatArray, faces: IntArray) -> tuple[FloatArray, IntArray]:
    """Split every triangle into four at the midpoints of its edges, which follow the vertices."""
    n = len(vertices)
    tail, head = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    keys = np.minimum(tail, head) * n + np.maximum(tail, head)
    edges, which = np.unique(keys, return_inverse=True)
    a, b = np.divmod(edges, n)
    ab, bc, ca = (n + which.reshape(-1, 3)).T
    p, q, r = faces.T
    corners = [(p, ab, ca), (q, bc, ab), (r, ca, bc), (ab, bc, ca)]
    finer = np.concatenate([np.stack(corner, axis=1) for corner in corners])
    return np.concatenate([vertices, 0.5 * (vertices[a] + vertices[b])]), finer
