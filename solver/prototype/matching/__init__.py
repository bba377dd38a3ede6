"""Matching with a prototype by likelihood, section 5."""

from solver.prototype.matching.likelihood import (
    PrototypeLevel,
    mean_distances,
    negative_log_likelihoods,
)
from solver.prototype.matching.matching import PrototypeRun, match_prototype, samples_by_turns
from solver.prototype.matching.orientation import CERTAIN, CLEAR, OrientedImages, oriented_images

__all__ = [
    "CERTAIN",
    "CLEAR",
    "OrientedImages",
    "PrototypeLevel",
    "PrototypeRun",
    "match_prototype",
    "mean_distances",
    "negative_log_likelihoods",
    "oriented_images",
    "samples_by_turns",
]
