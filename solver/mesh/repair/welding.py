"""Welding: merging vertices that are one point of the surface but several in the file.

Programs repeat vertices along the seams of textures and normals, or store every face by itself. To
a Laplacian or a geodesic, such a seam is a cut.
"""

from dataclasses import replace

import numpy as np
from scipy.spatial import KDTree

from solver.arrays import FloatArray, IntArray
from solver.mesh.edges import components_of
from solver.mesh.repair.boundary import denser_than
from solver.mesh.repair.soup import TriangleSoup, counted, groups_of_equal_rows

_SEAM = 1e-5
"""Largest distance between vertices that a seam separates, in extents of the shape."""

_SEAM_OF_EDGE = 0.1
"""The same in lengths of the shortest edge at either vertex, so that small faces survive."""

_SHORT_EDGE = 1e-7
"""Length of edges that are collapsed, in extents of the shape: about the resolution of single
precision (1.2e-7)."""

_MOST_PAIRS = 64
"""Near boundary vertices of a boundary vertex, on average; where there are more, only vertices in
exactly the same position are welded."""

_PARALLEL = 1e-3
"""Distance between unit vectors along two boundary edges that coincide, about the sine of the
angle between them."""

_MOST_EDGES = 32
"""Boundary edges compared at a point where seams cross; there are some dozen, in a fan of loose
faces too."""


def merge_coincident(soup: TriangleSoup, reason: str) -> TriangleSoup:
    """Merge vertices of exactly equal position.

    Parameters
    ----------
    soup
        Vertices and faces of the file.
    reason
        Why vertices are repeated: the beginning of the note for the user.

    Returns
    -------
    TriangleSoup
        Vertices in the order of their first appearance, whose index is in `vertex_ids`.
    """
    into = groups_of_equal_rows((soup.vertices + 0.0).T)  # -0.0 equals 0.0
    before = len(into)
    merged = soup.with_vertices_merged(into)
    kept = into == np.arange(before)
    after = int(kept.sum())
    if after == before:
        return soup
    number = np.cumsum(kept) - 1
    return replace(
        merged,
        vertices=soup.vertices[kept],
        faces=number[merged.faces].astype(np.int64),
        colors=None if merged.colors is None else merged.colors[kept],
        vertex_ids=soup.vertex_ids[kept],
    ).noting(f"{reason}: {before} vertices were merged into {after}")


def without_duplicate_parts(soup: TriangleSoup) -> TriangleSoup:
    """Drop connected parts of the surface that coincide with another part: copies, back faces.

    Parts are connected over shared vertices. Single faces repeated on the same vertices are dropped
    as degenerate: see ``degenerate``.
    """
    place = groups_of_equal_rows((soup.vertices + 0.0).T)  # -0.0 equals 0.0
    if len(np.unique(place)) == len(place):
        return soup
    corners = np.sort(place[soup.faces], axis=1)
    part = soup.component_of_face
    by_part = np.argsort(part, kind="stable")
    first = np.empty(len(corners), dtype=np.int64)
    first[by_part] = by_part[groups_of_equal_rows(corners[by_part].T)]
    copied = part[first] != part
    keep = np.bincount(part, weights=~copied)[part] > 0
    if keep.all():
        return soup
    # Vertices of dropped parts are merged into those of the part that is kept.
    stays = np.zeros(len(place), dtype=np.bool_)
    stays[soup.faces[keep]] = True
    gone = np.zeros(len(place), dtype=np.bool_)
    gone[soup.faces[~keep]] = True
    representative = np.full(len(place), -1)
    staying = np.flatnonzero(stays)[::-1]
    representative[place[staying]] = staying
    into = np.where(gone, representative[place], np.arange(len(place)))
    return soup.with_faces(keep, "coinciding with others").with_vertices_merged(into)


def without_short_edges(soup: TriangleSoup) -> TriangleSoup:
    """Collapse edges of nearly zero length: needles vanish, and their neighbours close up."""
    positions = soup.unit_positions
    ends = soup.edges.ends
    lengths = np.linalg.norm(positions[ends[:, 0]] - positions[ends[:, 1]], axis=1)
    into = _lowest(components_of(ends[lengths <= _SHORT_EDGE], len(positions)))
    merged = int((into != np.arange(len(into))).sum())
    if not merged:
        return soup
    return soup.with_vertices_merged(into).noting(
        f"merged {counted(merged, 'vertex', 'vertices')} into a neighbour at the same position"
    )


