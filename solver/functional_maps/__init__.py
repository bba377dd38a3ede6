"""Functional maps between two spectra, their refinement by ZoomOut, and maps of all vertices."""

from solver.functional_maps.dense_map import DenseMap, first_of_each, oriented_first
from solver.functional_maps.extension import QUICK, dense_map, extensions
from solver.functional_maps.functional_map import (
    FunctionalMap,
    fit_functional_map,
    functional_map_of_points,
    spectral_upsampling,
)
from solver.functional_maps.map_quality import EIGENPAIRS, Comparison, Side
from solver.functional_maps.nearest import nearest_points, nearly_nearest_points
from solver.functional_maps.selection import (
    LEAST_EXTENDED,
    DenseCorrespondence,
    dense_correspondence,
    extended_map,
)
from solver.functional_maps.symmetry import composed, reflection

__all__ = [
    "EIGENPAIRS",
    "LEAST_EXTENDED",
    "QUICK",
    "Comparison",
    "DenseCorrespondence",
    "DenseMap",
    "FunctionalMap",
    "Side",
    "composed",
    "dense_correspondence",
    "dense_map",
    "extended_map",
    "extensions",
    "first_of_each",
    "fit_functional_map",
    "functional_map_of_points",
    "nearest_points",
    "nearly_nearest_points",
    "oriented_first",
    "reflection",
    "spectral_upsampling",
]
