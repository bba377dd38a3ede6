"""Colours of surfaces: corresponding vertices have the same colour."""

import numpy as np
from scipy.spatial import KDTree

from broker.contracts import DenseCorrespondence
from solver.arrays import FloatArray
from solver.mesh import TriangleMesh

_PALEST = 0.35
"""Least value of a channel, so that points and lines stand out from the surface."""


def colors_by_place(vertices: FloatArray) -> FloatArray:
    """(V, 3) colours by position: red, green and blue increase along x, y and z.

    Parameters
    ----------
    vertices
        (V, 3) in the coordinates of the paper.
    """
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    shares = (vertices - low) / np.maximum(high - low, 1e-300)
    colors: FloatArray = _PALEST + (1.0 - _PALEST) * shares
    return colors


def transferred_colors(
    colors: FloatArray, source: TriangleMesh, target: TriangleMesh, found: DenseCorrespondence
) -> FloatArray:
    """(W, 3) colours transferred to the target: the mean over the vertices mapped to each vertex.

    Parameters
    ----------
    colors
        (V, 3) of the source's vertices.
    source, target
        The meshes X and Y.
    found
        The map of the vertices of X. Vertices of Y that nothing is mapped to have the colour of
        the nearest one that something is mapped to.
    """
    here = source.vertices_of(np.array(found.source, dtype=np.int64))
    there = target.vertices_of(np.array(found.target, dtype=np.int64))
    known = (here >= 0) & (there >= 0)
    total = np.zeros((target.n_vertices, 3))
    np.add.at(total, there[known], colors[here[known]])
    count = np.bincount(there[known], minlength=target.n_vertices)
    reached = np.flatnonzero(count)
    nearest = reached[KDTree(target.vertices[reached]).query(target.vertices)[1]]
    transferred: FloatArray = total[nearest] / count[nearest][:, None]
    return transferred
