"""Functional maps: correspondences as linear maps between the functions on two shapes.

A correspondence T from X to Y pulls a function g on Y back to g ∘ T on X. In the eigenfunctions of
the Laplace-Beltrami operators that is a matrix, small because smooth functions need few of them
(Ovsjanikov et al., ACM TOG 31(4), 2012). Eigenspaces of isometric shapes correspond, so that their
matrix is orthonormal and nearly diagonal.
"""

from dataclasses import dataclass

import numpy as np

from solver.arrays import FloatArray


@dataclass(frozen=True, eq=False)
class FunctionalMap:
    """A linear map from functions on X to functions on Y.

    Parameters
    ----------
    matrix
        (k, l) C: coefficients a of a function in the first l eigenfunctions of X become C a in the
        first k of Y; k = l, but where Y is a part of X.
    """

    matrix: FloatArray

    @property
    def size(self) -> int:
        """Number k of eigenfunctions of Y."""
        return len(self.matrix)

    def images(self, source: FloatArray) -> FloatArray:
        """Images of points of X in the spectral embedding of Y.

        The delta function at x has the coefficients φ(x), so that the image of x is C φ(x).

        Parameters
        ----------
        source
            (S, K) values of K ≥ l eigenfunctions of X at points of X.

        Returns
        -------
        (S, k) float64
        """
        images: FloatArray = source[:, : self.matrix.shape[1]] @ self.matrix.T
        return images


def fit_orthonormal_map(source: FloatArray, target: FloatArray) -> FunctionalMap:
    """Fit an orthonormal functional map to corresponding points: a Procrustes problem.

    Parameters
    ----------
    source, target
        (S, k) values of eigenfunctions at corresponding points of X and Y.

    Returns
    -------
    The C of least ‖φ Cᵀ − ψ‖, φ and ψ being these values (Schönemann 1966).
    """
    left, _, right = np.linalg.svd(target.T @ source)
    return FunctionalMap(np.ascontiguousarray(left @ right))
