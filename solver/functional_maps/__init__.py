"""Functional maps between two spectra, their refinement by ZoomOut, and maps of all vertices."""

from solver.functional_maps.dense_map import DenseMap, drop_similar_maps, rank_maps
from solver.functional_maps.extension import QUICK, extend_hypotheses
from solver.functional_maps.functional_map import (
    FunctionalMap,
    fit_functional_map,
    fit_orthonormal_map,
)
from solver.functional_maps.map_quality import EIGENPAIRS, ComparedShape, Comparison
from solver.functional_maps.nearest import approximate_nearest_points, mutual_nearest_points, nearest_points
from solver.functional_maps.selection import (
    MIN_POINTS_EXTENDED,
    DenseCorrespondence,
    dense_correspondence,
    select_map,
)
from solver.functional_maps.symmetry import compose_maps, find_reflection
from solver.functional_maps.zoomout import zoomout

__all__ = [
    "EIGENPAIRS",
    "MIN_POINTS_EXTENDED",
    "QUICK",
    "ComparedShape",
    "Comparison",
    "DenseCorrespondence",
    "DenseMap",
    "FunctionalMap",
    "approximate_nearest_points",
    "compose_maps",
    "dense_correspondence",
    "drop_similar_maps",
    "extend_hypotheses",
    "find_reflection",
    "fit_functional_map",
    "fit_orthonormal_map",
    "mutual_nearest_points",
    "nearest_points",
    "rank_maps",
    "select_map",
    "zoomout",
]
