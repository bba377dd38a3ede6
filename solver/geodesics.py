"""Geodesic distances along a mesh, section 3.2: shortest paths in a graph of straight segments.

The graph has the mesh's edges and, across each of them, the segment between the two opposite
corners in the plane into which both triangles unfold, wherever that segment stays inside the two
triangles. All its paths lie on the surface, so its distances are never too short; they are too
long by 2 to 3 % on average on irregular meshes, where edges alone err by 7 %.
"""

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import dijkstra

from solver.arrays import FloatArray, IntArray
from solver.mesh import TriangleMesh


class GeodesicGraph:
    """Shortest paths between vertices over edges and unfolded flip edges.

    Parameters
    ----------
    mesh
        Any mesh.
    """

    def __init__(self, mesh: TriangleMesh) -> None:
        edges, edge_lengths = mesh.edges, _lengths(mesh.vertices, mesh.edges)
        flips, flip_lengths = _flip_edges(mesh)
        ends = np.concatenate([edges, flips])
        lengths = np.concatenate([edge_lengths, flip_lengths])
        # A pair can be joined by an edge and by a flip, or by several flips: the shortest counts.
        order = np.lexsort((lengths, ends[:, 1], ends[:, 0]))
        ends, lengths = ends[order], lengths[order]
        first = np.ones(len(ends), dtype=np.bool_)
        first[1:] = (ends[1:] != ends[:-1]).any(axis=1)
        i, j = ends[first].T
        weights = np.concatenate([lengths[first]] * 2)
        size = mesh.n_vertices
        self._graph = sp.csr_array(
            sp.coo_array((weights, (np.r_[i, j], np.r_[j, i])), shape=(size, size))
        )

    @property
    def n_vertices(self) -> int:
        """Number V of vertices."""
        return int(self._graph.shape[0])

    def distances(self, sources: IntArray) -> FloatArray:
        """Geodesic distances from some vertices to all.

        Parameters
        ----------
        sources
            (S,) vertex indices.

        Returns
        -------
        (S, V) float64, in the mesh's unit of length; ``inf`` between components. O(S V log V).
        """
        found: FloatArray = np.asarray(
            dijkstra(self._graph, directed=True, indices=np.asarray(sources, dtype=np.int64))
        )
        return found.reshape(-1, self.n_vertices)


def _lengths(vertices: FloatArray, ends: IntArray) -> FloatArray:
    lengths: FloatArray = np.linalg.norm(vertices[ends[:, 0]] - vertices[ends[:, 1]], axis=1)
    return lengths


def _flip_edges(mesh: TriangleMesh) -> tuple[IntArray, FloatArray]:
    """Segments between corners opposite an edge, through it, and their lengths in the plane."""
    i, j, a, b = _hinges(mesh).T
    base = _lengths(mesh.vertices, np.stack([i, j], axis=1))
    along_a, height_a = _apex(mesh.vertices, i, j, a, base)
    along_b, height_b = _apex(mesh.vertices, i, j, b, base)
    heights = height_a + height_b
    crossing = (along_a * height_b + along_b * height_a) / heights
    inside = (a != b) & (crossing > 0.0) & (crossing < base)
    ends = np.sort(np.stack([a, b], axis=1)[inside], axis=1)
    return ends, np.hypot(along_a - along_b, heights)[inside]


def _hinges(mesh: TriangleMesh) -> IntArray:
    """(H, 4) edges i, j with the corners a, b opposite them in two triangles.

    Of the triangles round a non-manifold edge, each is paired with the next in order of index.
    """
    sides = np.concatenate([mesh.faces[:, [1, 2, 0]], mesh.faces[:, [2, 0, 1]], mesh.faces])
    ends = np.sort(sides[:, :2], axis=1)
    order = np.lexsort((sides[:, 2], ends[:, 1], ends[:, 0]))
    ends, opposite = ends[order], sides[order, 2]
    shared = (ends[1:] == ends[:-1]).all(axis=1)
    hinges: IntArray = np.column_stack([ends[1:], opposite[:-1], opposite[1:]])[shared]
    return hinges


def _apex(
    vertices: FloatArray, i: IntArray, j: IntArray, apex: IntArray, base: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Coordinates of triangles' third corners: along the edge from i to j, and above it."""
    direction = (vertices[j] - vertices[i]) / base[:, None]
    arm = vertices[apex] - vertices[i]
    along = np.einsum("ij,ij->i", arm, direction)
    height: FloatArray = np.linalg.norm(arm - along[:, None] * direction, axis=1)
    return along, height
