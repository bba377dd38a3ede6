"""Edges of triangles: their faces, the boundary edges, fans at vertices, and components."""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components

from solver.arrays import BoolArray, IntArray


@dataclass(frozen=True, eq=False)
class Edges:
    """Edges, and the sides of faces (half-edges) along them.

    Parameters
    ----------
    ends
        (E, 2) vertices of each edge, smaller first, in lexicographic order.
    counts
        (E,) faces at each edge.
    of_side
        (F, 3) edge of each face's sides: from corner 0 to 1, 1 to 2 and 2 to 0.
    """

    ends: IntArray
    counts: IntArray
    of_side: IntArray

    @property
    def boundary_sides(self) -> tuple[IntArray, IntArray]:
        """(B,) faces and (B,) sides (0, 1, 2) along boundary edges, which have one face."""
        faces, sides = np.nonzero(self.counts[self.of_side] == 1)
        return faces.astype(np.int64), sides.astype(np.int64)

    @property
    def boundary(self) -> IntArray:
        """(B, 2) the boundary edges, which have one face."""
        found: IntArray = self.ends[self.counts == 1]
        return found


def edges_of(faces: IntArray) -> Edges:
    """Gather the edges of faces.

    Parameters
    ----------
    faces
        (F, 3) vertex indices, three different ones in each face.
    """
    following = np.roll(faces, -1, axis=1)
    base = int(faces.max(initial=-1)) + 1
    keys, of_side, counts = np.unique(
        np.minimum(faces, following) * base + np.maximum(faces, following),
        return_inverse=True,
        return_counts=True,
    )
    ends = np.stack(np.divmod(keys, max(base, 1)), axis=1)
    return Edges(
        ends.astype(np.int64),
        counts.astype(np.int64),
        of_side.reshape(-1, 3).astype(np.int64),
    )


def same_direction(faces: IntArray, edges: Edges) -> tuple[IntArray, BoolArray]:
    """Pairs of faces at the edges of exactly two, and whether both traverse it the same way.

    Where the winding is consistent, neighbours traverse their edge in opposite directions.

    Parameters
    ----------
    faces
        (F, 3).
    edges
        Of these faces.

    Returns
    -------
    pairs : (P, 2) face indices.
    same : (P,) whether the two faces have inconsistent winding.
    """
    upward = (faces < np.roll(faces, -1, axis=1)).reshape(-1)
    edge = edges.of_side.reshape(-1)
    order = np.argsort(edge, kind="stable")
    order = order[edges.counts[edge[order]] == 2].reshape(-1, 2)
    same: BoolArray = upward[order[:, 0]] == upward[order[:, 1]]
    return (order // 3).astype(np.int64), same


def fans_of(faces: IntArray, edges: Edges) -> IntArray:
    """Number the fans: the faces at a vertex that are connected over the edges at it.

    Every corner of a face is a node; corners at the same vertex are linked over shared edges.
    Edges of any number of faces are allowed.

    Parameters
    ----------
    faces
        (F, 3).
    edges
        Of these faces.

    Returns
    -------
    (F, 3) int64 fan of each face at each of its corners, numbered from 0.
    """
    corner = np.arange(faces.size).reshape(-1, 3)
    at_start, at_end = corner.reshape(-1), np.roll(corner, -1, axis=1).reshape(-1)
    upward = (faces < np.roll(faces, -1, axis=1)).reshape(-1)
    low, high = np.where(upward, at_start, at_end), np.where(upward, at_end, at_start)
    edge = edges.of_side.reshape(-1)
    order = np.argsort(edge, kind="stable")
    same = edge[order][1:] == edge[order][:-1]
    links = [np.stack([ends[order][1:], ends[order][:-1]], axis=1)[same] for ends in (low, high)]
    return components_of(np.concatenate(links), faces.size).reshape(-1, 3)


def non_manifold_vertices(faces: IntArray, edges: Edges) -> IntArray:
    """Vertices whose faces are not connected over the edges at them: they have several fans.

    Parameters
    ----------
    faces
        (F, 3).
    edges
        Of these faces.

    Returns
    -------
    (n,) int64 vertex indices, ascending.
    """
    _, first = np.unique(fans_of(faces, edges), return_index=True)
    found: IntArray = np.flatnonzero(np.bincount(faces.reshape(-1)[first]) > 1)
    return found


def components_of(pairs: IntArray, size: int) -> IntArray:
    """Number the connected components of a graph.

    Parameters
    ----------
    pairs
        (P, 2) vertices that are connected.
    size
        Number of vertices.

    Returns
    -------
    (size,) int64 component of each vertex, numbered from 0.
    """
    graph = sp.coo_array((np.ones(len(pairs), dtype=np.bool_), tuple(pairs.T)), shape=(size, size))
    return connected_components(graph, directed=False)[1].astype(np.int64)
