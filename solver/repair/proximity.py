"""Which vertices of a surface's border lie beside its other border edges."""

import numpy as np
from scipy.spatial import KDTree

from solver.arrays import BoolArray, FloatArray, IntArray

_MOST_CANDIDATES = 64
"""Border vertices in the sphere over a border edge, on average; where there are more, the border is
a tangle, and nothing can be said of it in reasonable time."""


def vertices_beside(
    places: FloatArray, start: IntArray, end: IntArray, slack: FloatArray
) -> tuple[IntArray, IntArray]:
    """Border vertices beside the inner part of border sides.

    Parameters
    ----------
    places
        (V, 3).
    start, end
        (S,) vertices of the sides, which are all of the border.
    slack
        (S,) how far from a side a vertex may lie, and how far from its ends it must.

    Returns
    -------
    side, vertex : (n,), by side and from its start to its end; of vertices that lie beside the
        same point of a side, one.
    """
    nothing = np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.int64)
    mine = np.unique(start)
    if not len(mine):
        return nothing
    origin, way = places[start], places[end] - places[start]
    length = np.linalg.norm(way, axis=1)
    sphere = origin + 0.5 * way, 0.5 * length
    tree = KDTree(places[mine])
    near = np.asarray(tree.query_ball_point(*sphere, return_length=True))
    if near.sum() > _MOST_CANDIDATES * len(start):
        return nothing
    side = np.repeat(np.arange(len(start), dtype=np.int64), near)
    found = [np.array(some, dtype=np.int64) for some in tree.query_ball_point(*sphere)]
    vertex = mine[np.concatenate(found)]
    arm, length, slack = places[vertex] - origin[side], length[side], slack[side]
    along = np.einsum("ij,ij->i", arm, way[side]) / length
    away = np.linalg.norm(arm - (along / length)[:, None] * way[side], axis=1)
    beside: BoolArray = (away <= slack) & (along > slack) & (along < length - slack)
    side, vertex, along, slack = side[beside], vertex[beside], along[beside], slack[beside]
    order = np.lexsort((along, side))
    side, vertex, along, slack = side[order], vertex[order], along[order], slack[order]
    apart = np.ones(len(side), dtype=np.bool_)
    apart[1:] = (side[1:] != side[:-1]) | (np.diff(along) > slack[1:])
    return side[apart], vertex[apart]
