"""Functional maps between two spectra, and nearest neighbours in the aligned embeddings."""

from solver.functional_maps.functional_map import FunctionalMap, fit_orthonormal_map
from solver.functional_maps.nearest import mutual_nearest_points, nearest_points

__all__ = [
    "FunctionalMap",
    "fit_orthonormal_map",
    "mutual_nearest_points",
    "nearest_points",
]
