"""Section 6.2: samples of one shape embedded into another by GMDS."""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import linear_sum_assignment

from solver.arrays import FloatArray, IntArray
from solver.control import Control
from solver.errors import OptionError
from solver.gmds.descent import Term, gmds
from solver.gmds.interpolation import InterpolatedMetric
from solver.gmds.surface import SurfacePoints
from solver.labelling import LabellingProblem, Solution
from solver.optimisation.exact import m_best_solutions
from solver.shape import Shape

_SAMPLES = 48
"""Samples of Y among which the initial points are chosen."""

_CANDIDATES = 6
"""Candidates of each sample of X: the samples of Y with the most similar histograms."""


@dataclass(frozen=True, eq=False)
class Embedding:
    """Samples of a shape X, and points of Y with distances like theirs.

    Parameters
    ----------
    vertices
        (N,) vertices of X, farthest first.
    solution
        Points of Y, and their stress.
    """

    vertices: IntArray
    solution: Solution[SurfacePoints]

    @property
    def distortion(self) -> float:
        """Root mean square distortion of a distance, in Y's unit of length."""
        count = len(self.vertices)
        return float(np.sqrt(2.0 * self.solution.value / max(count * (count - 1), 1)))


def embed(
    source: Shape,
    target: Shape,
    count: int,
    *,
    metric: InterpolatedMetric | None = None,
    control: Control | None = None,
) -> Embedding:
    """Embed samples of one shape into another with the least stress (7) of geodesic distances.

    As in the report's comparison, the descent begins where branch and bound finds the stress to be
    least among samples of Y whose local histograms of geodesic distances are like those of X's
    samples (Raviv, Bronstein, Bronstein and Kimmel, NORDIA 2007).

    Parameters
    ----------
    source, target
        The shapes X and Y, in the same unit of length.
    count
        Number N of samples of X.
    metric
        Geodesic metric on Y's surface, to be shared by several embeddings into Y.
    control
        Cancels, and ends at its deadline.

    Returns
    -------
    Embedding

    Raises
    ------
    Cancelled
        Through `control`.
    OptionError
        A shape has fewer vertices than samples are asked for.
    """
    if target.n_vertices < count:
        raise OptionError(
            "points", f"the shape has only {target.n_vertices} vertices; {count} were asked for"
        )
    sampling = source.sampling("geodesic", count)
    initial = _initial(source, target, sampling.indices, sampling.distances, control)
    metric = metric or InterpolatedMetric(target.metric("geodesic"), target.surface)
    start = SurfacePoints.at_vertices(target.surface, initial)
    term = Term(sampling.distances, metric, np.ones_like(sampling.distances))
    solution = gmds([term], start, control=control)
    return Embedding(sampling.indices, solution)


def _initial(
    source: Shape,
    target: Shape,
    vertices: IntArray,
    distances: FloatArray,
    control: Control | None,
) -> IntArray:
    """(N,) vertices of Y of least stress among samples with similar histograms."""
    samples = target.sampling("geodesic", min(max(_SAMPLES, len(vertices)), target.n_vertices))
    here = source.descriptor("geodesic_histogram", vertices)
    there = target.descriptor("geodesic_histogram", samples.indices)
    dissimilarity = np.linalg.norm(here[:, None] - there, axis=2)
    # Where points compete for too few candidates, more are tried. All samples suffice, and one
    # correspondence of those is known, in case the time is over.
    known = linear_sum_assignment(dissimilarity)[1]
    for count in (_CANDIDATES, 2 * _CANDIDATES, len(samples)):
        candidates = _most_similar(dissimilarity, count)
        problem = LabellingProblem(
            candidates, np.zeros(len(candidates)), distances, samples.distances
        )
        entire = count == len(samples)
        found = m_best_solutions(problem, known=known if entire else None, control=control)
        if len(found):
            break
    chosen: IntArray = samples.indices[found[0].answer]
    return chosen


def _most_similar(dissimilarity: FloatArray, count: int) -> IntArray:
    """(V, 2) candidates: the most similar samples of Y for each sample of X."""
    nearest = np.sort(np.argsort(dissimilarity, axis=1, kind="stable")[:, :count], axis=1)
    rows = np.repeat(np.arange(len(dissimilarity)), nearest.shape[1])
    return np.stack([rows, nearest.ravel()], axis=1).astype(np.int64)
