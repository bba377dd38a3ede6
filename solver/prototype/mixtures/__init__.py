"""Gaussian mixtures of distances and descriptors, fitted by expectation maximisation."""

from solver.prototype.mixtures.expectation_maximisation import (
    fit_from,
    fit_mixtures,
    initial_mixtures,
)
from solver.prototype.mixtures.mixture import GaussianMixtures
from solver.prototype.mixtures.table import likelihood_table

__all__ = ["GaussianMixtures", "fit_from", "fit_mixtures", "initial_mixtures", "likelihood_table"]
