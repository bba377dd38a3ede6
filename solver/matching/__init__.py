"""Matching of two shapes, section 4.1: from an exact coarse level to the finest, certified."""

from solver.matching.hierarchy import refine, rematch
from solver.matching.hypotheses import HierarchicalRun, Hypothesis, Stage, distinct, level_reports
from solver.matching.level import (
    Level,
    SampledStructure,
    build_level,
    check_distances,
    level_sizes,
    sizes_between,
)
from solver.matching.match import match
from solver.matching.options import GMDS, MAX_COARSE_POINTS, MAX_POINTS, MIN_POINTS, MatchOptions
from solver.matching.placement import at_images, with_images
from solver.matching.result import Correspondence, LevelReport, Match
from solver.matching.varadhan_level import deciding_level, is_decided, with_deciding_size
from solver.matching.verification import Witnesses, verified

__all__ = [
    "GMDS",
    "MAX_COARSE_POINTS",
    "MAX_POINTS",
    "MIN_POINTS",
    "Correspondence",
    "HierarchicalRun",
    "Hypothesis",
    "Level",
    "LevelReport",
    "Match",
    "MatchOptions",
    "SampledStructure",
    "Stage",
    "Witnesses",
    "at_images",
    "build_level",
    "check_distances",
    "deciding_level",
    "distinct",
    "is_decided",
    "level_reports",
    "level_sizes",
    "match",
    "refine",
    "rematch",
    "sizes_between",
    "verified",
    "with_deciding_size",
    "with_images",
]
