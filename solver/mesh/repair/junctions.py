"""T-junctions: a vertex inside an edge of the neighbouring face, and a crack between the two."""

from dataclasses import dataclass, replace

import numpy as np

from solver.arrays import IntArray
from solver.mesh.repair.soup import TriangleSoup, counted
from solver.mesh.repair.triangulation import MOST_CORNERS, triangulated

_OFF_THE_EDGE = 1e-5
"""Farthest, in extents of the shape, that a vertex may lie from the edge that it is on."""

_OF_THE_EDGE = 1e-2
"""The same in lengths of the edge."""


@dataclass(frozen=True, eq=False)
class _Junctions:
    """Vertices on sides of faces, side after side, from its start to its end.

    Parameters
    ----------
    face
        (n,) the face.
    side
        (n,) which of its sides: from corner 0 to 1, 1 to 2, 2 to 0.
    vertex
        (n,) the vertex that lies on it.
    """

    face: IntArray
    side: IntArray
    vertex: IntArray


def without_junctions(soup: TriangleSoup) -> TriangleSoup:
    """Split faces along whose border edge other border vertices lie, so that the surface closes.

    Only where some part of the edge is a border edge of another face: vertices that merely touch
    an edge stay apart from it.
    """
    found = _junctions(soup)
    if found is None:
        return soup
    split = np.zeros(len(soup.faces), dtype=np.bool_)
    split[found.face] = True
    sizes, corners = _polygons(soup.faces, found)
    pieces = triangulated(soup.places, sizes, corners).triangles
    closed = replace(soup, faces=np.concatenate([soup.faces[~split], pieces]))
    return closed.noting(
        f"closed cracks: split {counted(len(sizes), 'face')} at"
        f" {counted(len(found.vertex), 'vertex', 'vertices')} within an edge"
    )


def _junctions(soup: TriangleSoup) -> _Junctions | None:
    border = soup.border
    slack = np.minimum(_OFF_THE_EDGE, _OF_THE_EDGE * border.length)
    number, vertex = border.beside(slack)
    # The points of a side in order: its start, what lies on it, its end.
    sides = np.unique(number)
    where = np.concatenate([sides, number, sides])
    order = np.argsort(where, kind="stable")
    where = where[order]
    point = np.concatenate([border.start[sides], vertex, border.end[sides]])[order]
    base = len(soup.vertices)
    parts = np.minimum(point[1:], point[:-1]) * base + np.maximum(point[1:], point[:-1])
    shared = (where[1:] == where[:-1]) & np.isin(parts, soup.edges.border @ np.array([base, 1]))
    genuine = np.isin(number, where[1:][shared])
    if not genuine.any() or np.bincount(border.face[number]).max() > MOST_CORNERS - 3:
        return None
    number, vertex = number[genuine], vertex[genuine]
    return _Junctions(border.face[number], border.side[number], vertex)


def _polygons(faces: IntArray, junctions: _Junctions) -> tuple[IntArray, IntArray]:
    """Sizes and corners of the faces with vertices on their sides, these inserted."""
    split, polygon = np.unique(junctions.face, return_inverse=True)
    owner = np.concatenate([np.repeat(np.arange(len(split)), 3), polygon.reshape(-1)])
    side = np.concatenate([np.tile(np.arange(3), len(split)), junctions.side])
    corner = np.concatenate([faces[split].reshape(-1), junctions.vertex])
    # Stable: the corner at which a side starts comes before the vertices on it.
    order = np.lexsort((side, owner))
    return np.bincount(owner).astype(np.int64), corner[order]
