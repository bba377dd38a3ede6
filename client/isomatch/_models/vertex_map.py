"""Maps of the vertices of one file to points of another's surface, and values taken along them."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt


@dataclass(frozen=True, eq=False)
class VertexMap:
    """A map in one direction: from the vertices of one surface to points of another.

    Row k is of vertex ``vertices[k]``, not of vertex k: vertices of the file that no face uses have
    no row, and those that the other surface lacks have none, where one is a part of the other.
    :meth:`isomatch.Match.vertex_map` has a row for each vertex of the file.

    Values go the other way: a vertex takes the value at its image. A map from the target to the
    source thus carries values of the source to the target, and leaves no vertex without one.

    Attributes
    ----------
    vertices
        Vertices that are mapped, by their index in their file, ascending, (K,) int64.
    images
        Vertex of the other file nearest to the image of each, (K,) int64.
    faces
        Corners, in the other file, of the triangle that holds each image, (K, 3) int64.
    weights
        Barycentric coordinates of each image in its triangle, (K, 3) float64.
    """

    vertices: npt.NDArray[np.int64]
    images: npt.NDArray[np.int64]
    faces: npt.NDArray[np.int64]
    weights: npt.NDArray[np.float64]

    def __repr__(self) -> str:
        return f"<VertexMap of {len(self.vertices)} vertices>"

    def interpolate(self, values: npt.ArrayLike) -> npt.NDArray[np.float64]:
        """Return the barycentric mean of values at the images.

        Parameters
        ----------
        values
            A value or a row for each vertex of the other file, in its order, (V,) or (V, ...).

        Returns
        -------
        The value or row of each of `vertices`, (K,) or (K, ...) float64.

        Raises
        ------
        ValueError
            `values` has fewer rows than the file.
        """
        rows = np.asarray(values, dtype=np.float64)
        self._check(rows)
        found: npt.NDArray[np.float64] = np.einsum("kc,kc...->k...", self.weights, rows[self.faces])
        return found

    def majority(self, labels: npt.ArrayLike) -> npt.NDArray[Any]:
        """Return the label with the greatest barycentric weight at the images.

        Parameters
        ----------
        labels
            A label, a number or a text, for each vertex of the other file, in its order, (V,).

        Returns
        -------
        The label of each of `vertices`, (K,), of the type of `labels`; each is one of them.

        Raises
        ------
        ValueError
            `labels` has fewer rows than the file.
        """
        rows = np.asarray(labels)
        self._check(rows)
        corners = rows[self.faces]
        shares = (corners[:, :, None] == corners[:, None, :]) * self.weights[:, None, :]
        chosen = shares.sum(axis=2).argmax(axis=1)
        found: npt.NDArray[Any] = corners[np.arange(len(corners)), chosen]
        return found

    def _check(self, rows: npt.NDArray[Any]) -> None:
        if len(self.faces) < len(self.vertices):
            raise ValueError("the result has no images between vertices; match again")
        last = int(self.faces.max(initial=-1))
        have = 0 if rows.ndim == 0 else len(rows)
        if last >= have:
            raise ValueError(
                f"there are {have:,} rows of values, but the other file has a vertex {last:,}: give"
                " a row for each of its vertices, in its order"
            )
