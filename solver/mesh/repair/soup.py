"""Triangle soups: vertices and triangles of a file, before and during repair."""

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from solver.arrays import BoolArray, FloatArray, IntArray
from solver.errors import MeshError
from solver.mesh.edges import Edges, components_of, edges_of
from solver.mesh.repair.boundary import Boundary, boundary_of
from solver.mesh.textures import Paint

_LARGEST = 1e64
"""Largest extent, and the inverse of the least: the fourth power of a length stays well within
double precision (1e±308)."""

_FARTHEST = 1e300
"""Largest coordinate: sums of all stay within double precision."""


@dataclass(frozen=True, eq=False)
class TriangleSoup:
    """Vertices and triangles, not yet checked or repaired.

    Parameters
    ----------
    vertices
        (V, 3).
    faces
        (F, 3) indices of vertices.
    colors
        (V, 3) in 0..1, or ``None``.
    vertex_ids
        (V,) number of each vertex in the file, from 0.
    face_ids
        (F,) number of the file's face that each triangle is, or was cut from, from 0; ``None`` if
        it is not known.
    notes
        What was changed so far, in sentences for the user.
    merged
        (A, 2) numbers in the file: of a vertex that was merged into another, and of that other.
    paint
        Textures of the faces as a reader left them; repairs begin without.
    normals
        (V, 3) normals of a point cloud as a reader left them.
    is_cloud
        Whether the file is a point cloud: it has no faces, and does not mean to.
    file_rows
        Numbers of vertices and of faces of the file; ``None`` before repair.
    fixed_point
        Whether the file has coordinates as integers, scaled by a constant: they are as precise far
        from the origin as near it.
    """

    vertices: FloatArray
    faces: IntArray
    colors: FloatArray | None
    vertex_ids: IntArray
    face_ids: IntArray | None
    notes: tuple[str, ...] = ()
    merged: IntArray = field(default_factory=lambda: np.zeros((0, 2), dtype=np.int64))
    paint: Paint | None = None
    normals: FloatArray | None = None
    is_cloud: bool = False
    file_rows: tuple[int, int] | None = None
    fixed_point: bool = False

    def noting(self, *notes: str) -> "TriangleSoup":
        """Return the soup with more notes, and its edges if they are known."""
        found = replace(self, notes=(*self.notes, *notes))
        if "edges" in vars(self):
            vars(found)["edges"] = self.edges
        return found

    def with_faces(self, keep: BoolArray, what: str) -> "TriangleSoup":
        """Keep some faces, and note how many were dropped ("dropped 2 faces without area")."""
        dropped = int((~keep).sum())
        if not dropped:
            return self
        return self.of_faces(keep).noting(f"dropped {counted(dropped, 'face')} {what}")

    def of_faces(self, which: BoolArray | IntArray) -> "TriangleSoup":
        """Return the soup with these faces alone, in this order."""
        ids = None if self.face_ids is None else self.face_ids[which]
        return replace(self, faces=self.faces[which], face_ids=ids)

    def with_vertices_merged(self, into: IntArray) -> "TriangleSoup":
        """Merge every vertex v into vertex ``into[v]``, which keeps its position.

        Parameters
        ----------
        into
            (V,) vertex indices, with ``into[into] == into``. A colour becomes the mean of those of
            the merged vertices that faces use.
        """
        gone = np.flatnonzero(into != np.arange(len(into)))
        pairs = np.stack([self.vertex_ids[gone], self.vertex_ids[into[gone]]], axis=1)
        # Vertices merged earlier follow the vertex they were merged into.
        earlier, order = self.merged.copy(), np.argsort(self.vertex_ids)
        place = np.searchsorted(self.vertex_ids, earlier[:, 1], sorter=order)
        heir = order[place.clip(max=len(order) - 1)]
        known = self.vertex_ids[heir] == earlier[:, 1]
        earlier[known, 1] = self.vertex_ids[into[heir[known]]]
        return replace(
            self,
            faces=into[self.faces],
            colors=None if self.colors is None else self._colors_merged(self.colors, into),
            merged=np.concatenate([earlier, pairs]),
        )

    def _colors_merged(self, colors: FloatArray, into: IntArray) -> FloatArray:
        used = np.zeros(len(into), dtype=np.bool_)
        used[self.faces] = True
        members = np.bincount(into[used], minlength=len(into))
        several = members > 1
        mean = colors.copy()
        for channel in range(3):
            sums = np.bincount(into[used], colors[used, channel], len(into))
            mean[several, channel] = sums[several] / members[several]
        return mean

    def compacted(self) -> "TriangleSoup":
        """Drop the vertices that no face uses."""
        used = np.zeros(len(self.vertices), dtype=np.bool_)
        used[self.faces] = True
        if used.all():
            return self
        number = np.cumsum(used) - 1
        return replace(
            self,
            vertices=np.ascontiguousarray(self.vertices[used]),
            faces=number[self.faces].astype(np.int64),
            colors=None if self.colors is None else self.colors[used],
            vertex_ids=self.vertex_ids[used],
        )

    @cached_property
    def edges(self) -> Edges:
        """Edges of the faces, which must have three different corners each."""
        return edges_of(self.faces)

    @cached_property
    def component_of_face(self) -> IntArray:
        """(F,) component of each face, connected over shared vertices; numbered from 0."""
        sides = self.faces[:, [0, 1, 1, 2]].reshape(-1, 2)
        found: IntArray = components_of(sides, len(self.vertices))[self.faces[:, 0]]
        return found

    @cached_property
    def boundary(self) -> Boundary:
        """The boundary, in unit positions, with the vertices near it."""
        return boundary_of(self.unit_positions, self.faces, self.edges)

    @cached_property
    def unit_positions(self) -> FloatArray:
        """(V, 3) vertices centred, in units of the largest extent along an axis.

        Tolerances refer to these, so that repairs depend on neither position nor size of the shape.
        """
        low, high = self.vertices.min(axis=0), self.vertices.max(axis=0)
        found: FloatArray = (self.vertices - 0.5 * (low + high)) / (high - low).max()
        return found


