"""Gaussian mixtures, many at once: the densities of section 5."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.special import logsumexp

from solver.arrays import BoolArray, FloatArray, IntArray

_MAX_SHIFTS = 100
"""Greatest number of mean shift steps to a mode; the density rises at each
(Carreira-Perpiñán, Mode-finding for mixtures of Gaussian distributions, PAMI 22(11), 2000)."""

_LEAST_SHIFT = 1e-12
"""Step at which the shifts of a mixture have converged, over the greatest coordinate."""


@dataclass(frozen=True, eq=False)
class GaussianMixtures:
    """B mixtures of K Gaussians in m dimensions each.

    Parameters
    ----------
    weights
        (B, K) π_k >= 0, summing to 1 in each mixture; 0 for unused components.
    means
        (B, K, m) μ_k.
    covariances
        (B, K, m, m) Σ_k, symmetric and positive definite, also of unused components.

    Raises
    ------
    ValueError
        The arrays do not describe such mixtures.
    """

    weights: FloatArray
    means: FloatArray
    covariances: FloatArray

    def __post_init__(self) -> None:
        count, components = self.weights.shape
        m = self.means.shape[-1]
        if self.means.shape != (count, components, m):
            raise ValueError("means must be (B, K, m)")
        if self.covariances.shape != (count, components, m, m):
            raise ValueError("covariances must be (B, K, m, m)")
        if not all(np.isfinite(a).all() for a in (self.weights, self.means, self.covariances)):
            raise ValueError("parameters of mixtures must be finite")
        sums = self.weights.sum(axis=1)
        if (self.weights < 0.0).any() or not np.allclose(sums, 1.0, rtol=0.0, atol=1e-9):
            raise ValueError("weights must be at least 0 and sum to 1")
        if not np.allclose(self.covariances, np.swapaxes(self.covariances, -1, -2)):
            raise ValueError("covariances must be symmetric")
        if not np.isfinite(self.roots).all() or not np.isfinite(self._log_scales).all():
            raise ValueError("covariances must be positive definite")

    def __len__(self) -> int:
        return len(self.weights)

    @property
    def dimension(self) -> int:
        """Number m of dimensions."""
        return int(self.means.shape[-1])

    @cached_property
    def log_weights(self) -> FloatArray:
        """(B, K) log π_k, −∞ for unused components."""
        with np.errstate(divide="ignore"):
            result: FloatArray = np.log(self.weights)
        return result

    @cached_property
    def roots(self) -> FloatArray:
        """(B, K, m, m) W_k with W_kᵀ W_k = Σ_k⁻¹, lower triangular."""
        try:
            factors = np.linalg.cholesky(self.covariances)
        except np.linalg.LinAlgError as error:
            raise ValueError("covariances must be positive definite") from error
        unit = np.broadcast_to(np.eye(self.dimension), factors.shape)
        result: FloatArray = np.linalg.solve(factors, unit)
        return result

    @cached_property
    def _log_scales(self) -> FloatArray:
        """(B, K) log of each component's density at its mean."""
        diagonal = np.diagonal(self.roots, axis1=-2, axis2=-1)
        constant = 0.5 * self.dimension * np.log(2.0 * np.pi)
        scales: FloatArray = np.log(diagonal).sum(axis=-1) - constant
        return scales

    @cached_property
    def _precisions(self) -> FloatArray:
        """(B, K, m, m) Σ_k⁻¹."""
        result: FloatArray = np.swapaxes(self.roots, -1, -2) @ self.roots
        return result

    def log_joint(self, points: FloatArray) -> FloatArray:
        """Log of each component's weighted density.

        Parameters
        ----------
        points
            (B, S, m) points at which each mixture is evaluated.

        Returns
        -------
        (B, S, K) float64, −∞ for unused components.
        """
        apart = points[:, None, :, :] - self.means[:, :, None, :]
        white = apart @ np.swapaxes(self.roots, -1, -2)
        exponents = -0.5 * np.swapaxes((white**2).sum(axis=-1), 1, 2)
        joint: FloatArray = exponents + (self._log_scales + self.log_weights)[:, None, :]
        return joint

    def log_density(self, points: FloatArray) -> FloatArray:
        """Log density of each mixture: log p_x(f), or log p_xx'(d).

        Parameters
        ----------
        points
            (B, S, m) points at which each mixture is evaluated.

        Returns
        -------
        (B, S) float64, natural logarithms.
        """
        result: FloatArray = logsumexp(self.log_joint(points), axis=2)
        return result

    @cached_property
    def log_peaks(self) -> FloatArray:
        """(B,) log density at the highest mode found by mean shift from the means."""
        places, rows, moving = self.means.copy(), np.arange(len(self)), self
        for _ in range(_MAX_SHIFTS):
            before, places[rows] = places[rows], moving._shifted(places[rows])
            steps = np.abs(places[rows] - before).max(axis=(1, 2))
            still = steps <= _LEAST_SHIFT * np.abs(before).max(axis=(1, 2))
            if still.all():
                break
            if still.any():
                rows, moving = rows[~still], moving.chosen(~still)
        heights: FloatArray = self.log_density(places).max(axis=1)
        return heights

    def _shifted(self, places: FloatArray) -> FloatArray:
        """Mean shift of (B, S, m) places."""
        joint = self.log_joint(places)
        shares = np.exp(joint - logsumexp(joint, axis=2, keepdims=True))
        count, components, m = self.means.shape
        weighed = shares @ self._precisions.reshape(count, components, m * m)
        weighed = weighed.reshape(*places.shape, m)
        pulls = shares @ (self._precisions @ self.means[..., None])[..., 0]
        moved = np.asarray(np.linalg.solve(weighed, pulls[..., None]), dtype=np.float64)
        return moved[..., 0]

    @cached_property
    def averages(self) -> FloatArray:
        """(B, m) mean of each mixture."""
        result: FloatArray = np.einsum("bk,bki->bi", self.weights, self.means)
        return result

    def chosen(self, places: IntArray | BoolArray) -> "GaussianMixtures":
        """Return some of the mixtures, by their indices or a mask."""
        return GaussianMixtures(self.weights[places], self.means[places], self.covariances[places])

    def first(self, count: int) -> "GaussianMixtures":
        """Return the first mixtures, as many as there are."""
        return self if count >= len(self) else self.chosen(np.arange(count))
