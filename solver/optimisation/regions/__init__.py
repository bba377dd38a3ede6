"""Branch and bound over regions of correspondences: proofs over thousands of candidates."""

from solver.optimisation.regions.prove import can_prove, prove
from solver.optimisation.regions.search import RegionSearch, RegionSearchState

__all__ = ["RegionSearch", "RegionSearchState", "can_prove", "prove"]
