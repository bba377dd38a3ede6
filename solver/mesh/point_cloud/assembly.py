"""Assembly of a surface of triangles that points have proposed, the most agreed on first."""

import numpy as np

from solver.arrays import BoolArray, FloatArray, IntArray
from solver.kernel import kernel
from solver.mesh.normals import face_normals
from solver.mesh.repair import edges_of

_FOLDED = 0.5
"""Cosine of the angle between two triangles at their edge from which on they lie on each other."""


def votes_for(proposed: IntArray) -> tuple[IntArray, IntArray]:
    """Count the points that propose each triangle.

    Parameters
    ----------
    proposed
        (P, 3) triangles, once for each point that proposes them.

    Returns
    -------
    triangles : (T, 3) int64, each once.
    votes : (T,) int64 corners that propose each, 1 to 3.
    """
    triangles, votes = np.unique(np.sort(proposed, axis=1), axis=0, return_counts=True)
    return triangles, votes.astype(np.int64)


def assembled(
    points: FloatArray, normals: FloatArray, triangles: IntArray, votes: IntArray
) -> tuple[IntArray, IntArray]:
    """Choose triangles such that an edge has two at most, wound alike, and none lies on another.

    Parameters
    ----------
    points, normals
        (V, 3) points, and unit normals of consistent signs, which say how triangles are wound.
    triangles, votes
        Of :func:`votes_for`.

    Returns
    -------
    faces : (F, 3) int64. Those that all three corners propose come first, of these the smallest.
    votes : (F,) int64 corners that proposed each, 1 to 3.
    """
    corners = points[triangles]
    across = face_normals(points, triangles)
    inwards = np.einsum("ij,ij->i", across, normals[triangles].sum(axis=1)) < 0.0
    triangles = np.where(inwards[:, None], triangles[:, ::-1], triangles)
    longest = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
    order = np.lexsort((longest, -votes))
    triangles, votes = triangles[order], votes[order]
    edges = edges_of(triangles)
    upward = triangles < np.roll(triangles, -1, axis=1)
    taken = _chosen(points, triangles, 2 * edges.of_side + upward, 2 * len(edges.ends))
    return triangles[taken], votes[taken]


@kernel
def _chosen(points: FloatArray, triangles: IntArray, half_edges: IntArray, count: int) -> BoolArray:
    """(T,) which triangles are taken, one after the other, where there is place for them."""
    taken = np.zeros(len(triangles), dtype=np.bool_)
    thirds = np.full(count, -1)
    for number in range(len(triangles)):
        fits = True
        for side in range(3):
            half = half_edges[number, side]
            other = thirds[half ^ 1]
            if thirds[half] >= 0:
                fits = False
            elif other >= 0:
                start, end = triangles[number, side], triangles[number, (side + 1) % 3]
                third = triangles[number, (side + 2) % 3]
                fits = fits and not _on_top(points, start, end, third, other)
        if fits:
            taken[number] = True
            for side in range(3):
                thirds[half_edges[number, side]] = triangles[number, (side + 2) % 3]
    return taken


@kernel
def _on_top(points: FloatArray, start: int, end: int, third: int, other: int) -> bool:
    """Return whether the triangles of an edge with two third corners lie on each other."""
    along, one, two = np.empty(3), np.empty(3), np.empty(3)
    square, first, second = 0.0, 0.0, 0.0
    for d in range(3):
        along[d] = points[end, d] - points[start, d]
        one[d] = points[third, d] - points[start, d]
        two[d] = points[other, d] - points[start, d]
        square += along[d] * along[d]
        first += along[d] * one[d]
        second += along[d] * two[d]
    product, here, there = 0.0, 0.0, 0.0
    for d in range(3):
        a, b = one[d] - first / square * along[d], two[d] - second / square * along[d]
        product += a * b
        here += a * a
        there += b * b
    return bool(product > _FOLDED * np.sqrt(here * there))
