"""Lower bounds of the labelling problem by dual decomposition (section 4).

The energy is split into subproblems that are easy one by one: a **linear** one, the assignment
without pairwise costs; **local** ones, each on two source points or on two target points with all
their candidates, and on three where pairs disagree; and a **maxflow** one, all pairwise costs
without constraints. Every cost is divided among the subproblems that have it. Whatever the
division, the subproblems' minima sum up to a lower bound; a projected subgradient method looks for
the division whose bound is greatest.

After Torresani, Kolmogorov and Rother, "Feature correspondence via graph matching: models and
global optimization", ECCV 2008. Local subproblems on both sides, linked by the shares of each
pairwise cost, go beyond that: on dense non-negative distortions they are what makes the bound
tight.
"""

from solver.optimisation.dual_decomposition.groups import (
    full_costs,
    full_groups,
    sides_of,
    sparse_groups,
)
from solver.optimisation.dual_decomposition.maxflow import MaxflowSubproblem
from solver.optimisation.dual_decomposition.pairs import PairSubproblems
from solver.optimisation.dual_decomposition.relaxation import Subproblems
from solver.optimisation.dual_decomposition.subgradient import (
    DualDecomposition,
    DualState,
    dual_decomposition,
)
from solver.optimisation.dual_decomposition.triple_choice import choose_triples
from solver.optimisation.dual_decomposition.triples import TripleSubproblems

__all__ = [
    "DualDecomposition",
    "DualState",
    "MaxflowSubproblem",
    "PairSubproblems",
    "Subproblems",
    "TripleSubproblems",
    "choose_triples",
    "dual_decomposition",
    "full_costs",
    "full_groups",
    "sides_of",
    "sparse_groups",
]