def counted(count: int, noun: str, plural: str | None = None) -> str:
    """Return "1 face", "2 faces"."""
    return f"{count} {noun if count == 1 else plural or noun + 's'}"


def check_coordinates(vertices: FloatArray, corners: IntArray) -> None:
    """Refuse coordinates from which nothing can be computed.

    Parameters
    ----------
    vertices
        (V, 3).
    corners
        (n,) vertex indices, each valid; other vertices are not checked.

    Raises
    ------
    MeshError
        A coordinate is not finite, or the vertices coincide or are too large or too small.
    """
    used = np.zeros(len(vertices), dtype=np.bool_)
    used[corners] = True
    finite: BoolArray = np.all(np.isfinite(vertices), axis=1)
    if not finite[used].all():
        bad = int(np.argmax(used & ~finite))
        raise MeshError(f"vertex {bad} has a coordinate that is not a finite number")
    low, high = vertices[used].min(axis=0), vertices[used].max(axis=0)
    extent = float((0.5 * high - 0.5 * low).max())
    if extent == 0.0:
        raise MeshError("the mesh has no extent: all its vertices coincide")
    farthest = max(float(np.abs(low).max()), float(np.abs(high).max()))
    if not 1.0 / _LARGEST < extent < _LARGEST or farthest > _FARTHEST:
        raise MeshError(
            "the coordinates are too large or too small for an area to be computed; "
            f"scale them to between {1.0 / _LARGEST:g} and {_LARGEST:g}"
        )


def groups_of_equal_rows(table: FloatArray | IntArray) -> IntArray:
    """Find the first equal row of every row.

    Parameters
    ----------
    table
        (columns, n): row i is ``table[:, i]``.

    Returns
    -------
    (n,) int64 indices of rows; equal rows, and only these, have the same.
    """
    order = np.lexsort(table)  # stable: within a group the first row comes first
    fresh = np.ones(len(order), dtype=np.bool_)
    ordered = table[:, order]
    fresh[1:] = np.any(np.not_equal(ordered[:, 1:], ordered[:, :-1]), axis=0)
    first = np.empty(len(order), dtype=np.int64)
    first[order] = order[np.flatnonzero(fresh)][np.cumsum(fresh) - 1]
    return first
