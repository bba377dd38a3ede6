"""Matching with a prototype by likelihood (section 5)."""

from solver.prototype.matching.level import (
    PrototypeLevel,
    mean_distances,
    negative_log_likelihoods,
)
from solver.prototype.matching.match import match_prototype
from solver.prototype.matching.sampling import sample_in_turn, sample_target
from solver.prototype.matching.surface_maps import MappedPoints, map_points

__all__ = [
    "MappedPoints",
    "PrototypeLevel",
    "map_points",
    "match_prototype",
    "mean_distances",
    "negative_log_likelihoods",
    "sample_in_turn",
    "sample_target",
]
