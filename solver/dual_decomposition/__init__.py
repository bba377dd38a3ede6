"""Lower bounds of the labelling problem by dual decomposition (section 4).

The energy is split into subproblems that are easy one by one: a **linear** one, the assignment
without pairwise costs, and **local** ones, each on two source points or on two target points with
all their candidates. Every unary cost is divided among the subproblems its candidate is in, every
pairwise cost between the one pair of source points and the one pair of target points it belongs
to. Whatever the division, the subproblems' minima sum up to a lower bound; a projected subgradient
method looks for the division whose bound is greatest.

After Torresani, Kolmogorov and Rother, "Feature correspondence via graph matching: models and
global optimization", ECCV 2008. Local subproblems on both sides, linked by the shares of each
pairwise cost, go beyond that: on dense non-negative distortions they are what makes the bound
tight.
"""

from solver.dual_decomposition.subgradient import dual_decomposition

__all__ = ["dual_decomposition"]
