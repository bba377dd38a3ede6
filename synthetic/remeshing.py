"""Isotropic remeshing to a given size: edge collapse, edge flips and tangential smoothing.

Each step treats many independent edges at once, as array operations, and keeps the surface a closed
manifold of the same genus.
"""

from collections.abc import Callable

import numpy as np
from scipy import sparse

from solver.arrays import BoolArray, FloatArray, IntArray
from solver.mesh import face_normals
from synthetic.implicit import Skin

Surface = Callable[[FloatArray], Skin]
"""Level set, gradient and thickness of a surface at (p, 3) points."""


_DEEPEST_CHORD = 0.4
"""Largest depth of an edge below the surface, in thicknesses: at least four edges around a limb."""


def edges_of(faces: IntArray) -> IntArray:
    """Every edge of a closed, oriented surface once, (E, 2) int64, smaller vertex first."""
    tail, head = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    forward = tail < head  # each edge is passed once in each direction
    return np.stack([tail[forward], head[forward]], axis=1)


def collapse_short_edges(
    vertices: FloatArray,
    faces: IntArray,
    surface: Surface,
    count: int,
    rng: np.random.Generator,
) -> tuple[FloatArray, IntArray]:
    """Merge the ends of short edges until ``count`` vertices are left.

    Parameters
    ----------
    vertices, faces
        (V, 3) float64 and (F, 3) int64, a closed manifold.
    surface
        Surface onto which merged vertices are projected.
    count
        Number of vertices to end with; more are left only when every further collapse would
        change the topology, fold the surface or cut a thin part.
    rng
        Chooses among the edges that may be collapsed at once.

    Returns
    -------
    vertices, faces
        The coarser mesh.
    """
    stalled = 0
    while len(vertices) > count and stalled < 12:
        edges = edges_of(faces)
        skin = surface(vertices[edges].mean(axis=1))
        lengths = np.linalg.norm(vertices[edges[:, 0]] - vertices[edges[:, 1]], axis=1)
        lengths /= edge_sizes(skin)
        lengths[skin.value < -_DEEPEST_CHORD * skin.thickness] = np.inf
        limit = np.quantile(lengths, min(0.4 + 0.05 * stalled, 1.0), method="lower")
        short = (lengths <= limit) & np.isfinite(lengths)
        chosen = edges[_far_apart(edges, short, len(vertices), rng)]
        sound = _meets_link_condition(chosen, edges, len(vertices))
        chosen = chosen[sound][: len(vertices) - count]
        merged = onto(vertices[chosen].mean(axis=1), surface)
        unfolded = _keeps_normals(chosen, merged, vertices, faces)
        chosen, merged = chosen[unfolded], merged[unfolded]
        stalled = stalled + 1 if len(chosen) == 0 else 0
        vertices, faces = _merge(chosen, merged, vertices, faces)
    return vertices, faces


def _far_apart(
    edges: IntArray, allowed: BoolArray, n_vertices: int, rng: np.random.Generator
) -> IntArray:
    """Indices of allowed edges, no two of which have ends that are equal or adjacent."""
    priority = np.where(allowed, rng.permutation(len(edges)), len(edges))
    own = np.full(n_vertices, len(edges))
    np.minimum.at(own, edges[:, 0], priority)
    np.minimum.at(own, edges[:, 1], priority)
    around = own.copy()
    np.minimum.at(around, edges[:, 0], own[edges[:, 1]])
    np.minimum.at(around, edges[:, 1], own[edges[:, 0]])
    best = np.minimum(around[edges[:, 0]], around[edges[:, 1]])
    indices: IntArray = np.flatnonzero(allowed & (priority == best))
    return indices


def _meets_link_condition(chosen: IntArray, edges: IntArray, n_vertices: int) -> BoolArray:
    """Link condition: the ends of the edge have exactly two common neighbours."""
    ones = np.ones(2 * len(edges), dtype=np.int64)
    rows = np.concatenate([edges[:, 0], edges[:, 1]])
    columns = np.concatenate([edges[:, 1], edges[:, 0]])
    adjacent = sparse.csr_array((ones, (rows, columns)), shape=(n_vertices, n_vertices))
    shared = adjacent[chosen[:, 0]].multiply(adjacent[chosen[:, 1]])
    common: IntArray = shared @ np.ones(n_vertices, dtype=np.int64)
    verdict: BoolArray = common == 2
    return verdict


def _keeps_normals(
    chosen: IntArray, merged: FloatArray, vertices: FloatArray, faces: IntArray
) -> BoolArray:
    """(n,) edges that can be collapsed without turning a neighbouring triangle by over 60°."""
    owner = np.full(len(vertices), -1)
    owner[chosen] = np.arange(len(chosen))[:, None]
    moved = vertices.copy()
    moved[chosen] = merged[:, None]
    before, after = face_normals(vertices, faces), face_normals(moved, faces)
    owners = owner[faces].max(axis=1)
    vanishing = np.sum(owner[faces] == owners[:, None], axis=1) == 2
    cosine = np.einsum("fd,fd->f", before, after)
    cosine /= np.linalg.norm(before, axis=1) * np.linalg.norm(after, axis=1) + 1e-30
    folded = (owners >= 0) & ~vanishing & (cosine < 0.5)
    verdict = np.ones(len(chosen), dtype=np.bool_)
    verdict[owners[folded]] = False
    return verdict


