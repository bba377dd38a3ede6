"""Changes of a surface's topology (section 3): holes, and gluing of points."""

import numpy as np
from scipy.spatial import KDTree

from solver.arrays import BoolArray, FloatArray, IntArray
from solver.mesh import TriangleMesh, triangle_mesh
from solver.shape import GeodesicMetric, farthest_point_sampling
from solver.shape.geodesics import GeodesicGraph
from synthetic.transformations import Transformed


def punched(mesh: TriangleMesh, centres: IntArray, radius: float) -> Transformed:
    """Cut holes into a surface.

    Parameters
    ----------
    mesh
        X, closed.
    centres
        (h,) int64 vertices around which holes are cut.
    radius
        Geodesic radius of the holes; triangles at the centre are cut out in any case.

    Returns
    -------
    transformed
        With h boundaries. The image of a vertex in a hole is the nearest vertex of the rest.

    Raises
    ------
    ValueError
        A hole would not be a disc.
    """
    gone = np.zeros(mesh.n_faces, dtype=np.bool_)
    for centre in centres:
        gone |= _disc(mesh, int(centre), radius)[0]
    return _rebuilt(mesh, mesh.faces[~gone])


def with_holes(
    mesh: TriangleMesh, count: int, radius: float, seed: int = 0, least: int | None = None
) -> Transformed:
    """Punch holes at random places, where one of that size does not cut a limb off.

    Parameters
    ----------
    mesh
        A closed surface.
    count
        Number of holes.
    radius
        Their geodesic radius.
    seed
        Chooses the places.
    least
        Number of holes that will do where no more fit; `count` by default.

    Raises
    ------
    ValueError
        The surface is too thin for so many.
    """
    every = np.arange(mesh.n_vertices)
    found = Transformed(mesh, every, np.ones(mesh.n_vertices, dtype=np.bool_))
    centres: list[int] = []
    for centre in np.random.default_rng(seed).permutation(mesh.n_vertices):
        try:
            tried = punched(mesh, np.array([*centres, centre]), radius)
        except ValueError:
            continue
        if tried.mesh.components == 1:
            centres, found = [*centres, int(centre)], tried
        if len(centres) == count:
            return found
    if len(centres) < (count if least is None else least):
        raise ValueError("the surface is too thin for holes of that size")
    return found


def glued(mesh: TriangleMesh, pairs: IntArray, radius: float | None = None) -> Transformed:
    """Glue a surface to itself: each pair of discs is replaced by a tube between their rims.

    Parameters
    ----------
    mesh
        X, closed and oriented.
    pairs
        (h, 2) int64, the vertices that are glued, their discs apart from one another.
    radius
        Geodesic radius of the discs; the triangles around the vertices go in any case. ``None``
        for one triangle at each vertex: as nearly two points as can be glued.

    Returns
    -------
    transformed
        Closed, of a genus greater by h.

    Raises
    ------
    ValueError
        A part to be glued would not be a disc, or two of them touch.
    """
    gone = np.zeros(mesh.n_faces, dtype=np.bool_)
    taken = np.zeros(mesh.n_vertices, dtype=np.bool_)
    tubes = []
    for pair in pairs:
        rims = []
        for vertex in pair:
            part = None if radius is None else _disc(mesh, int(vertex), radius)
            disc, rim = part or _triangle(mesh, int(vertex))
            touched = np.unique(mesh.faces[disc])
            if taken[touched].any():
                raise ValueError("parts to be glued touch one another")
            taken[touched] = True
            gone |= disc
            rims.append(rim)
        tubes.append(_tube(mesh.vertices, rims[0], rims[1]))
    return _rebuilt(mesh, np.concatenate([mesh.faces[~gone], *tubes]))


def submesh(mesh: TriangleMesh, kept: BoolArray) -> tuple[IntArray, TriangleMesh]:
    """Cut a part out of a surface.

    Parameters
    ----------
    mesh
        Any mesh.
    kept
        (F,) which of its faces.

    Returns
    -------
    vertices
        (n,) vertices of these faces, ascending.
    part
        The mesh of them.
    """
    faces = mesh.faces[kept]
    vertices = np.unique(faces)
    return vertices, triangle_mesh(mesh.vertices[vertices], np.searchsorted(vertices, faces))


