"""Lower bounds of the labelling problem by dual decomposition (section 4).

The energy is split into subproblems, each of which is easy: a **linear** one, the assignment
without pairwise costs; **pairs** of source points, or of target points, with all their candidates,
and **triples** that have third-order costs; and a **maxflow** one, all pairwise costs without
constraints. Every cost is divided among the subproblems that have it. For any division, the minima
of the subproblems add up to a lower bound; a projected subgradient method maximises it. Matches
take all but the maxflow one, which serves comparisons (``python -m bench.solver``).

After Torresani, Kolmogorov and Rother, "Feature correspondence via graph matching: models and
global optimization", ECCV 2008. Pairs of both shapes, which exchange shares of each pairwise cost,
go beyond that: they make the bound tight on dense non-negative distortions.
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
from solver.optimisation.dual_decomposition.subgradient import DualDecomposition, DualState
from solver.optimisation.dual_decomposition.triples import TripleSubproblems, triples_of

__all__ = [
    "DualDecomposition",
    "DualState",
    "MaxflowSubproblem",
    "PairSubproblems",
    "Subproblems",
    "TripleSubproblems",
    "full_costs",
    "full_groups",
    "sides_of",
    "sparse_groups",
    "triples_of",
]
