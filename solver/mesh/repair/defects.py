"""Defects that are noted and not repaired: non-manifold edges and vertices, possible cracks."""

import numpy as np
from scipy.spatial import KDTree

from solver.mesh.edges import non_manifold_vertices
from solver.mesh.repair.soup import TriangleSoup, counted

_CRACK_WIDTH = 0.1
"""Distance between boundary edges, in lengths of these, below which there may be a crack."""


def with_defects_noted(soup: TriangleSoup) -> TriangleSoup:
    """Note non-manifold edges and vertices, and boundary vertices that may belong to a crack.

    Of a point cloud nothing is noted: its faces are ours, and the user cannot mend them.
    """
    if soup.is_cloud:
        return soup
    edges = soup.edges
    notes = []
    sheets = int((edges.counts > 2).sum())
    if sheets:
        notes.append(
            f"{counted(sheets, 'non-manifold edge')} with more than two faces: distances lead over"
            " all sheets that meet there"
        )
    touching = len(non_manifold_vertices(soup.faces, edges))
    if touching:
        vertices = counted(touching, "non-manifold vertex", "non-manifold vertices")
        notes.append(f"{vertices} at which the surface only touches itself: distances lead through")
    if soup.boundary.crowded:
        notes.append(
            "too many boundary vertices lie close together: the surface was not searched for cracks"
        )
    cracks = _cracks(soup)
    if cracks:
        notes.append(
            f"{counted(cracks, 'boundary vertex', 'boundary vertices')} nearly on another boundary"
            " edge: if the surface has a crack there, close it, or distances lead around it"
        )
    return soup.noting(*notes)


def _cracks(soup: TriangleSoup) -> int:
    """Number of boundary vertices much nearer to another one, or to a boundary edge, than edges."""
    positions, boundary = soup.unit_positions, soup.boundary
    if not len(boundary.face):
        return 0
    reach = _CRACK_WIDTH * boundary.length
    beside = np.zeros(len(positions), dtype=np.bool_)
    beside[boundary.vertices_beside(reach)[1]] = True
    shortest = np.full(len(positions), np.inf)
    np.minimum.at(shortest, boundary.start, reach)
    np.minimum.at(shortest, boundary.end, reach)
    mine = np.unique(boundary.start)
    nearest = np.asarray(KDTree(positions[mine]).query(positions[mine], k=2)[0])[:, 1]
    beside[mine[nearest < shortest[mine]]] = True
    return int(beside.sum())