def near_in_space(mesh: TriangleMesh, count: int, apart: float, candidates: int = 300) -> IntArray:
    """Find points far apart on the surface and near in space, at which it may be glued.

    Parameters
    ----------
    mesh
        X, connected.
    count
        Number of pairs.
    apart
        Least geodesic distance between the points of a pair, and half of the least distance of
        two pairs.
    candidates
        Number of places, spread over the surface, at which a pair may begin.

    Returns
    -------
    pairs
        (count, 2) int64 or fewer, the nearest first.
    """
    metric = GeodesicMetric(GeodesicGraph(mesh))
    places = farthest_point_sampling(metric, min(candidates, mesh.n_vertices)).indices
    geodesic = metric.distances(places)
    allowed = geodesic >= apart
    spatial = np.linalg.norm(mesh.vertices[places][:, None] - mesh.vertices, axis=2)
    chosen: list[tuple[int, int]] = []
    while len(chosen) < count:
        shortened = np.where(allowed, geodesic / np.maximum(spatial, 1e-30), 0.0)
        row, column = np.unravel_index(int(shortened.argmax()), shortened.shape)
        if not shortened[row, column] > 0.0:
            break
        pair = int(places[row]), int(column)
        chosen.append(pair)
        around = metric.distances(np.array(pair)).min(axis=0) < 0.5 * apart
        allowed[around[places]] = False
        allowed[:, around] = False
    return np.array(chosen, dtype=np.int64).reshape(-1, 2)


def _triangle(mesh: TriangleMesh, vertex: int) -> tuple[BoolArray, IntArray]:
    """The first face at a vertex, and its rim."""
    disc = np.zeros(mesh.n_faces, dtype=np.bool_)
    first = int(np.flatnonzero((mesh.faces == vertex).any(axis=1))[0])
    disc[first] = True
    return disc, mesh.faces[first]


def _disc(mesh: TriangleMesh, centre: int, radius: float) -> tuple[BoolArray, IntArray]:
    """Faces with a vertex within the radius of a centre, and their rim, a closed walk.

    Where the rim meets itself the faces around are added, until it is simple.
    """
    inner = GeodesicGraph(mesh).distances(np.array([centre]))[0] <= radius
    inner[centre] = True
    for _ in range(20):
        disc = inner[mesh.faces].any(axis=1)
        rim = _rim(mesh.faces[disc])
        starts, counts = np.unique(rim[:, 0], return_counts=True)
        if (counts == 1).all():
            break
        inner[starts[counts > 1]] = True
    following = dict(rim.tolist())
    walk = [int(rim[0, 0])] if len(rim) else []
    while walk and following[walk[-1]] != walk[0] and len(walk) <= len(rim):
        walk.append(following[walk[-1]])
    if not walk or len(walk) != len(rim):
        raise ValueError(f"what is around vertex {centre} is not a disc")
    return disc, np.array(walk, dtype=np.int64)


def _rim(faces: IntArray) -> IntArray:
    """(r, 2) directed edges of faces whose reverses are not edges of them."""
    edges = faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    n = int(edges.max()) + 1
    reversed_too = np.isin(edges[:, 0] * n + edges[:, 1], edges[:, 1] * n + edges[:, 0])
    rim: IntArray = edges[~reversed_too]
    return rim


def _tube(vertices: FloatArray, first: IntArray, second: IntArray) -> IntArray:
    """Triangles between two rims, each walked as the disc it bounds: the second runs backwards."""
    second = second[::-1]
    between = np.linalg.norm(vertices[first][:, None] - vertices[second], axis=2)
    row, column = np.unravel_index(int(between.argmin()), between.shape)
    a, b = np.roll(first, -int(row)), np.roll(second, -int(column))
    a, b = np.append(a, a[0]), np.append(b, b[0])
    i = j = 0
    triangles = []
    while i < len(a) - 1 or j < len(b) - 1:
        ahead = np.inf if i == len(a) - 1 else np.linalg.norm(vertices[a[i + 1]] - vertices[b[j]])
        behind = np.inf if j == len(b) - 1 else np.linalg.norm(vertices[a[i]] - vertices[b[j + 1]])
        if ahead <= behind:
            triangles.append((a[i], a[i + 1], b[j]))
            i += 1
        else:
            triangles.append((b[j + 1], b[j], a[i]))
            j += 1
    return np.array(triangles, dtype=np.int64)


def _rebuilt(mesh: TriangleMesh, faces: IntArray) -> Transformed:
    """The mesh of other faces on the same vertices, without unused ones."""
    kept = np.zeros(mesh.n_vertices, dtype=np.bool_)
    kept[faces] = True
    number = np.cumsum(kept) - 1
    colors = None if mesh.colors is None else mesh.colors[kept]
    new = triangle_mesh(mesh.vertices[kept], number[faces], colors)
    left = np.flatnonzero(kept)
    nearest = np.asarray(KDTree(mesh.vertices[left]).query(mesh.vertices)[1], dtype=np.int64)
    return Transformed(new, np.where(kept, number, nearest), kept)
