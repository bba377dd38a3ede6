"""Consistency of the maps between all shapes of a collection: measurement and improvement."""

from solver.consistency.improvement import (
    DOUBTFUL,
    Consistency,
    ImprovedMap,
    images_of,
    improve,
)
from solver.consistency.maps import CollectionMaps, CycleErrors, Pair, cycle_errors
from solver.consistency.paths import probable_paths

__all__ = [
    "DOUBTFUL",
    "CollectionMaps",
    "Consistency",
    "CycleErrors",
    "ImprovedMap",
    "Pair",
    "cycle_errors",
    "images_of",
    "improve",
    "probable_paths",
]
