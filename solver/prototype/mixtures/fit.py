"""Fits of Gaussian mixtures to many data sets, and choices between fits."""

from dataclasses import dataclass

import numpy as np

from solver.arrays import BoolArray, FloatArray, IntArray
from solver.prototype.mixtures.mixture import GaussianMixtures


@dataclass(frozen=True, eq=False)
class Fit:
    """Fitted mixtures with their likelihoods.

    Parameters
    ----------
    mixtures
        B of K components.
    log_likelihood
        (B,) log-likelihood of each data set.
    """

    mixtures: GaussianMixtures
    log_likelihood: FloatArray

    def information_criterion(self, samples: int, diagonal: bool = False) -> FloatArray:
        """(B,) Bayesian information criterion (Schwarz 1978); less is better.

        Parameters
        ----------
        samples
            Number M of samples of each data set.
        diagonal
            Whether covariances are diagonal.
        """
        m = self.mixtures.dimension
        used = (self.mixtures.weights > 0.0).sum(axis=1)
        shape = m if diagonal else m * (m + 1) / 2
        parameters = used * (1 + m + shape) - 1
        criterion: FloatArray = parameters * np.log(samples) - 2.0 * self.log_likelihood
        return criterion

    def replaced(self, rows: IntArray, other: "Fit") -> "Fit":
        """Return the fits with those of some data sets replaced.

        Parameters
        ----------
        rows
            (R,) data sets.
        other
            Their R fits, with as many components.
        """
        old, new = self.mixtures, other.mixtures
        arrays = []
        for before, after in (
            (old.weights, new.weights),
            (old.means, new.means),
            (old.covariances, new.covariances),
            (self.log_likelihood, other.log_likelihood),
        ):
            changed = before.copy()
            changed[rows] = after
            arrays.append(changed)
        return Fit(GaussianMixtures(*arrays[:3]), arrays[3])

    def padded(self, components: int) -> "Fit":
        """Return the fits with components of weight 0 added, up to a number of components."""
        extra = components - self.mixtures.weights.shape[1]
        if extra <= 0:
            return self
        m = self.mixtures
        mixtures = GaussianMixtures(
            np.pad(m.weights, ((0, 0), (0, extra))),
            np.concatenate([m.means, np.repeat(m.means[:, :1], extra, axis=1)], axis=1),
            np.concatenate([m.covariances, np.repeat(m.covariances[:, :1], extra, axis=1)], axis=1),
        )
        return Fit(mixtures, self.log_likelihood)

    def best_of(self, other: "Fit", where: BoolArray) -> "Fit":
        """Return the other fit of each data set where it is better, else this one.

        Parameters
        ----------
        other
            Fits of the same data sets, with as many components.
        where
            (B,) mask of the data sets whose other fit is better.
        """
        rows = np.flatnonzero(where)
        chosen = Fit(other.mixtures.chosen(rows), other.log_likelihood[rows])
        return self.replaced(rows, chosen)
