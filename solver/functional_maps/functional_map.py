"""Functional maps: correspondences as linear maps between the functions on two shapes.

A correspondence T from X to Y carries a function g on Y to g ∘ T on X. In the eigenfunctions of the
Laplace-Beltrami operators that is a matrix, small because smooth functions need few of them
(Ovsjanikov et al., ACM TOG 31(4), 2012). Of isometric shapes the eigenspaces correspond, so the
matrix is orthonormal and nearly diagonal.
"""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from solver.arrays import FloatArray, IntArray, RealArray
from solver.functional_maps.nearest import nearest_points

_RIDGE = 1e-9
"""Keeps the least squares regular where functions span too little."""


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
        """Where points of X come to lie among the spectral embeddings of Y's points.

        The heat kernel's delta at x has coefficients φ(x), so the image of x is C φ(x).

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
        """Point of Y whose spectral embedding is nearest to the image of each point of X.

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
    """Functional map that carries given functions over, and commutes with the Laplacians.

    Minimises ‖C A − B‖² + w Σ_ij (C_ij (λ_j − μ_i) / s)², the second term being zero of isometric
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


def functional_map_of_points(source: FloatArray, target: FloatArray) -> FunctionalMap:
    """Orthonormal functional map that carries points to points best: a Procrustes problem.

    Parameters
    ----------
    source, target
        (S, k) values of eigenfunctions at corresponding points of X and Y.
    """
    left, _, right = np.linalg.svd(target.T @ source)
    return FunctionalMap(np.ascontiguousarray(left @ right))


def spectral_upsampling(
    start: FunctionalMap, source: FloatArray, target: FloatArray, sizes: Iterable[int]
) -> FunctionalMap:
    """Refine a functional map with more and more eigenfunctions.

    In turn, points of X go to their nearest in Y under the map so far, and the orthonormal map of
    the next size is fitted to them (ZoomOut: Melzi et al., ACM TOG 38(6), 2019).

    Parameters
    ----------
    start
        A map between few eigenfunctions.
    source, target
        (S, K) and (M, K) values of eigenfunctions at points spread over X and Y.
    sizes
        Numbers of eigenfunctions to go through, each at most K.
    """
    current = start
    x, y = source.astype(np.float32), target.astype(np.float32)
    for size in sizes:
        partners = current.nearest(x, y)
        current = functional_map_of_points(source[:, :size], target[partners, :size])
    return current
