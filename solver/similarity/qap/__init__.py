"""Bijections of least distortion between sets of a few points, of many pairs of shapes at once.

The problem is (5) with N points on either side, all of them matched, and all pairs candidates: the
quadratic assignment problem. A dissimilarity matrix solves it hundreds of thousands of times, so
here is a branch and bound for nothing else, which allocates next to no memory within a batch.
"""

from solver.similarity.qap.batch import Bijections, least_distortions

__all__ = ["MAX_POINTS", "Bijections", "least_distortions"]

MAX_POINTS = 10
"""Most points that a bijection is searched of: no search visits more than ten million nodes."""