def without_seams(soup: TriangleSoup) -> TriangleSoup:
    """Weld boundary vertices that coincide, or nearly, where boundary edges coincide.

    Boundaries that touch in single points stay apart.
    """
    boundary = soup.edges.boundary
    cluster = _clusters(soup.unit_positions, boundary, soup.faces)
    if cluster is None:
        return soup
    into = _lowest(_welded(soup.unit_positions, boundary, cluster))
    merged = int((into != np.arange(len(into))).sum())
    if not merged:
        return soup
    return soup.with_vertices_merged(into).noting(
        f"closed seams: merged {counted(merged, 'boundary vertex', 'boundary vertices')} into"
        " others at the same position"
    )


def _clusters(positions: FloatArray, boundary: IntArray, faces: IntArray) -> IntArray | None:
    """(V,) label shared by boundary vertices in one position; ``None`` if each is alone there."""
    mine = np.unique(boundary)
    if not len(mine):
        return None
    exact = mine[groups_of_equal_rows((positions[mine] + 0.0).T)]
    kinds = np.unique(exact)
    tree = KDTree(positions[kinds])
    pairs = np.zeros((0, 2), dtype=np.int64)
    if not denser_than(tree, positions[kinds], _SEAM, _MOST_PAIRS):
        pairs = kinds[tree.query_pairs(_SEAM, output_type="ndarray")]
    reach = np.minimum(_SEAM, _SEAM_OF_EDGE * _shortest_edges(positions, faces))
    apart = np.linalg.norm(positions[pairs[:, 0]] - positions[pairs[:, 1]], axis=1)
    pairs = pairs[apart <= reach[pairs].min(axis=1)]
    if len(kinds) == len(mine) and not len(pairs):
        return None
    same = np.concatenate([np.stack([mine, exact], axis=1), pairs])
    return components_of(same, len(positions))


def _welded(positions: FloatArray, boundary: IntArray, cluster: IntArray) -> IntArray:
    """(V,) component of each vertex when boundary edges that coincide are joined."""
    a, b = boundary.T
    backwards = cluster[a] > cluster[b]
    a, b = np.where(backwards, b, a), np.where(backwards, a, b)
    order = np.lexsort((cluster[b], cluster[a]))
    a, b = a[order], b[order]
    same = (cluster[a][1:] == cluster[a][:-1]) & (cluster[b][1:] == cluster[b][:-1])
    same &= cluster[a][1:] != cluster[b][1:]
    joined = [np.stack([end[1:], end[:-1]], axis=1)[same] for end in (a, b)]
    so_far = components_of(np.concatenate(joined), len(positions))
    joined.append(_parallel_pairs(positions, boundary, cluster, so_far))
    return components_of(np.concatenate(joined), len(positions))


def _parallel_pairs(
    positions: FloatArray, boundary: IntArray, cluster: IntArray, joined: IntArray
) -> IntArray:
    """(n, 2) coinciding vertices, not joined so far, from which boundary edges run in parallel."""
    least, most = np.full(len(positions), len(positions)), np.full(len(positions), -1)
    np.minimum.at(least, cluster, joined)
    np.maximum.at(most, cluster, joined)
    torn = (least < most)[cluster]
    start = np.concatenate([boundary[:, 0], boundary[:, 1]])
    end = np.concatenate([boundary[:, 1], boundary[:, 0]])
    start, end = start[torn[start]], end[torn[start]]
    way = positions[end] - positions[start]
    way /= np.maximum(np.linalg.norm(way, axis=1, keepdims=True), np.finfo(float).tiny)
    order = np.argsort(cluster[start], kind="stable")
    start, way = start[order], way[order]
    pairs = [np.zeros((0, 2), dtype=np.int64)]
    for step in range(1, min(len(start), _MOST_EDGES)):
        i, j = start[:-step], start[step:]
        near = (cluster[i] == cluster[j]) & (i != j)
        if not (cluster[i] == cluster[j]).any():
            break
        near[near] = (np.linalg.norm(way[:-step][near] - way[step:][near], axis=1)) < _PARALLEL
        pairs.append(np.stack([i, j], axis=1)[near])
    return np.concatenate(pairs)


def _shortest_edges(positions: FloatArray, faces: IntArray) -> FloatArray:
    """(V,) length of the shortest edge at each vertex."""
    shortest = np.full(len(positions), np.inf)
    for side in ([0, 1], [1, 2], [2, 0]):
        i, j = faces[:, side].T
        lengths = np.linalg.norm(positions[i] - positions[j], axis=1)
        np.minimum.at(shortest, i, lengths)
        np.minimum.at(shortest, j, lengths)
    return shortest


def _lowest(label: IntArray) -> IntArray:
    """(V,) the first vertex that has the same label."""
    _, first, inverse = np.unique(label, return_index=True, return_inverse=True)
    lowest: IntArray = first[inverse.reshape(-1)].astype(np.int64)
    return lowest
