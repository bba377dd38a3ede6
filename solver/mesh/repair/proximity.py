"""The border of a surface, and which of its vertices lie beside its other edges."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from scipy.spatial import KDTree

from solver.arrays import BoolArray, FloatArray, IntArray
from solver.mesh.repair.edges import Edges

_MOST_CANDIDATES: Final = 64
"""Border vertices in the sphere over a border edge and close around it, on average; where there are
more, the border is a tangle, and nothing can be said of it in reasonable time."""

_AROUND: Final = 1.1
"""How much larger the sphere is within which they are counted. A search takes as long as there are
points in the sphere or near its surface: of a fan they may all be there, and none inside."""

_AT_ONCE: Final = 1024
"""Spheres whose points are counted before it is asked whether that is enough."""


@dataclass(frozen=True, eq=False)
class Border:
    """The sides of faces along the border, and the border vertices in the spheres over them.

    Parameters
    ----------
    face, side
        (S,) the face of each side of the border, and which of its sides: from corner 0 to 1, 1 to
        2, 2 to 0.
    start, end
        (S,) vertices of the side.
    length
        (S,) of the side.
    tangled
        Whether there are too many vertices in the spheres; then none are given.
    number, vertex
        (n,) a side (0..S-1), and a vertex in the sphere whose diameter it is.
    along, away
        (n,) where the vertex lies: from the side's start along it, and from its line.
    """

    face: IntArray
    side: IntArray
    start: IntArray
    end: IntArray
    length: FloatArray
    tangled: bool
    number: IntArray
    vertex: IntArray
    along: FloatArray
    away: FloatArray

    def beside(self, slack: FloatArray) -> tuple[IntArray, IntArray]:
        """Border vertices beside the inner part of border sides.

        Parameters
        ----------
        slack
            (S,) how far from a side a vertex may lie, and how far from its ends it must.

        Returns
        -------
        number, vertex : (n,), by side and from its start to its end; of vertices that lie beside
            the same point of a side, one.
        """
        reach = slack[self.number]
        beside: BoolArray = (self.away <= reach) & (self.along > reach)
        beside &= self.along < self.length[self.number] - reach
        number, vertex = self.number[beside], self.vertex[beside]
        along, reach = self.along[beside], reach[beside]
        order = np.lexsort((along, number))
        number, vertex, along = number[order], vertex[order], along[order]
        apart = np.ones(len(number), dtype=np.bool_)
        apart[1:] = (number[1:] != number[:-1]) | (np.diff(along) > reach[order][1:])
        return number[apart], vertex[apart]


def border_of(places: FloatArray, faces: IntArray, edges: Edges) -> Border:
    """Find the border, and what lies near it.

    Parameters
    ----------
    places
        (V, 3).
    faces
        (F, 3).
    edges
        Of these faces.
    """
    face, side = edges.border_sides
    start, end = faces[face, side], faces[face, (side + 1) % 3]
    way = places[end] - places[start]
    length = np.linalg.norm(way, axis=1)
    nothing = np.zeros(0, dtype=np.int64)
    number, vertex, tangled = nothing, nothing, False
    if len(face):
        mine = np.unique(start)
        # A little smaller: the ends, and what lies across them, are of no interest.
        radius = (0.5 - 1e-6) * length
        tree, centre = KDTree(places[mine]), places[start] + 0.5 * way
        tangled = crowded(tree, centre, _AROUND * radius)
        if not tangled:
            near = tree.query_ball_point(centre, radius)
            number = np.repeat(np.arange(len(face), dtype=np.int64), [len(some) for some in near])
            vertex = mine[np.concatenate(near).astype(np.int64)]
    arm = places[vertex] - places[start[number]]
    along = np.einsum("ij,ij->i", arm, way[number]) / length[number]
    away = np.linalg.norm(arm - (along / length[number])[:, None] * way[number], axis=1)
    return Border(face, side, start, end, length, tangled, number, vertex, along, away)


def crowded(
    tree: KDTree, centre: FloatArray, radius: FloatArray | float, most: int = _MOST_CANDIDATES
) -> bool:
    """Whether there are too many points in spheres to go through; counted until that is known.

    Parameters
    ----------
    tree
        Of the points.
    centre, radius
        (S, 3), and (S,) or one for all.
    most
        Points in a sphere, on average.
    """
    radius = np.broadcast_to(radius, len(centre))
    left = most * len(centre)
    for first in range(0, len(centre), _AT_ONCE):
        some = slice(first, first + _AT_ONCE)
        left -= int(np.sum(tree.query_ball_point(centre[some], radius[some], return_length=True)))
        if left < 0:
            return True
    return False
