"""Functional maps: correspondences as linear maps between the functions on two shapes.

A correspondence T from X to Y pulls a function g on Y back to g ∘ T on X. In the eigenfunctions of
the Laplace-Beltrami operators that is a matrix, small because smooth functions need few of them
(Ovsjanikov et al., ACM TOG 31(4), 2012). Eigenspaces of isometric shapes correspond, so that their
matrix is orthonormal and nearly diagonal.
"""

from dataclasses import dataclass

import numpy as np

from solver.arrays import FloatArray, IntArray, RealArray
from solver.functional_maps.nearest import nearest_points

_RIDGE = 1e-9
"""Added to the normal equations, which are singular where the functions span too little."""


@dataclass(frozen=True, eq=False)
class FunctionalMap:
    """A linear map from functions on X to functions on Y.

    Parameters
    ----------
    matrix
        (k, k) C: coefficients a of a function in the first k eigenfunctions of X become C a in
        those of Y.
    """

    matrix: FloatArray

    @property
    def size(self) -> int:
        """Number k of eigenfunctions on either side."""
        return len(self.matrix)

    def images(self, source: FloatArray) -> FloatArray:
        """Images of points of X in the spectral embedding of Y.

        The delta function at x has the coefficients φ(x), so that the image of x is C φ(x).

        Parameters
        ----------
        source
            (S, K) values of K ≥ k eigenfunctions of X at points of X.

        Returns
        -------
        (S, k) float64
        """
        images: FloatArray = source[:, : self.size] @ self.matrix.T
        return images

    def nearest(self, source: RealArray, target: RealArray) -> IntArray:
        """Points of Y nearest to the images of points of X in the spectral embedding.

        Parameters
        ----------
        source, target
            (S, K) and (M, K) values of K ≥ k eigenfunctions at points of X and Y.

        Returns
        -------
        (S,) int64 rows of `target`, compared in single precision. O(S M k) time, O(S + M) memory.
        """
        single = np.float32
        images = source[:, : self.size].astype(single, copy=False) @ self.matrix.T.astype(single)
        return nearest_points(images, target[:, : self.size].astype(single, copy=False))


def fit_functional_map(
    source: FloatArray,
    target: FloatArray,
    eigenvalues: tuple[FloatArray, FloatArray],
    commutativity: float,
) -> FunctionalMap:
    """Fit a functional map to corresponding functions, commuting with the Laplacians.

    Minimises ‖C A − B‖² + w Σ_ij (C_ij (λ_j − μ_i) / s)², the second term being zero for isometric
    shapes (Ovsjanikov et al. 2012, section 5.3); s is the greatest eigenvalue.

    Parameters
    ----------
    source, target
        (k, p) A and B: coefficients of p functions on X and of the same functions on Y.
    eigenvalues
        (k,) λ of X and (k,) μ of Y.
    commutativity
        w ≥ 0.
    """
    lambdas, mus = eigenvalues
    unit = max(float(lambdas[-1]), float(mus[-1]), np.finfo(np.float64).tiny)
    offsets = commutativity * ((lambdas[None, :] - mus[:, None]) / unit) ** 2 + _RIDGE
    gram = source @ source.T + offsets[:, :, None] * np.eye(len(lambdas))
    right = target @ source.T
    matrix: FloatArray = np.linalg.solve(gram, right[:, :, None])[:, :, 0].astype(np.float64)
    return FunctionalMap(matrix)


def fit_orthonormal_map(source: FloatArray, target: FloatArray) -> FunctionalMap:
    """Fit an orthonormal functional map to corresponding points: a Procrustes problem.

    Parameters
    ----------
    source, target
        (S, k) values of eigenfunctions at corresponding points of X and Y.
    """
    left, _, right = np.linalg.svd(target.T @ source)
    return FunctionalMap(np.ascontiguousarray(left @ right))
