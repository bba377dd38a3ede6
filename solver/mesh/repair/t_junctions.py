"""T-junctions: vertices within an edge of the neighbouring face, with a crack in between."""

from dataclasses import dataclass, replace

import numpy as np

from solver.arrays import IntArray
from solver.mesh.repair.soup import TriangleSoup, counted
from solver.mesh.repair.triangulation import MOST_CORNERS, triangulated

_TOLERANCE = 1e-5
"""Largest distance of a T-junction from its edge, in extents of the shape."""

_TOLERANCE_OF_EDGE = 1e-2
"""The same in lengths of the edge."""


@dataclass(frozen=True, eq=False)
class _TJunctions:
    """T-junctions on sides of faces, side after side, from its start to its end.

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


def without_t_junctions(soup: TriangleSoup) -> TriangleSoup:
    """Close cracks at T-junctions: split the faces on whose boundary edges other vertices lie.

    Only where part of the edge is a boundary edge of another face: vertices that merely touch an
    edge stay apart from it.
    """
    found = _t_junctions(soup)
    if found is None:
        return soup
    split = np.zeros(len(soup.faces), dtype=np.bool_)
    split[found.face] = True
    sizes, corners = _polygons(soup.faces, found)
    pieces = triangulated(soup.unit_positions, sizes, corners).triangles
    of_piece = np.repeat(np.flatnonzero(split), sizes - 2)
    # Each piece belongs to the face that it was cut from.
    whole = soup.of_faces(np.concatenate([np.flatnonzero(~split), of_piece]))
    closed = replace(whole, faces=np.concatenate([soup.faces[~split], pieces]))
    return closed.noting(
        f"closed cracks: split {counted(len(sizes), 'face')} at"
        f" {counted(len(found.vertex), 'vertex', 'vertices')} within an edge"
    )


def _t_junctions(soup: TriangleSoup) -> _TJunctions | None:
    boundary = soup.boundary
    slack = np.minimum(_TOLERANCE, _TOLERANCE_OF_EDGE * boundary.length)
    number, vertex = boundary.vertices_beside(slack)
    # The points of a side in order: its start, what lies on it, its end.
    sides = np.unique(number)
    where = np.concatenate([sides, number, sides])
    order = np.argsort(where, kind="stable")
    where = where[order]
    point = np.concatenate([boundary.start[sides], vertex, boundary.end[sides]])[order]
    base = len(soup.vertices)
    parts = np.minimum(point[1:], point[:-1]) * base + np.maximum(point[1:], point[:-1])
    shared = (where[1:] == where[:-1]) & np.isin(parts, soup.edges.boundary @ np.array([base, 1]))
    genuine = np.isin(number, where[1:][shared])
    if not genuine.any() or np.bincount(boundary.face[number]).max() > MOST_CORNERS - 3:
        return None
    number, vertex = number[genuine], vertex[genuine]
    return _TJunctions(boundary.face[number], boundary.side[number], vertex)


def _polygons(faces: IntArray, junctions: _TJunctions) -> tuple[IntArray, IntArray]:
    """Sizes and corners of the polygons that faces with T-junctions on their sides become."""
    split, polygon = np.unique(junctions.face, return_inverse=True)
    owner = np.concatenate([np.repeat(np.arange(len(split)), 3), polygon.reshape(-1)])
    side = np.concatenate([np.tile(np.arange(3), len(split)), junctions.side])
    corner = np.concatenate([faces[split].reshape(-1), junctions.vertex])
    # Stable: the corner at which a side starts comes before the vertices on it.
    order = np.lexsort((side, owner))
    return np.bincount(owner).astype(np.int64), corner[order]
