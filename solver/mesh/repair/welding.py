"""Vertices that are one point of the surface but several in the file.

Programs repeat vertices along the seams of textures and normals, or store every face by itself.
The surface falls apart there: to a Laplacian or a geodesic, a seam is a cut.
"""

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components
from scipy.spatial import KDTree

from solver.arrays import FloatArray, IntArray
from solver.mesh.repair.proximity import crowded
from solver.mesh.repair.soup import TriangleSoup, counted, groups_of_equal_rows

SEAM = 1e-5
"""Farthest apart, in extents of the shape, that vertices of a seam may lie and be one point."""

_OF_AN_EDGE = 0.1
"""The same in lengths of the shortest edge at either vertex, lest small faces be swallowed."""

_POINT = 1e-7
"""Length of an edge, in extents of the shape, whose ends are one point: single precision cannot
tell them apart."""

_MOST_PAIRS = 64
"""Pairs of near vertices per border vertex; where there are more, nothing is a seam."""

_ASKEW = 1e-3
"""Sine of the angle between two border edges that lie on one another."""


def without_copies(soup: TriangleSoup) -> TriangleSoup:
    """Drop parts of the surface that lie exactly on another part: its copies, or its back.

    A part is what hangs together by its vertices. Faces that are repeated singly, on the same
    vertices, are none: see ``degenerate``.
    """
    place = groups_of_equal_rows((soup.vertices + 0.0).T)  # -0.0 and 0.0 are the same place
    if len(np.unique(place)) == len(place):
        return soup
    corners = np.sort(place[soup.faces], axis=1)
    part = _components(soup.faces[:, [0, 1, 1, 2]].reshape(-1, 2), len(soup.vertices))
    part_of_face = part[soup.faces[:, 0]]
    by_part = np.argsort(part_of_face, kind="stable")
    first = np.empty(len(corners), dtype=np.int64)
    first[by_part] = by_part[groups_of_equal_rows(corners[by_part].T)]
    copied = part_of_face[first] != part_of_face
    alone = np.bincount(part_of_face, weights=~copied, minlength=part.max() + 1)
    keep = alone[part_of_face] > 0
    if keep.all():
        return soup
    # Its vertices live on in those of the part that stays.
    stays = np.zeros(len(place), dtype=np.bool_)
    stays[soup.faces[keep]] = True
    gone = np.zeros(len(place), dtype=np.bool_)
    gone[soup.faces[~keep]] = True
    representative = np.full(len(place), -1)
    staying = np.flatnonzero(stays)[::-1]
    representative[place[staying]] = staying
    into = np.where(gone, representative[place], np.arange(len(place)))
    return soup.with_faces(keep, "lying exactly on others").with_vertices_merged(into)


def without_tiny_edges(soup: TriangleSoup) -> TriangleSoup:
    """Merge the ends of edges of no length: needles collapse, and their neighbours close up."""
    places = soup.places
    ends = soup.edges.ends
    lengths = np.linalg.norm(places[ends[:, 0]] - places[ends[:, 1]], axis=1)
    into = _lowest(_components(ends[lengths <= _POINT], len(places)))
    merged = int((into != np.arange(len(into))).sum())
    if not merged:
        return soup
    return soup.with_vertices_merged(into).noting(
        f"merged {counted(merged, 'vertex', 'vertices')} into a neighbour at the same place"
    )


def without_seams(soup: TriangleSoup) -> TriangleSoup:
    """Merge vertices of the border that coincide, or nearly, where border lies along border.

    Where borders touch in single points, they stay as they are.
    """
    border = soup.edges.border
    cluster = _clusters(soup.places, border, soup.faces)
    if cluster is None:
        return soup
    into = _lowest(_sewn(soup.places, border, cluster))
    merged = int((into != np.arange(len(into))).sum())
    if not merged:
        return soup
    return soup.with_vertices_merged(into).noting(
        f"closed seams: merged {counted(merged, 'border vertex', 'border vertices')} into others"
        " at the same place"
    )


