"""Triangles that are not a surface yet: what a file holds, and what repairs work on."""

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from solver.arrays import BoolArray, FloatArray, IntArray
from solver.errors import MeshError
from solver.mesh.repair.edges import Edges, edges_of
from solver.mesh.repair.proximity import Border, border_of

_LARGEST = 1e64
"""Extent beyond which, or below whose inverse, the fourth power of a length has no number."""


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
    notes
        What was changed so far, in sentences for the user.
    merged
        (A, 2) numbers in the file: of a vertex that was merged into another, and of that other.
    """

    vertices: FloatArray
    faces: IntArray
    colors: FloatArray | None
    vertex_ids: IntArray
    notes: tuple[str, ...] = ()
    merged: IntArray = field(default_factory=lambda: np.zeros((0, 2), dtype=np.int64))

    def noting(self, *notes: str) -> "TriangleSoup":
        """Return the soup with more notes."""
        return replace(self, notes=(*self.notes, *notes))

    def with_faces(self, keep: BoolArray, what: str = "") -> "TriangleSoup":
        """Keep some faces, and note how many were not ("dropped 2 faces without area")."""
        dropped = int((~keep).sum())
        if not dropped:
            return self
        kept = replace(self, faces=self.faces[keep])
        return kept.noting(f"dropped {counted(dropped, 'face')} {what}") if what else kept

    def with_vertices_merged(self, into: IntArray) -> "TriangleSoup":
        """Let every vertex v give way to vertex ``into[v]``, which stays where it is.

        Parameters
        ----------
        into
            (V,) vertex indices, with ``into[into] == into``. Its colour becomes the mean of theirs,
            as far as faces use them.
        """
        gone = np.flatnonzero(into != np.arange(len(into)))
        pairs = np.stack([self.vertex_ids[gone], self.vertex_ids[into[gone]]], axis=1)
        # What was merged into a vertex that goes now, goes with it.
        heirs = dict(pairs.tolist()) if len(self.merged) else {}
        merged = [(old, heirs.get(heir, heir)) for old, heir in self.merged.tolist()]
        earlier = np.array(merged, dtype=np.int64).reshape(-1, 2)
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
    def border(self) -> Border:
        """The border, in places, with what lies near it."""
        return border_of(self.places, self.faces, self.edges)

    @cached_property
    def places(self) -> FloatArray:
        """(V, 3) the vertices centred, in units of the largest extent along an axis.

        Every tolerance is one of places, so that repairs depend neither on where a shape lies nor
        on its size.
        """
        low, high = self.vertices.min(axis=0), self.vertices.max(axis=0)
        found: FloatArray = (self.vertices - 0.5 * (low + high)) / (high - low).max()
        return found


def counted(count: int, noun: str, plural: str | None = None) -> str:
    """Return "1 face", "2 faces"."""
    return f"{count} {noun if count == 1 else plural or noun + 's'}"


def check_coordinates(vertices: FloatArray, corners: IntArray) -> None:
    """Refuse coordinates that nothing can be computed from.

    Parameters
    ----------
    vertices
        (V, 3).
    corners
        Vertex indices, each valid; the other vertices do not matter.

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
        raise MeshError("the mesh has no extent: its vertices coincide")
    if not 1.0 / _LARGEST < extent < _LARGEST:
        raise MeshError(
            "the coordinates are too large or too small for an area to be computed; "
            f"scale them to between {1.0 / _LARGEST:g} and {_LARGEST:g}"
        )


def groups_of_equal_rows(table: FloatArray | IntArray) -> IntArray:
    """Number rows so that equal ones, and only these, have the same number.

    Parameters
    ----------
    table
        (columns, n): row i is ``table[:, i]``.

    Returns
    -------
    (n,) int64, the index of the first row of each row's kind.
    """
    order = np.lexsort(table)  # stable: within a group the first row comes first
    fresh = np.ones(len(order), dtype=np.bool_)
    ordered = table[:, order]
    fresh[1:] = np.any(np.not_equal(ordered[:, 1:], ordered[:, :-1]), axis=0)
    first = np.empty(len(order), dtype=np.int64)
    first[order] = order[np.flatnonzero(fresh)][np.cumsum(fresh) - 1]
    return first