def _merge(
    chosen: IntArray, merged: FloatArray, vertices: FloatArray, faces: IntArray
) -> tuple[FloatArray, IntArray]:
    """Replace both ends of each edge by the merged vertex and renumber."""
    vertices = vertices.copy()
    vertices[chosen[:, 0]] = merged
    image = np.arange(len(vertices))
    image[chosen[:, 1]] = chosen[:, 0]
    kept = np.ones(len(vertices), dtype=np.bool_)
    kept[chosen[:, 1]] = False
    faces = (np.cumsum(kept) - 1)[image[faces]]
    a, b, c = faces.T
    return vertices[kept], faces[(a != b) & (b != c) & (c != a)]


def flip_edges(vertices: FloatArray, faces: IntArray, rng: np.random.Generator) -> IntArray:
    """Flip edges whose opposite angles sum to more than pi: one step towards Delaunay.

    Parameters
    ----------
    vertices, faces
        (V, 3) float64 and (F, 3) int64, a closed manifold.
    rng
        Chooses among edges too close together to be flipped at once.

    Returns
    -------
    faces
        (F, 3) int64, with at least one edge fewer that is not Delaunay, if any could be flipped.
    """
    n = len(vertices)
    tail, head = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    opposite = np.roll(faces, -2, axis=1).ravel()
    forward = np.argsort(tail * n + head)
    backward = np.argsort(head * n + tail)
    first, second = forward[tail[forward] < head[forward]], backward[tail[forward] < head[forward]]
    a, b, c, d = tail[first], head[first], opposite[first], opposite[second]
    angle = _angle(vertices, c, a, b) + _angle(vertices, d, a, b)
    normals = face_normals(vertices, faces)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True) + 1e-30
    flat = np.einsum("ed,ed->e", normals[first // 3], normals[second // 3]) > 0.5
    valence = np.bincount(faces.ravel(), minlength=n)
    keys = np.sort(tail * n + head)
    wanted = c * n + d
    exists = keys[np.minimum(np.searchsorted(keys, wanted), len(keys) - 1)] == wanted
    allowed = (angle > np.pi + 1e-6) & flat & (valence[a] > 4) & (valence[b] > 4) & ~exists
    corners = np.stack([a, b, c, d], axis=1)
    priority = np.where(allowed, rng.permutation(len(a)), len(a))
    best = np.full(n, len(a))
    np.minimum.at(best, corners, priority[:, None])
    chosen = np.flatnonzero(allowed & (best[corners].min(axis=1) == priority))
    chosen = chosen[(best[corners[chosen]] == priority[chosen, None]).all(axis=1)]
    faces = faces.copy()
    faces[first[chosen] // 3] = np.stack([a, d, c], axis=1)[chosen]
    faces[second[chosen] // 3] = np.stack([d, b, c], axis=1)[chosen]
    return faces


def _angle(vertices: FloatArray, at: IntArray, a: IntArray, b: IntArray) -> FloatArray:
    u, v = vertices[a] - vertices[at], vertices[b] - vertices[at]
    cross = np.linalg.norm(np.cross(u, v), axis=1)
    angle: FloatArray = np.arctan2(cross, np.einsum("ed,ed->e", u, v))
    return angle


def relax(
    vertices: FloatArray, faces: IntArray, surface: Surface, steps: int, strength: float = 0.5
) -> FloatArray:
    """Move vertices along the surface towards the centre of their neighbours.

    Parameters
    ----------
    vertices, faces
        (V, 3) float64 and (F, 3) int64.
    surface
        The surface that the vertices stay on.
    steps
        Number of moves.
    strength
        Share of the way to the centre that one move goes.

    Returns
    -------
    vertices
        (V, 3) float64.
    """
    n = len(vertices)
    edges = edges_of(faces)
    tail, head = np.concatenate([edges, edges[:, ::-1]]).T
    for _ in range(steps):
        skin = surface(vertices)
        normal = skin.gradient / np.linalg.norm(skin.gradient, axis=1, keepdims=True)
        sizes = edge_sizes(skin)
        pull = 1.0 / (sizes[tail] + sizes[head])
        adjacent = sparse.csr_array((pull, (tail, head)), shape=(n, n))
        centre = adjacent @ vertices / np.bincount(tail, pull, minlength=n)[:, None]
        move = centre - vertices
        move -= np.einsum("vd,vd->v", move, normal)[:, None] * normal
        moved = onto(vertices + strength * move, surface)
        vertices = np.where(_folded(moved, faces, normal)[:, None], vertices, moved)
    return vertices


def _folded(vertices: FloatArray, faces: IntArray, normals: FloatArray) -> BoolArray:
    """(V,) vertices of triangles that face away from the surface's normals."""
    facing = face_normals(vertices, faces)
    outwards = normals[faces].sum(axis=1)
    cosine = np.einsum("fd,fd->f", facing, outwards)
    cosine /= np.linalg.norm(facing, axis=1) * np.linalg.norm(outwards, axis=1) + 1e-30
    verdict = np.zeros(len(vertices), dtype=np.bool_)
    verdict[faces[cosine < 0.6]] = True
    return verdict


def edge_sizes(skin: Skin) -> FloatArray:
    """Target edge lengths up to a factor: shorter where the body is thinner."""
    return np.sqrt(skin.thickness)


def onto(vertices: FloatArray, surface: Surface) -> FloatArray:
    """Project points near the surface onto it by Newton steps along the gradient."""
    for _ in range(2):
        skin = surface(vertices)
        square = np.einsum("vd,vd->v", skin.gradient, skin.gradient)
        vertices = vertices - (skin.value / square)[:, None] * skin.gradient
    return vertices