def _clusters(places: FloatArray, border: IntArray, faces: IntArray) -> IntArray | None:
    """(V,) number of the point at which each vertex lies; none if every border vertex is alone."""
    mine = np.unique(border)
    if not len(mine):
        return None
    exact = mine[groups_of_equal_rows((places[mine] + 0.0).T)]
    kinds = np.unique(exact)
    tree = KDTree(places[kinds])
    pairs = np.zeros((0, 2), dtype=np.int64)
    if not crowded(tree, places[kinds], SEAM, _MOST_PAIRS):
        pairs = kinds[tree.query_pairs(SEAM, output_type="ndarray")]
    reach = np.minimum(SEAM, _OF_AN_EDGE * _shortest_edges(places, faces))
    apart = np.linalg.norm(places[pairs[:, 0]] - places[pairs[:, 1]], axis=1)
    pairs = pairs[apart <= reach[pairs].min(axis=1)]
    if len(kinds) == len(mine) and not len(pairs):
        return None
    same = np.concatenate([np.stack([mine, exact], axis=1), pairs])
    return _components(same, len(places))


def _sewn(places: FloatArray, border: IntArray, cluster: IntArray) -> IntArray:
    """(V,) component of each vertex when border edges that lie on one another are joined."""
    a, b = border.T
    backwards = cluster[a] > cluster[b]
    a, b = np.where(backwards, b, a), np.where(backwards, a, b)
    order = np.lexsort((cluster[b], cluster[a]))
    a, b = a[order], b[order]
    same = (cluster[a][1:] == cluster[a][:-1]) & (cluster[b][1:] == cluster[b][:-1])
    same &= cluster[a][1:] != cluster[b][1:]
    joined = [np.stack([end[1:], end[:-1]], axis=1)[same] for end in (a, b)]
    so_far = _components(np.concatenate(joined), len(places))
    joined.append(_side_by_side(places, border, cluster, so_far))
    return _components(np.concatenate(joined), len(places))


def _side_by_side(
    places: FloatArray, border: IntArray, cluster: IntArray, joined: IntArray
) -> IntArray:
    """Pairs of coinciding vertices not joined so far from which border edges lead the same way."""
    least, most = np.full(len(places), len(places)), np.full(len(places), -1)
    np.minimum.at(least, cluster, joined)
    np.maximum.at(most, cluster, joined)
    torn = (least < most)[cluster]
    start = np.concatenate([border[:, 0], border[:, 1]])
    end = np.concatenate([border[:, 1], border[:, 0]])
    start, end = start[torn[start]], end[torn[start]]
    way = places[end] - places[start]
    way /= np.maximum(np.linalg.norm(way, axis=1, keepdims=True), np.finfo(float).tiny)
    order = np.argsort(cluster[start], kind="stable")
    start, way = start[order], way[order]
    pairs = [np.zeros((0, 2), dtype=np.int64)]
    # At a point where seams cross there are some dozen edges, in a fan of loose faces as well.
    for step in range(1, min(len(start), 32)):
        i, j = start[:-step], start[step:]
        near = (cluster[i] == cluster[j]) & (i != j)
        if not (cluster[i] == cluster[j]).any():
            break
        near[near] = (np.linalg.norm(way[:-step][near] - way[step:][near], axis=1)) < _ASKEW
        pairs.append(np.stack([i, j], axis=1)[near])
    return np.concatenate(pairs)


def _shortest_edges(places: FloatArray, faces: IntArray) -> FloatArray:
    """(V,) length of the shortest edge at each vertex."""
    shortest = np.full(len(places), np.inf)
    for side in ([0, 1], [1, 2], [2, 0]):
        i, j = faces[:, side].T
        lengths = np.linalg.norm(places[i] - places[j], axis=1)
        np.minimum.at(shortest, i, lengths)
        np.minimum.at(shortest, j, lengths)
    return shortest


def _components(pairs: IntArray, size: int) -> IntArray:
    links = sp.coo_array((np.ones(len(pairs), dtype=np.bool_), tuple(pairs.T)), shape=(size, size))
    return connected_components(links, directed=False)[1].astype(np.int64)


def _lowest(label: IntArray) -> IntArray:
    """(V,) the first vertex that has the same label."""
    _, first, inverse = np.unique(label, return_index=True, return_inverse=True)
    lowest: IntArray = first[inverse.reshape(-1)].astype(np.int64)
    return lowest
