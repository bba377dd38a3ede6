"""Colours of surfaces whose points correspond: what is alike in colour belongs together."""

import numpy as np
from scipy.spatial import KDTree

from broker.contracts import DenseCorrespondence
from solver.arrays import FloatArray
from solver.mesh import TriangleMesh

_PALEST = 0.35


def colors_by_place(vertices: FloatArray) -> FloatArray:
    """(V, 3) colours, from each direction in space one, pale enough to draw upon.

    Parameters
    ----------
    vertices
        (V, 3), of a shape as it is drawn.
    """
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    shares = (vertices - low) / np.maximum(high - low, 1e-300)
    colors: FloatArray = _PALEST + (1.0 - _PALEST) * shares
    return colors


def colors_carried(
    colors: FloatArray, source: TriangleMesh, target: TriangleMesh, found: DenseCorrespondence
) -> FloatArray:
    """(W, 3) colours of the target's vertices: the mean of what was carried there.

    Parameters
    ----------
    colors
        (V, 3) of the source's vertices.
    source, target
        The meshes X and Y.
    found
        Where the vertices of X go. Where nothing goes, the colour is that of the nearest vertex
        to which something does.
    """
    here = source.vertices_of(np.array(found.source, dtype=np.int64))
    there = target.vertices_of(np.array(found.target, dtype=np.int64))
    known = (here >= 0) & (there >= 0)
    total = np.zeros((target.n_vertices, 3))
    np.add.at(total, there[known], colors[here[known]])
    count = np.bincount(there[known], minlength=target.n_vertices)
    reached = np.flatnonzero(count)
    nearest = reached[KDTree(target.vertices[reached]).query(target.vertices)[1]]
    carried: FloatArray = total[nearest] / count[nearest][:, None]
    return carried
