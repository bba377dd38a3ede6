"""Overlap of the vertices and faces of two surfaces along a map: values are carried by area.

A function with one value on each face jumps at edges, so that its value at single points says
little of those around them. The map T: Y → X is sampled at points spread evenly over the triangles
of Y instead: a face of Y, or the barycentric cell of a vertex, takes what most of its area, or its
area on average, is mapped to.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
import scipy.sparse as sp

from solver.arrays import FloatArray, IntArray
from solver.errors import TransferError
from solver.mesh import TriangleMesh, triangle_areas
from solver.mesh.textures import barycentric_pattern
from solver.registration import DenseCorrespondence
from solver.transfer.landmarks import Landmarks, surface_images
from solver.transfer.pull_back import Values

VERTICES: Final = "vertices"
FACES: Final = "faces"
CORNERS: Final = "corners"

_PER_TRIANGLE: Final = 4
"""Samples for each triangle of X, at least, if both surfaces have the same area."""

_PARTS: Final = 3, 16
"""Least and greatest number of parts into which an edge is cut, for samples."""

_CHUNK: Final = 1 << 17
"""Samples mapped at a time."""


@dataclass(frozen=True, eq=False)
class Overlap:
    """The areas of Y that are mapped to the vertices or faces of X.

    Parameters
    ----------
    areas
        (m, n) area of vertex or face i of Y that is mapped to vertex or face j of X, by the
        user's numbers. A row without entries is of no part of the mapped surface.
    """

    areas: sp.csr_array[np.float64]

    def means(self, values: FloatArray) -> FloatArray:
        """Return means by area of (n,) or (n, k) values of X, of the rows that have an area.

        Raises
        ------
        TransferError
            There are not n values.
        """
        self._check(values)
        rows = self.reached
        totals: FloatArray = self.areas.sum(axis=1)[rows]
        sums = np.asarray(self.areas @ values)[rows]
        found: FloatArray = sums / totals.reshape(-1, *(1,) * (values.ndim - 1))
        return found

    def majority(self, labels: Values) -> Values:
        """Return the label of greatest area, of the rows that have an area.

        Parameters
        ----------
        labels
            (n,) labels of X, numbers or text.

        Raises
        ------
        TransferError
            There are not n labels.
        """
        self._check(labels)
        kinds, codes = np.unique(labels, return_inverse=True)
        shape = (len(labels), len(kinds))
        ones = np.ones(len(labels))
        of_label = sp.csr_array((ones, (np.arange(len(labels)), codes)), shape=shape)
        shares = sp.csr_array(self.areas @ of_label)
        row = np.repeat(np.arange(shares.shape[0]), np.diff(shares.indptr))
        by_share = np.lexsort((shares.indices, -shares.data, row))
        found: Values = kinds[shares.indices[by_share[shares.indptr[self.reached]]]]
        return found

    def spread(self, values: Values, missing: Any) -> Values:
        """Return values of all m rows, with others for those without an area."""
        found = np.full((self.areas.shape[0], *values.shape[1:]), missing, dtype=values.dtype)
        found[self.reached] = values
        return found

    @property
    def reached(self) -> IntArray:
        """Rows that have an area."""
        return np.flatnonzero(np.diff(self.areas.indptr))

    def _check(self, values: Values) -> None:
        if len(values) != self.areas.shape[1]:
            raise TransferError(
                f"there are {len(values)} rows of values, and {self.areas.shape[1]} are needed"
            )


def overlap_of(
    target: TriangleMesh, dense: DenseCorrespondence, source: TriangleMesh, onto: str, of: str
) -> Overlap:
    """Measure the overlap of Y with X along a map, by samples.

    Parameters
    ----------
    target
        The surface Y.
    dense
        The map Y → X. Triangles of Y with a corner that is not mapped are left out.
    source
        The surface X.
    onto, of
        What of Y, and of X: `VERTICES` or `FACES`. A vertex of Y stands for its barycentric cell;
        those of X share a sample by its barycentric coordinates.

    Raises
    ------
    TransferError
        Faces are asked for, and a surface does not know those of its file.
    """
    numbers = _numbers(target, onto), _numbers(source, of)
    shape = _count(target, onto), _count(source, of)
    known = mapped_faces(target, dense)
    finer = np.sqrt(_PER_TRIANGLE * source.n_faces / max(len(known), 1))
    points, shares = barycentric_pattern(int(np.clip(np.ceil(finer), *_PARTS)))
    if onto == FACES:
        shares = np.full_like(shares, 1.0 / len(points))
    areas = triangle_areas(target.vertices, target.faces)
    found: sp.csr_array[np.float64] = sp.csr_array(shape, dtype=np.float64)
    for faces in in_chunks(known, len(points)):
        samples = Landmarks(
            np.repeat(target.vertex_ids[target.faces[faces]], len(points), axis=0),
            np.tile(points, (len(faces), 1)),
        )
        images, barycentric = surface_images(samples, dense, source)
        weights = areas[faces, None, None] / 3.0 * shares
        rows = np.repeat(numbers[0][faces], len(points), axis=0)
        columns = numbers[1][images]
        found = found + _areas(rows, weights.reshape(-1, 3), columns, barycentric, shape)
    if onto == VERTICES:
        # A vertex that was merged into another has its values.
        heirs = np.arange(shape[0])
        ids, own = target.numbering
        heirs[ids] = target.vertex_ids[own]
        found = found[heirs]
    return Overlap(found)


def _areas(
    rows: IntArray,
    weights: FloatArray,
    columns: IntArray,
    shares: FloatArray,
    shape: tuple[int, int],
) -> sp.csr_array[np.float64]:
    """Sum the weights of samples, (s, 3) for rows, times (s, 3) shares for columns."""
    i, j = (np.broadcast_to(one, (len(rows), 3, 3)) for one in (rows[:, :, None], columns[:, None]))
    values = weights[:, :, None] * shares[:, None]
    chosen = values > 0.0
    table = sp.coo_array((values[chosen], (i[chosen], j[chosen])), shape=shape)
    return sp.csr_array(table)


def _numbers(mesh: TriangleMesh, what: str) -> IntArray:
    """(F, 3) the user's number of the vertex at each corner, or of the face, three times."""
    if what == VERTICES:
        return mesh.vertex_ids[mesh.faces]
    return np.repeat(file_faces(mesh)[:, None], 3, axis=1)


def _count(mesh: TriangleMesh, what: str) -> int:
    """Rows of the file, or, if these are not known, of what is left of it."""
    if what == VERTICES:
        return mesh.vertex_rows
    return int(file_faces(mesh).max()) + 1 if mesh.file_rows is None else mesh.file_rows[1]


def file_faces(mesh: TriangleMesh) -> IntArray:
    """Return the number of the file's face of each triangle, (F,).

    Raises
    ------
    TransferError
        They are not known.
    """
    if mesh.face_ids is None:
        raise TransferError(
            "the faces of the shape's file are not known: delete the shape, and upload it again"
        )
    return mesh.face_ids


def mapped_faces(target: TriangleMesh, dense: DenseCorrespondence) -> IntArray:
    """(n,) triangles of Y whose corners are all mapped."""
    mapped = np.isin(target.vertex_ids, dense.source)
    return np.flatnonzero(mapped[target.faces].all(axis=1))


def in_chunks(faces: IntArray, samples: int) -> Iterator[IntArray]:
    """Yield so many faces at a time that they fit in memory with their samples, so many each."""
    step = max(_CHUNK // samples, 1)
    for start in range(0, len(faces), step):
        yield faces[start : start + step]
