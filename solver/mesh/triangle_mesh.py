"""Triangle meshes: the surfaces X and Y of section 2."""

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
import scipy.sparse as sp

from solver.arrays import BoolArray, FloatArray, IntArray
from solver.mesh.edges import Edges, components_of, edges_of, fans_of
from solver.mesh.links import component_links
from solver.mesh.normals import triangle_areas
from solver.mesh.repair import TriangleSoup

_HOLE_LENGTH, _HOLE_EDGES = 0.1, 3
"""Length over √area, or number of edges, of the boundary of a small hole: less than the girth of a
wrist, or a missing triangle."""


@dataclass(frozen=True, eq=False)
class TriangleMesh:
    """A triangulated surface that can be computed on.

    Every vertex belongs to a face, every face has three distinct vertices and an area, no face
    occurs twice, all coordinates are finite, and the winding is consistent unless the surface is
    not orientable. It may have boundaries, several components and non-manifold edges. Made by
    :func:`.triangle_mesh` or :func:`.read_mesh`.

    Parameters
    ----------
    vertices
        (V, 3) positions in the user's units.
    faces
        (F, 3) int64 vertex indices.
    vertex_ids
        (V,) int64, the user's number of each vertex: its index in the file, from 0.
    colors
        (V, 3) in 0..1, or ``None``.
    warnings
        Repairs and assumptions, in sentences for the user.
    merged
        (A, 2) int64, the user's numbers: of a vertex that was merged into another, and of that
        other.
    face_ids
        (F,) int64, the user's number of the face that each triangle is part of: its index in the
        file, from 0, where a polygon is one face; ``None`` if it is not known.
    file_rows
        Numbers of vertices and of faces of the file; ``None`` if they are not known.
    is_cloud
        Whether the file has points alone, and the faces were made of them.
    """

    vertices: FloatArray
    faces: IntArray
    vertex_ids: IntArray
    colors: FloatArray | None = None
    warnings: tuple[str, ...] = ()
    merged: IntArray = field(default_factory=lambda: np.zeros((0, 2), dtype=np.int64))
    face_ids: IntArray | None = None
    file_rows: tuple[int, int] | None = None
    is_cloud: bool = False

    @staticmethod
    def of(soup: TriangleSoup) -> "TriangleMesh":
        """Make a mesh of a soup that needs no repair."""
        mesh = TriangleMesh(
            np.ascontiguousarray(soup.vertices, dtype=np.float64),
            soup.faces,
            soup.vertex_ids,
            None if soup.colors is None else np.ascontiguousarray(soup.colors, dtype=np.float64),
            soup.notes,
            soup.merged,
            soup.face_ids,
            soup.file_rows,
            soup.is_cloud,
        )
        if "edges" in vars(soup):
            vars(mesh)["face_edges"] = soup.edges
        return mesh

    def soup(self) -> TriangleSoup:
        """Return the mesh as a soup that can be changed."""
        return TriangleSoup(
            self.vertices,
            self.faces,
            self.colors,
            self.vertex_ids,
            self.face_ids,
            self.warnings,
            self.merged,
            is_cloud=self.is_cloud,
            file_rows=self.file_rows,
        )

    @property
    def n_vertices(self) -> int:
        """Number V of vertices."""
        return len(self.vertices)

    @property
    def n_faces(self) -> int:
        """Number F of faces."""
        return len(self.faces)

    @cached_property
    def area(self) -> float:
        """Surface area, in the user's units squared."""
        return float(triangle_areas(self.vertices, self.faces).sum())

    @cached_property
    def volume(self) -> float:
        """Volume that a closed surface encloses, in the user's units cubed; meaningless for others.

        Of components whose triangles are wound inwards it is negative.
        """
        a, b, c = (self.vertices[corner] for corner in self.faces.T)
        return float(np.einsum("ij,ij->", a, np.cross(b, c))) / 6.0

    @cached_property
    def edges(self) -> IntArray:
        """(E, 2) the edges, each once, smaller vertex first, in lexicographic order."""
        return self.face_edges.ends

    @cached_property
    def mean_edge(self) -> float:
        """Mean length of the edges, in the user's units."""
        return float(self._lengths(self.edges).mean())

    @cached_property
    def closed(self) -> bool:
        """Whether the surface has no boundary: every edge belongs to two faces or more."""
        return not len(self.face_edges.boundary)

    @cached_property
    def on_boundary(self) -> BoolArray:
        """(V,) whether a vertex lies on the boundary: on an edge of a single face."""
        found = np.zeros(self.n_vertices, dtype=np.bool_)
        found[self.face_edges.boundary.ravel()] = True
        return found

    @cached_property
    def on_cut(self) -> BoolArray:
        """(V,) whether a vertex lies on a piece of the boundary where the surface may be cut off.

        All but small holes: pieces of three edges, and those shorter than a tenth of √area.
        """
        found = np.zeros(self.n_vertices, dtype=np.bool_)
        found[self._cuts[0].ravel()] = True
        return found

    @property
    def relative_boundary(self) -> float:
        """Length of the boundary over √area, without small holes as in `on_cut`."""
        return float(self._cuts[1].sum() / self.area**0.5)

    @property
    def longest_cut(self) -> float:
        """Length of the longest piece of the boundary over √area; 0 with small holes alone."""
        return float(self._cuts[1].max(initial=0.0) / self.area**0.5)

    @cached_property
    def _cuts(self) -> tuple[IntArray, FloatArray]:
        """(E, 2) edges of the boundary, and (P,) lengths of its pieces, without small holes."""
        rims = self.face_edges.boundary
        piece = components_of(rims, self.n_vertices)[rims[:, 0]]
        lengths = np.bincount(piece, self._lengths(rims))
        cuts = (lengths >= _HOLE_LENGTH * self.area**0.5) & (np.bincount(piece) > _HOLE_EDGES)
        return rims[cuts[piece]], lengths[cuts]

    def _lengths(self, edges: IntArray) -> FloatArray:
        """(E,) lengths of (E, 2) edges."""
        ends = self.vertices[edges]
        found: FloatArray = np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1)
        return found

    @cached_property
    def genus(self) -> float:
        """Number of handles, once every boundary is filled by a disc.

        That of the Euler characteristic V − E + F = 2 (C − g) of C components. A vertex counts once
        for each of its fans, as if they did not touch. Where three faces share an edge it may be
        half a number, or negative.
        """
        fans = fans_of(self.faces, self.face_edges)
        count = int(fans.max()) + 1
        face, side = self.face_edges.boundary_sides
        rims = np.stack([fans[face, side], fans[face, (side + 1) % 3]], axis=1)
        discs = len(np.unique(components_of(rims, count)[rims]))
        parts = int(components_of(np.concatenate([fans[:, :2], fans[:, 1:]]), count).max()) + 1
        return parts - 0.5 * (count - len(self.edges) + self.n_faces + discs)

    @cached_property
    def components(self) -> int:
        """Number of connected components."""
        return int(self.component_of_vertex.max()) + 1

    @cached_property
    def component_of_vertex(self) -> IntArray:
        """(V,) component of each vertex, numbered from 0."""
        return components_of(self.edges, self.n_vertices)

    @cached_property
    def links(self) -> IntArray:
        """(L, 2) vertices linked over the gaps between components: edges without faces.

        Empty if there is one component. See :func:`.component_links`.
        """
        if self.components == 1:
            return np.zeros((0, 2), dtype=np.int64)
        return component_links(self.vertices, self.component_of_vertex, self.mean_edge, self.on_cut)

    @cached_property
    def neighbours(self) -> tuple[IntArray, IntArray]:
        """Neighbours of vertex v, over edges and links: ``second[first[v]:first[v + 1]]``."""
        return _adjacency(np.concatenate([self.edges, self.links]), self.n_vertices)

    @cached_property
    def edge_neighbours(self) -> tuple[IntArray, IntArray]:
        """Neighbours of vertex v over edges alone: ``second[first[v]:first[v + 1]]``."""
        return self.neighbours if self.components == 1 else _adjacency(self.edges, self.n_vertices)

    @cached_property
    def incident_faces(self) -> tuple[IntArray, IntArray]:
        """Triangles round vertex v are ``second[first[v]:first[v + 1]]``."""
        corners = self.faces.ravel()
        counts = np.bincount(corners, minlength=self.n_vertices)
        first = np.concatenate([[0], np.cumsum(counts)]).astype(np.int64)
        return first, np.argsort(corners, kind="stable") // 3

    def at_vertices(self, vertices: IntArray) -> tuple[IntArray, FloatArray]:
        """Return vertices as points of triangles.

        Parameters
        ----------
        vertices
            (N,) vertices. Of the triangles that share one, the first is taken.

        Returns
        -------
        (N,) triangles and (N, 3) barycentric coordinates.
        """
        first, incident = self.incident_faces
        faces = incident[first[vertices]]
        return faces, (self.faces[faces] == vertices[:, None]).astype(np.float64)

    @cached_property
    def face_edges(self) -> Edges:
        """The edges, with the faces at them."""
        return edges_of(self.faces)

    def vertices_of(self, ids: IntArray) -> IntArray:
        """Find vertices by the user's own numbers.

        Parameters
        ----------
        ids
            (K,) the user's vertex numbers.

        Returns
        -------
        (K,) int64 vertex indices of this mesh; of a vertex that was merged, the one it was merged
        into; -1 for a number that is not part of the mesh.
        """
        known, stands_for = self.numbering
        place = np.searchsorted(known, ids).clip(max=len(known) - 1)
        found: IntArray = np.where(known[place] == ids, stands_for[place], -1)
        return found

    @cached_property
    def numbering(self) -> tuple[IntArray, IntArray]:
        """(K,) user's numbers in the mesh, merged ones too, ascending, and (K,) their vertices."""
        order = np.argsort(self.vertex_ids, kind="stable")
        place = np.searchsorted(self.vertex_ids[order], self.merged[:, 1])
        heirs = order[place.clip(max=len(order) - 1)]
        heirs = np.where(self.vertex_ids[heirs] == self.merged[:, 1], heirs, -1)
        ids = np.concatenate([self.vertex_ids, self.merged[:, 0]])
        vertices = np.concatenate([np.arange(self.n_vertices), heirs])
        by_id = np.argsort(ids, kind="stable")
        by_id = by_id[vertices[by_id] >= 0]
        return ids[by_id], vertices[by_id].astype(np.int64)

    @property
    def vertex_rows(self) -> int:
        """Rows of values of vertices: those of its file, or as many as have the user's numbers."""
        return int(self.numbering[0][-1]) + 1 if self.file_rows is None else self.file_rows[0]

    def scaled(self, factor: float) -> "TriangleMesh":
        """Return the mesh with its centre at the origin and its lengths times `factor`."""
        centre = 0.5 * (self.vertices.min(axis=0) + self.vertices.max(axis=0))
        return self.with_same_faces(vertices=(self.vertices - centre) * factor)

    def with_same_faces(self, **changes: Any) -> "TriangleMesh":
        """Return the mesh with other fields changed, and what is known of its faces kept.

        Vertices may be moved, reflected and scaled, all together.
        """
        found = replace(self, **changes)
        known = vars(self)
        vars(found).update({name: known[name] for name in _OF_FACES if name in known})
        return found


_OF_FACES = (
    "face_edges",
    "edges",
    "closed",
    "on_boundary",
    "genus",
    "components",
    "component_of_vertex",
    "links",
    "neighbours",
    "edge_neighbours",
    "incident_faces",
)
"""Properties that depend on nothing but faces, and links, which are the same at any scale."""


def _adjacency(pairs: IntArray, count: int) -> tuple[IntArray, IntArray]:
    """Rows of the symmetric adjacency of (E, 2) pairs of so many vertices."""
    i, j = pairs.T
    ends = sp.csr_array(
        (np.ones(2 * len(i)), (np.concatenate([i, j]), np.concatenate([j, i]))),
        shape=(count, count),
    )
    return ends.indptr.astype(np.int64), ends.indices.astype(np.int64)
