"""Exact search: branch and bound of the energy (5), and the minimax of section 2."""

from solver.optimisation.exact.branch_and_bound import FEW_POINTS, Enumeration, m_best_solutions
from solver.optimisation.exact.depth_first import NODES_PER_STEP, DepthFirstSearch
from solver.optimisation.exact.dual_ascent import AscentState, DualAscent, divided_costs
from solver.optimisation.exact.incumbents import Incumbents, dive, energy_of, keep
from solver.optimisation.exact.minimax import (
    gromov_hausdorff_distance,
    minimax_correspondence,
    within_distortion,
)
from solver.optimisation.exact.search_state import NODES, start_search
from solver.optimisation.exact.triple_division import divide_triples

__all__ = [
    "FEW_POINTS",
    "NODES",
    "NODES_PER_STEP",
    "AscentState",
    "DepthFirstSearch",
    "DualAscent",
    "Enumeration",
    "Incumbents",
    "dive",
    "divide_triples",
    "divided_costs",
    "energy_of",
    "gromov_hausdorff_distance",
    "keep",
    "m_best_solutions",
    "minimax_correspondence",
    "start_search",
    "within_distortion",
]
