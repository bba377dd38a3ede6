"""Correspondences without proof: rounding, local search and fusion."""

from solver.optimisation.primal.fusion import fuse
from solver.optimisation.primal.iterated_local_search import IteratedLocalSearch
from solver.optimisation.primal.local_search import (
    InfeasibleError,
    assign,
    assignment_costs,
    local_search,
    partners_of,
)

__all__ = [
    "InfeasibleError",
    "IteratedLocalSearch",
    "assign",
    "assignment_costs",
    "fuse",
    "local_search",
    "partners_of",
]
