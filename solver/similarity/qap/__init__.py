"""Quadratic assignment of a few points (section 6.2), for many pairs of shapes at once.

The quadratic assignment problem is (5) with N points on either side, all of which are matched, and
all pairs as candidates. A dissimilarity matrix solves it hundreds of thousands of times; this
branch and bound is specialised to it, and allocates next to no memory within a batch.
"""

from solver.similarity.qap.batch import QapSolutions, least_distortions

__all__ = ["MAX_POINTS", "QapSolutions", "least_distortions"]

MAX_POINTS = 10
"""Most points of a problem: no search visits more than ten million nodes."""
