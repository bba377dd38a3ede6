"""Triangle meshes: the discrete surfaces X and Y of section 2, read, checked and repaired."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components

from solver.arrays import BoolArray, FloatArray, IntArray
from solver.errors import MeshError
from solver.mesh_formats import READERS

MESH_FORMATS: tuple[str, ...] = tuple(READERS)
"""File extensions that :func:`read_mesh` knows, lower case, without the dot."""

_FLAT = 1e-14
"""Twice a triangle's area over its longest edge squared, below which it has no area to speak of:
some tens of rounding errors."""


@dataclass(frozen=True, eq=False)
class TriangleMesh:
    """A triangulated surface, sound enough to compute on.

    Every vertex belongs to a face, every face has three distinct vertices and an area, no face
    occurs twice, all coordinates are finite. It may have boundaries, several components and
    non-manifold edges. Make one with :func:`triangle_mesh` or :func:`read_mesh`.

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
    """

    vertices: FloatArray
    faces: IntArray
    vertex_ids: IntArray
    colors: FloatArray | None = None
    warnings: tuple[str, ...] = ()

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

    def scaled(self, factor: float) -> "TriangleMesh":
        """Return the mesh with its centre at the origin and its lengths times `factor`."""
        return replace(self, vertices=(self.vertices - _centre(self.vertices)) * factor)


def read_mesh(data: bytes, file_type: str) -> TriangleMesh:
    """Read a mesh file.

    Vertices keep the numbers they have in the file, whatever normals and texture coordinates it
    has; formats that cannot share a vertex between faces (STL, glTF) have equal ones merged.

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
    mesh = _checked(
        contents.vertices, contents.faces, contents.vertex_ids, contents.colors, contents.notes
    )
    return replace(mesh, warnings=(*mesh.warnings, *_seam_note(mesh)))


def triangle_mesh(
    vertices: FloatArray, faces: IntArray, colors: FloatArray | None = None
) -> TriangleMesh:
    """Make a mesh of arrays: check them, and repair what can be repaired.

    Faces that repeat a vertex or have no area, faces that occur twice (in either orientation) and
    vertices of no face are dropped; `warnings` of the mesh says so and `vertex_ids` keeps the
    numbers of the vertices given.

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
    return _checked(
        points, corners.astype(np.int64).reshape(-1, 3), np.arange(len(points)), colors, ()
    )


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
    return _compacted(
        mesh.vertices,
        mesh.faces[label == largest],
        mesh.vertex_ids,
        mesh.colors,
        (*mesh.warnings, note),
    )


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


def _checked(
    vertices: FloatArray,
    faces: IntArray,
    vertex_ids: IntArray,
    colors: FloatArray | None,
    notes: Sequence[str],
) -> TriangleMesh:
    if not len(vertices):
        raise MeshError("the mesh has no vertices")
    if not np.isfinite(vertices).all():
        bad = int(np.argmin(np.isfinite(vertices).all(axis=1)))
        raise MeshError(f"vertex {bad} has a coordinate that is not a finite number")
    if not len(faces):
        raise MeshError("the mesh has no faces; a point cloud cannot be matched")
    if faces.min() < 0 or faces.max() >= len(vertices):
        raise MeshError(f"a face refers to a vertex outside 0..{len(vertices) - 1}")
    notes = list(notes)
    sound = _sound_faces(vertices, faces, notes)
    if not sound.any():
        raise MeshError("no face has an area: all of them are degenerate")
    unused = len(vertices) - len(np.unique(faces[sound]))
    if unused:
        notes.append(f"{unused} vertices that belong to no face were dropped")
    mesh = _compacted(vertices, faces[sound], vertex_ids, colors, notes)
    if not 0.0 < mesh.area < np.inf:
        raise MeshError("the coordinates are too large or too small for an area to be computed")
    return mesh


def _seam_note(mesh: TriangleMesh) -> tuple[str, ...]:
    """Warn of borders that lie on one another: the surface may be meant to be whole there."""
    edges, counts = mesh._edge_census
    border = mesh.vertices[np.unique(edges[counts == 1])]
    coinciding = len(border) - len(np.unique(border, axis=0))
    if not coinciding:
        return ()
    return (
        f"{coinciding} border vertices lie exactly on others; the surface is cut there, "
        "merge them if it should not be",
    )


def _sound_faces(vertices: FloatArray, faces: IntArray, notes: list[str]) -> BoolArray:
    """Mark the faces that have an area and occur for the first time; note what the others are."""
    extent = np.ptp(vertices, axis=0).max()
    if not 0.0 < extent < np.inf:
        raise MeshError("the mesh has no extent: its vertices coincide, or are too far apart")
    unit = (vertices - _centre(vertices)) / extent
    a, b, c = (unit[faces[:, corner]] for corner in range(3))
    longest = np.max([((p - q) ** 2).sum(axis=1) for p, q in ((a, b), (b, c), (c, a))], axis=0)
    repeated = (np.sort(faces, axis=1)[:, 1:] == np.sort(faces, axis=1)[:, :-1]).any(axis=1)
    flat = ~repeated & (2.0 * triangle_areas(unit, faces) <= _FLAT * longest)
    sound = ~(repeated | flat)
    first = np.zeros(len(faces), dtype=np.bool_)
    first[np.unique(np.sort(faces, axis=1), axis=0, return_index=True)[1]] = True
    twice = sound & ~first
    for bad, what in (
        (repeated, "that use a vertex twice"),
        (flat, "without area"),
        (twice, "that occur twice"),
    ):
        if bad.any():
            notes.append(f"{int(bad.sum())} faces {what} were dropped")
    kept: BoolArray = sound & first
    return kept


def _compacted(
    vertices: FloatArray,
    faces: IntArray,
    vertex_ids: IntArray,
    colors: FloatArray | None,
    notes: Sequence[str],
) -> TriangleMesh:
    """Drop the vertices that no face uses."""
    used = np.zeros(len(vertices), dtype=np.bool_)
    used[faces] = True
    number = np.cumsum(used) - 1
    return TriangleMesh(
        np.ascontiguousarray(vertices[used]),
        number[faces].astype(np.int64),
        vertex_ids[used].astype(np.int64),
        None if colors is None else np.ascontiguousarray(colors[used], dtype=np.float64),
        tuple(notes),
    )
