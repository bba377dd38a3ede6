"""Pull-back of vertex values along a map: each vertex takes the value at its image.

Values f of X are carried to Y along the map T: Y → X, as f ∘ T: every vertex of Y has an image, so
every vertex of Y has a value. Along X → Y many vertices of Y would be the image of none.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from solver.arrays import FloatArray, IntArray
from solver.errors import TransferError
from solver.mesh import TriangleMesh
from solver.registration import DenseCorrespondence

Values = npt.NDArray[Any]


@dataclass(frozen=True, eq=False)
class PullBack:
    """The map T from the vertices of Y to points of X.

    Parameters
    ----------
    vertices
        (K,) vertices of Y, by the user's numbers, ascending.
    corners
        (K, 3) corners of the triangle of X that holds the image of each, by the user's numbers.
    barycentric
        (K, 3) barycentric coordinates of the image there; each row sums to 1.
    count
        W, how many vertices the file of Y has.
    """

    vertices: IntArray
    corners: IntArray
    barycentric: FloatArray
    count: int

    @classmethod
    def along(cls, dense: DenseCorrespondence, onto: TriangleMesh) -> "PullBack":
        """Return the pull-back along a map.

        Parameters
        ----------
        dense
            The map T: Y → X.
        onto
            The surface Y.
        """
        return cls(dense.source, dense.faces, dense.barycentric, onto.vertex_rows)

    @property
    def reached(self) -> IntArray:
        """Vertices of Y that have an image."""
        return self.vertices

    @property
    def rows(self) -> int:
        """Rows of values that are taken: one more than the greatest vertex number of X."""
        return int(self.corners.max(initial=-1)) + 1

    def means(self, values: FloatArray) -> FloatArray:
        """Return barycentric means: linear functions on the triangles of X are reproduced.

        Parameters
        ----------
        values
            (V,) or (V, n) values of the vertices of X.

        Returns
        -------
        (K,) or (K, n) values of `vertices`. Components of vectors are averaged one by one; their
        directions are not rotated.

        Raises
        ------
        TransferError
            There are fewer than `rows` values.
        """
        self._check(values)
        found: FloatArray = np.einsum("kc,kc...->k...", self.barycentric, values[self.corners])
        return found

    def majority(self, labels: Values) -> Values:
        """Return the label of greatest total barycentric coordinate; of the first corner in a tie.

        Parameters
        ----------
        labels
            (V,) labels of the vertices of X, numbers or text.

        Returns
        -------
        (K,) labels of `vertices`, each one of those given.

        Raises
        ------
        TransferError
            There are fewer than `rows` labels.
        """
        self._check(labels)
        three = labels[self.corners]
        shares = (three[:, :, None] == three[:, None, :]) * self.barycentric[:, None, :]
        found: Values = three[np.arange(len(three)), shares.sum(axis=2).argmax(axis=1)]
        return found

    def spread(self, values: Values, missing: Any) -> Values:
        """Return values of `vertices` by the user's numbers, with others for vertices not in it.

        Parameters
        ----------
        values
            (K,) or (K, n).
        missing
            Value of vertices that no face of Y uses, or that have no image.

        Returns
        -------
        (W,) or (W, n): row i is that of vertex i.
        """
        found = np.full((self.count, *values.shape[1:]), missing, dtype=values.dtype)
        found[self.vertices] = values
        return found

    def _check(self, values: Values) -> None:
        if len(values) < self.rows:
            raise TransferError(
                f"there are {len(values)} rows of values, and the surface has a vertex"
                f" {self.rows - 1}, counted from 0; give a row for every vertex of the file"
            )
