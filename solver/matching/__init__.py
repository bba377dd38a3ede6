"""Matching of two shapes (4.1): sample, enumerate, refine, orient, certify."""

from solver.matching.certification import certify
from solver.matching.enumeration import enumerate_hypotheses
from solver.matching.hierarchy import refine, rematch
from solver.matching.hypothesis import (
    Hypothesis,
    drop_duplicates,
    move_to_front,
)
from solver.matching.level import Level, SampledStructure
from solver.matching.match import match
from solver.matching.options import (
    CANDIDATES,
    COARSE_POINTS,
    MAX_COARSE_POINTS,
    MAX_POINTS,
    MIN_POINTS,
    PARTS,
    SAMPLES,
    MatchOptions,
)
from solver.matching.placement import add_target_samples, match_near_images
from solver.matching.refinement import hypothesis_from_map, refine_hypotheses
from solver.matching.relation import Relation, relation
from solver.matching.report import cut_short, report_match
from solver.matching.result import (
    Correspondence,
    GromovHausdorff,
    Match,
    Overlap,
    SampleProof,
)
from solver.matching.sampling import level_sizes
from solver.matching.stages import Stages
from solver.matching.structures import build_level, check_colors, check_distances
from solver.matching.third_order import ThirdOrderTerm
from solver.matching.varadhan_level import (
    add_varadhan_size,
    build_varadhan_level,
    uses_varadhan_level,
)

__all__ = [
    "CANDIDATES",
    "COARSE_POINTS",
    "MAX_COARSE_POINTS",
    "MAX_POINTS",
    "MIN_POINTS",
    "PARTS",
    "SAMPLES",
    "Correspondence",
    "GromovHausdorff",
    "Hypothesis",
    "Level",
    "Match",
    "MatchOptions",
    "Overlap",
    "Relation",
    "SampleProof",
    "SampledStructure",
    "Stages",
    "ThirdOrderTerm",
    "add_target_samples",
    "add_varadhan_size",
    "build_level",
    "build_varadhan_level",
    "certify",
    "check_colors",
    "check_distances",
    "cut_short",
    "drop_duplicates",
    "enumerate_hypotheses",
    "hypothesis_from_map",
    "level_sizes",
    "match",
    "match_near_images",
    "move_to_front",
    "refine",
    "refine_hypotheses",
    "relation",
    "rematch",
    "report_match",
    "uses_varadhan_level",
]
