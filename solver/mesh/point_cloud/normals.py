"""Normals of a point cloud: fitted planes, with consistent signs.

Planes by principal components of neighbourhoods, as Hoppe, DeRose, Duchamp, McDonald and Stuetzle,
"Surface reconstruction from unorganized points", SIGGRAPH 1992, fit them. They carry signs from
point to point along a minimum spanning tree; but in thin parts, such as hands, planes mix both
sides, and all beyond comes out inside out. Here signs are carried from triangle to triangle, of
those that lie on one side, as all of their corners agree on them.
"""

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import breadth_first_order, minimum_spanning_tree
from scipy.spatial import KDTree

from solver.arrays import FloatArray, IntArray
from solver.mesh.normals import face_normals, vertex_normals
from solver.mesh.repair import components_of, edges_of, same_direction

_LINKS = 4
"""Nearest points over which signs are carried where triangles are not connected."""

_LEAST = 1e-6
"""Least difference of triangles: weights of 0 would be no edges."""

_GAP = 2.0
"""Weight of a link, more than of any edge of two triangles."""


def fitted_planes(points: FloatArray, neighbours: IntArray) -> tuple[FloatArray, FloatArray]:
    """Planes of least squared distance to the points' neighbourhoods.

    Parameters
    ----------
    points
        (V, 3).
    neighbours
        (V, k) of each point, without itself.

    Returns
    -------
    centres : (V, 3) means of the neighbourhoods, the points included.
    normals : (V, 3) unit normals, of any sign.
    """
    around = np.concatenate([points[:, None], points[neighbours]], axis=1)
    centres = around.mean(axis=1)
    around -= centres[:, None]
    moments = np.einsum("vki,vkj->vij", around, around)
    return centres, np.linalg.eigh(moments)[1][:, :, 0]


def with_consistent_signs(
    points: FloatArray, normals: FloatArray, triangles: IntArray, neighbours: IntArray
) -> FloatArray:
    """Give normals consistent signs, outwards at the top of each connected part.

    Parameters
    ----------
    points, normals
        (V, 3) each.
    triangles
        (T, 3), of any winding.
    neighbours
        (V, k) of each point, the nearest first.

    Returns
    -------
    (V, 3) float64.
    """
    if not len(triangles):
        return normals
    pairs, turned, weights = _joined(points, triangles, neighbours)
    signs, part = _carried(pairs, turned, weights, len(triangles))
    wound = np.where(signs[:, None] < 0.0, triangles[:, ::-1], triangles)
    side = vertex_normals(points, wound)
    # The sign of a part is that at its highest point.
    corners, of_corner = wound.ravel(), np.repeat(part, 3)
    order = np.argsort(-points[corners, 2], kind="stable")
    top = order[np.unique(of_corner[order], return_index=True)[1]]
    outwards = np.where(side[corners[top], 2] < 0.0, -1.0, 1.0)
    part_of_point = np.zeros(len(points), dtype=np.int64)
    part_of_point[corners] = of_corner
    side *= outwards[part_of_point][:, None]
    known = np.flatnonzero(np.linalg.norm(side, axis=1) > 0.0)
    nearest = known[KDTree(points[known]).query(points)[1]]
    agree = np.einsum("ij,ij->i", normals, side[nearest])
    return normals * np.where(agree < 0.0, -1.0, 1.0)[:, None]


def _joined(
    points: FloatArray, triangles: IntArray, neighbours: IntArray
) -> tuple[IntArray, FloatArray, FloatArray]:
    """Pairs of triangles over which signs are carried.

    Returns
    -------
    pairs : (P, 2), each once, in lexicographic order.
    turned : (P,) -1 where the sign changes, else 1.
    weights : (P,) the less, the surer.
    """
    unit = face_normals(points, triangles)
    unit /= np.maximum(np.linalg.norm(unit, axis=1, keepdims=True), 1e-300)
    sides, same = same_direction(triangles, edges_of(triangles))
    turned = np.where(same, -1.0, 1.0)
    weights = 1.0 - turned * np.einsum("ij,ij->i", unit[sides[:, 0]], unit[sides[:, 1]])
    at = np.full(len(points), -1)
    at[triangles.ravel()] = np.repeat(np.arange(len(triangles)), 3)
    near = neighbours[:, :_LINKS]
    links = np.stack([np.repeat(at, near.shape[1]), at[near.ravel()]], axis=1)
    links = links[(links >= 0).all(axis=1) & (links[:, 0] != links[:, 1])]
    alike = np.einsum("ij,ij->i", unit[links[:, 0]], unit[links[:, 1]])
    pairs = np.sort(np.concatenate([sides, links]), axis=1)
    turned = np.concatenate([turned, np.where(alike < 0.0, -1.0, 1.0)])
    weights = np.concatenate([weights, _GAP + 1.0 - np.abs(alike)]) + _LEAST
    # Of several joints of two triangles the first, an edge if there is one.
    pairs, first = np.unique(pairs, axis=0, return_index=True)
    return pairs, turned[first], weights[first]


def _carried(
    pairs: IntArray, turned: FloatArray, weights: FloatArray, count: int
) -> tuple[FloatArray, IntArray]:
    """(T,) signs, carried along a minimum spanning tree of each part, and (T,) parts."""
    part = components_of(pairs, count)
    # One more node joins the parts, so that one tree holds all.
    begins = np.unique(part, return_index=True)[1]
    rows = np.concatenate([pairs[:, 0], begins])
    columns = np.concatenate([pairs[:, 1], np.full(len(begins), count)])
    values = np.concatenate([weights, np.ones(len(begins))])
    graph = sp.csr_array((values, (rows, columns)), shape=(count + 1, count + 1))
    tree = minimum_spanning_tree(graph)
    parents = breadth_first_order(tree, count, directed=False)[1].astype(np.int64)
    parents[count] = count
    node = np.flatnonzero(parents[:count] < count)
    keys = pairs[:, 0] * count + pairs[:, 1]
    pair = np.sort(np.stack([node, parents[node]], axis=1), axis=1)
    signs = np.ones(count + 1)
    signs[node] = turned[np.searchsorted(keys, pair[:, 0] * count + pair[:, 1])]
    while (parents != count).any():
        # Of the path to the ancestor known so far, and from there on.
        signs, parents = signs * signs[parents], parents[parents]
    return signs[:count], part
