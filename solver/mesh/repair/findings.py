"""What cannot be repaired, but should be known: where a surface is no manifold, or nearly cut."""

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components
from scipy.spatial import KDTree

from solver.arrays import IntArray
from solver.mesh.repair.edges import Edges
from solver.mesh.repair.soup import TriangleSoup, counted

_SUSPICIOUS = 0.1
"""Distance between borders, in lengths of their edges there, below which there may be a crack."""


def with_findings(soup: TriangleSoup) -> TriangleSoup:
    """Note edges of more than two faces, points where the surface only touches itself, cracks."""
    edges = soup.edges
    notes = []
    crowded = int((edges.counts > 2).sum())
    if crowded:
        notes.append(
            f"{counted(crowded, 'edge')} with more than two faces: the surface is no manifold"
            " there; distances lead over all of its sheets"
        )
    pinched = len(pinched_vertices(soup.faces, edges))
    if pinched:
        notes.append(
            f"{counted(pinched, 'vertex', 'vertices')} at which the surface only touches itself:"
            " distances lead through"
        )
    if soup.border.tangled:
        notes.append("the border lies over itself too often to be searched for cracks")
    cracks = _cracks(soup)
    if cracks:
        notes.append(
            f"{counted(cracks, 'border vertex', 'border vertices')} nearly on another border: if"
            " the surface is cracked there, close it, or distances lead around"
        )
    return soup.noting(*notes)


def pinched_vertices(faces: IntArray, edges: Edges) -> IntArray:
    """Vertices whose faces hang together only through them, not over edges.

    Every corner of a face is a node; corners at the same vertex are linked over shared edges.

    Parameters
    ----------
    faces
        (F, 3).
    edges
        Of these faces.
    """
    n = len(faces)
    corner = np.arange(3 * n).reshape(n, 3)
    at_start, at_end = corner.reshape(-1), np.roll(corner, -1, axis=1).reshape(-1)
    upward = (faces < np.roll(faces, -1, axis=1)).reshape(-1)
    low, high = np.where(upward, at_start, at_end), np.where(upward, at_end, at_start)
    edge = edges.of_side.reshape(-1)
    order = np.argsort(edge, kind="stable")
    same = edge[order][1:] == edge[order][:-1]
    links = [np.stack([ends[order][1:], ends[order][:-1]])[:, same] for ends in (low, high)]
    i, j = np.concatenate(links, axis=1)
    graph = sp.coo_array((np.ones(len(i), dtype=np.bool_), (i, j)), shape=(3 * n, 3 * n))
    fans = connected_components(graph, directed=False)[1]
    _, first = np.unique(fans, return_index=True)
    found: IntArray = np.flatnonzero(np.bincount(faces.reshape(-1)[first]) > 1)
    return found


def _cracks(soup: TriangleSoup) -> int:
    """Border vertices much nearer to another one, or to a border edge, than the edges are long."""
    places, border = soup.places, soup.border
    if not len(border.face):
        return 0
    reach = _SUSPICIOUS * border.length
    beside = np.zeros(len(places), dtype=np.bool_)
    beside[border.beside(reach)[1]] = True
    shortest = np.full(len(places), np.inf)
    np.minimum.at(shortest, border.start, reach)
    np.minimum.at(shortest, border.end, reach)
    mine = np.unique(border.start)
    nearest = np.asarray(KDTree(places[mine]).query(places[mine], k=2)[0])[:, 1]
    beside[mine[nearest < shortest[mine]]] = True
    return int(beside.sum())
