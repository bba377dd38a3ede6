"""Primal heuristics, correspondences without a bound: assignment, local search, fusion."""

from solver.optimisation.primal.assignment import (
    InfeasibleError,
    assignment_costs,
    maximum_matching,
    solve_lap,
)
from solver.optimisation.primal.fusion import fuse
from solver.optimisation.primal.incumbent import Incumbent, improved
from solver.optimisation.primal.iterated_local_search import IteratedLocalSearch
from solver.optimisation.primal.local_search import local_search, partners_of

__all__ = [
    "Incumbent",
    "InfeasibleError",
    "IteratedLocalSearch",
    "assignment_costs",
    "fuse",
    "improved",
    "local_search",
    "maximum_matching",
    "partners_of",
    "solve_lap",
]
