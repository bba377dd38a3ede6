"""Normals of a point cloud: fitted planes, with consistent signs.

Hoppe, DeRose, Duchamp, McDonald and Stuetzle, "Surface reconstruction from unorganized points",
SIGGRAPH 1992: planes by principal components of neighbourhoods; signs carried along a minimum
spanning tree of the neighbours, over those first whose planes differ least.
"""

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import breadth_first_order, minimum_spanning_tree

from solver.arrays import FloatArray, IntArray
from solver.mesh.repair import components_of

_SIGN_NEIGHBOURS = 10
"""Neighbours over which signs are carried."""

_LEAST = 1e-6
"""Least difference of planes: weights of 0 would be no edges."""


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
    points: FloatArray, normals: FloatArray, neighbours: IntArray
) -> FloatArray:
    """Give normals consistent signs, outwards at the top of each connected part.

    Parameters
    ----------
    points, normals
        (V, 3) each.
    neighbours
        (V, k) of each point, the nearest first.

    Returns
    -------
    (V, 3) float64.
    """
    count, near = len(points), neighbours[:, :_SIGN_NEIGHBOURS]
    i, j = np.repeat(np.arange(count), near.shape[1]), near.ravel()
    differences = 1.0 - np.abs(np.einsum("ij,ij->i", normals[i], normals[j]))
    # Two points may be neighbours of each other, or one of the other alone: each pair once.
    pairs, first = np.unique(np.sort(np.stack([i, j], axis=1), axis=1), axis=0, return_index=True)
    weights = differences[first] + _LEAST
    graph = sp.csr_array((weights, (pairs[:, 0], pairs[:, 1])), shape=(count, count))
    tree, parts = minimum_spanning_tree(graph), components_of(pairs, count)
    by_height = np.argsort(-points[:, 2], kind="stable")
    signs = np.ones(count)
    for top in by_height[np.unique(parts[by_height], return_index=True)[1]]:
        order, parents = breadth_first_order(tree, top, directed=False)
        along, before = order[1:], parents[order[1:]]
        agree = np.where(np.einsum("ij,ij->i", normals[along], normals[before]) < 0.0, -1.0, 1.0)
        signs[top] = -1.0 if normals[top, 2] < 0.0 else 1.0
        for here, parent, sign in zip(along.tolist(), before.tolist(), agree.tolist(), strict=True):
            signs[here] = sign * signs[parent]
    return signs[:, None] * normals
