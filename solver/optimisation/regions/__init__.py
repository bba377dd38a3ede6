"""Branch and bound over regions of correspondences: proofs over thousands of candidates."""

from solver.optimisation.regions.prove import can_prove, prove
from solver.optimisation.regions.search import RegionSearch

__all__ = ["RegionSearch", "can_prove", "prove"]
