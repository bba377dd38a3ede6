"""The boundary of a surface, and the boundary vertices that lie near other boundary edges."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from scipy.spatial import KDTree

from solver.arrays import BoolArray, FloatArray, IntArray
from solver.mesh.edges import Edges

_MOST_CANDIDATES: Final = 64
"""Boundary vertices in the sphere over a boundary edge, on average; where there are more, finding
T-junctions and cracks takes too long."""

_MARGIN: Final = 1.1
"""Radius within which vertices are counted, relative to the sphere's. A k-d tree takes time for
points near the surface of the sphere too: of a fan they may all be there, and none inside."""

_BATCH: Final = 1024
"""Spheres counted between two looks at the total."""


@dataclass(frozen=True, eq=False)
class Boundary:
    """Sides of faces along the boundary, and the boundary vertices in the spheres over them.

    Parameters
    ----------
    face, side
        (S,) the face of each side of the boundary, and which of its sides: from corner 0 to 1, 1 to
        2, 2 to 0.
    start, end
        (S,) vertices of the side.
    length
        (S,) of the side.
    crowded
        Whether there are too many vertices in the spheres; then none are listed.
    number, vertex
        (n,) a side (0..S-1), and a vertex of other faces in the sphere whose diameter it is.
    along, away
        (n,) distance of the vertex from the side's start along the side, and from its line.
    """

    face: IntArray
    side: IntArray
    start: IntArray
    end: IntArray
    length: FloatArray
    crowded: bool
    number: IntArray
    vertex: IntArray
    along: FloatArray
    away: FloatArray

    def vertices_beside(self, slack: FloatArray) -> tuple[IntArray, IntArray]:
        """Find boundary vertices beside the inner part of boundary sides.

        Parameters
        ----------
        slack
            (S,) largest distance from a side, and least distance from its ends.

        Returns
        -------
        number, vertex : (n,) sides and vertices, by side and from its start to its end. Of
            vertices closer together along the side than `slack`, only the first.
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


def boundary_of(positions: FloatArray, faces: IntArray, edges: Edges) -> Boundary:
    """Find the boundary, and the boundary vertices near it.

    Parameters
    ----------
    positions
        (V, 3).
    faces
        (F, 3).
    edges
        Of these faces.
    """
    face, side = edges.boundary_sides
    start, end = faces[face, side], faces[face, (side + 1) % 3]
    way = positions[end] - positions[start]
    length = np.linalg.norm(way, axis=1)
    nothing = np.zeros(0, dtype=np.int64)
    number, vertex, crowded = nothing, nothing, False
    if len(face):
        mine = np.unique(start)
        # A little smaller: the ends, and what lies across them, are of no interest.
        radius = (0.5 - 1e-6) * length
        tree, centre = KDTree(positions[mine]), positions[start] + 0.5 * way
        crowded = denser_than(tree, centre, _MARGIN * radius)
        if not crowded:
            near = tree.query_ball_point(centre, radius)
            number = np.repeat(np.arange(len(face), dtype=np.int64), [len(some) for some in near])
            vertex = mine[np.concatenate(near).astype(np.int64)]
            # In a flat triangle the third corner lies in the sphere too, and is no neighbour.
            others = np.all(faces[face[number]] != vertex[:, None], axis=1)
            number, vertex = number[others], vertex[others]
    arm = positions[vertex] - positions[start[number]]
    along = np.einsum("ij,ij->i", arm, way[number]) / length[number]
    away = np.linalg.norm(arm - (along / length[number])[:, None] * way[number], axis=1)
    return Boundary(face, side, start, end, length, crowded, number, vertex, along, away)


def denser_than(
    tree: KDTree, centre: FloatArray, radius: FloatArray | float, most: int = _MOST_CANDIDATES
) -> bool:
    """Return whether spheres hold more than `most` points on average; stop counting once certain.

    Parameters
    ----------
    tree
        Of the points.
    centre, radius
        (S, 3), and (S,) or one for all.
    most
        Points in a sphere, on average; those in two spheres count twice.
    """
    radius = np.broadcast_to(radius, len(centre))
    left = most * len(centre)
    for first in range(0, len(centre), _BATCH):
        some = slice(first, first + _BATCH)
        left -= int(np.sum(tree.query_ball_point(centre[some], radius[some], return_length=True)))
        if left < 0:
            return True
    return False
