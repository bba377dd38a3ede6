"""Triangle meshes: the discrete surfaces X and Y of section 2, read, checked and repaired."""

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components

from solver.arrays import FloatArray, IntArray
from solver.errors import MeshError
from solver.mesh.formats import READERS
from solver.mesh.repair import TriangleSoup, repaired

MESH_FORMATS: tuple[str, ...] = tuple(READERS)
"""File extensions that :func:`read_mesh` knows, lower case, without the dot."""


@dataclass(frozen=True, eq=False)
class TriangleMesh:
    """A triangulated surface, sound enough to compute on.

    Every vertex belongs to a face, every face has three distinct vertices and an area, no face
    occurs twice, all coordinates are finite, neighbouring faces are oriented alike unless the
    surface is one-sided. It may have boundaries, several components and non-manifold edges. Make
    one with :func:`triangle_mesh` or :func:`read_mesh`.

    Parameters
    ----------
    vertices
        (V, 3) positions in the user's units.
    faces
        (F, 3) vertex indices.
    vertex_ids
        (V,) the user's own number of each vertex, its 0-based index in the file.
    colors
        (V, 3) in 0..1, or ``None``.
    warnings
        What was repaired or assumed, in sentences for the user.
    merged
        (A, 2) the user's numbers of vertices that were merged into others, and of these.
    """

    vertices: FloatArray
    faces: IntArray
    vertex_ids: IntArray
    colors: FloatArray | None = None
    warnings: tuple[str, ...] = ()
    merged: IntArray = field(default_factory=lambda: np.zeros((0, 2), dtype=np.int64))

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
    def edges(self) -> IntArray:
        """(E, 2) the edges, each once, smaller vertex first, in lexicographic order."""
        return self._edge_census[0]

    @cached_property
    def closed(self) -> bool:
        """Whether the surface has no boundary: every edge belongs to two faces or more."""
        return bool((self._edge_census[1] > 1).all())

    @cached_property
    def components(self) -> int:
        """Number of connected components."""
        return int(self.component_of_vertex.max()) + 1

    @cached_property
    def component_of_vertex(self) -> IntArray:
        """(V,) component of each vertex, numbered from 0."""
        i, j = self.edges.T
        adjacency = sp.coo_array((np.ones(len(i)), (i, j)), shape=(self.n_vertices,) * 2)
        return connected_components(adjacency, directed=False)[1].astype(np.int64)

    @cached_property
    def _edge_census(self) -> tuple[IntArray, IntArray]:
        sides = np.sort(self.faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
        keys, counts = np.unique(sides[:, 0] * self.n_vertices + sides[:, 1], return_counts=True)
        return np.stack(np.divmod(keys, self.n_vertices), axis=1), counts.astype(np.int64)

    def vertices_of(self, ids: IntArray) -> IntArray:
        """Find vertices by the user's own numbers.

        Parameters
        ----------
        ids
            (K,) the user's vertex numbers.

        Returns
        -------
        (K,) int64, vertex indices of this mesh: for a number that was merged into another, that
        other's; -1 for a number that is not part of the mesh.
        """
        known, stands_for = self.numbering
        place = np.searchsorted(known, ids).clip(max=len(known) - 1)
        found: IntArray = np.where(known[place] == ids, stands_for[place], -1)
        return found

    @cached_property
    def numbering(self) -> tuple[IntArray, IntArray]:
        """(K,) user's numbers that are part of the mesh, ascending, and (K,) the vertex of each."""
        order = np.argsort(self.vertex_ids, kind="stable")
        place = np.searchsorted(self.vertex_ids[order], self.merged[:, 1])
        heirs = order[place.clip(max=len(order) - 1)]
        heirs = np.where(self.vertex_ids[heirs] == self.merged[:, 1], heirs, -1)
        ids = np.concatenate([self.vertex_ids, self.merged[:, 0]])
        vertices = np.concatenate([np.arange(self.n_vertices), heirs])
        by_id = np.argsort(ids, kind="stable")
        by_id = by_id[vertices[by_id] >= 0]
        return ids[by_id], vertices[by_id].astype(np.int64)

    def scaled(self, factor: float) -> "TriangleMesh":
        """Return the mesh with its centre at the origin and its lengths times `factor`."""
        return replace(self, vertices=(self.vertices - _centre(self.vertices)) * factor)


def read_mesh(data: bytes, file_type: str) -> TriangleMesh:
    """Read a mesh file.

    Vertices keep the numbers they have in the file, whatever normals and texture coordinates it
    has; formats that cannot share a vertex between faces (STL, glTF) have equal ones merged. What
    is repaired is what :func:`triangle_mesh` repairs.

    Parameters
    ----------
    data
        Bytes of the file.
    file_type
        One of `MESH_FORMATS`, in either case, with or without a dot.

    Returns
    -------
    TriangleMesh

    Raises
    ------
    MeshError
        The format is unknown, the file is not a complete file of that format, or there is no
        sound surface in it.
    """
    kind = file_type.lower().lstrip(".")
    if kind not in READERS:
        raise MeshError(f"unknown mesh format {kind[:20]!r}; use one of {', '.join(MESH_FORMATS)}")
    if not data:
        raise MeshError("the file is empty")
    try:
        contents = READERS[kind](data)
    except MemoryError:
        raise MeshError("the file is too large to be read in the memory there is") from None
    return _checked(contents)


def triangle_mesh(
    vertices: FloatArray, faces: IntArray, colors: FloatArray | None = None
) -> TriangleMesh:
    """Make a mesh of arrays: check them, and repair what can be repaired.

    Repeated vertices, faces and parts of the surface are merged, seams and cracks closed, faces
    without area dropped and the others turned alike; see :mod:`.repair`. `warnings` of the
    mesh says so and `vertex_ids` keeps the numbers of the vertices given.

    Parameters
    ----------
    vertices
        (V, 3) positions.
    faces
        (F, 3) indices of vertices, from 0.
    colors
        (V, 3) in 0..1, or ``None``.

    Returns
    -------
    TriangleMesh

    Raises
    ------
    MeshError
        Shapes are wrong, a coordinate is not finite, an index names no vertex, or nothing with an
        area is left.
    """
    points = np.asarray(vertices, dtype=np.float64)
    corners = np.asarray(faces)
    if corners.size and not np.issubdtype(corners.dtype, np.integer):
        raise MeshError("faces must be integers")
    if points.ndim != 2 or points.shape[1] != 3:
        raise MeshError(f"vertices must be a (V, 3) array, not one of shape {points.shape}")
    if corners.size and (corners.ndim != 2 or corners.shape[1] != 3):
        raise MeshError(f"faces must be an (F, 3) array, not one of shape {corners.shape}")
    if colors is not None and np.shape(colors) != points.shape:
        raise MeshError("colors must be a (V, 3) array with a row for every vertex")
    triangles = corners.astype(np.int64).reshape(-1, 3)
    return _checked(TriangleSoup(points, triangles, colors, np.arange(len(points), dtype=np.int64)))


def largest_component(mesh: TriangleMesh) -> TriangleMesh:
    """Keep the connected component of largest area.

    Parameters
    ----------
    mesh
        Any mesh.

    Returns
    -------
    TriangleMesh
        `mesh` itself if it is connected; else the component, with a warning that says what was
        left out. `vertex_ids` keeps the user's numbers.
    """
    if mesh.components == 1:
        return mesh
    label = mesh.component_of_vertex[mesh.faces[:, 0]]
    areas = np.bincount(label, weights=triangle_areas(mesh.vertices, mesh.faces))
    largest = int(np.argmax(areas))
    share = areas[largest] / areas.sum()
    note = (
        f"only the largest of {mesh.components} components was kept: "
        f"{100.0 * share:.3g} % of the area"
    )
    soup = TriangleSoup(
        mesh.vertices,
        mesh.faces[label == largest],
        mesh.colors,
        mesh.vertex_ids,
        (*mesh.warnings, note),
        mesh.merged,
    )
    return _mesh(soup.compacted())


def triangle_areas(vertices: FloatArray, faces: IntArray) -> FloatArray:
    """Areas of triangles.

    Parameters
    ----------
    vertices
        (V, 3).
    faces
        (F, 3).

    Returns
    -------
    (F,) float64
    """
    a, b, c = (vertices[faces[:, corner]] for corner in range(3))
    areas: FloatArray = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)
    return areas


def _centre(vertices: FloatArray) -> FloatArray:
    centre: FloatArray = 0.5 * (vertices.min(axis=0) + vertices.max(axis=0))
    return centre


def _checked(soup: TriangleSoup) -> TriangleMesh:
    if not len(soup.vertices):
        raise MeshError("the mesh has no vertices")
    if not len(soup.faces):
        raise MeshError("the mesh has no faces; a point cloud cannot be matched")
    if soup.faces.min() < 0 or soup.faces.max() >= len(soup.vertices):
        raise MeshError(f"a face refers to a vertex outside 0..{len(soup.vertices) - 1}")
    return _mesh(repaired(soup))


def _mesh(soup: TriangleSoup) -> TriangleMesh:
    return TriangleMesh(
        np.ascontiguousarray(soup.vertices, dtype=np.float64),
        soup.faces,
        soup.vertex_ids,
        None if soup.colors is None else np.ascontiguousarray(soup.colors, dtype=np.float64),
        soup.notes,
        soup.merged,
    )
