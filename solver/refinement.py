"""Sub-vertex refinement of a correspondence by GMDS, section 7.1.

The report proposes to begin GMDS (7) where discrete matching ended. Two things are changed, because
as it stands the stress is no smaller at the truth than beside it: bodies are isometric only nearly,
and what bending does to the distance of two far points moves both. So near distances count most,
and only those of neighbours at all; and further points between the matched ones tie these to one
another. All of them begin where a dense map of the correspondence's hypotheses carries them.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.control import Control
from solver.dense import dense_map
from solver.gmds import InterpolatedMetric, Status, SurfacePoints, Term, gmds
from solver.metrics import EmbeddedMetric
from solver.sampling import farthest_point_sampling
from solver.shape import Shape

_POINTS = 320
"""Points that move, at least: the matched ones and others spread between them."""

_NEIGHBOURS = 20
_NEAR = 0.02
"""Distances below count alike, in units of √area."""

_SWEEPS = 8
_HYPOTHESES = 4


@dataclass(frozen=True, eq=False)
class Refinement:
    """Where matched points lie on the target's surface, between its vertices.

    Parameters
    ----------
    source
        (n,) vertices of X.
    points
        n points of Y's surface, faces and barycentric coordinates.
    hypothesis
        Which of the given correspondences they came from.
    stress, initial_stress
        (7), weighted, after and before GMDS, among these and the points between them, in units of
        Y's area.
    status
        Why GMDS ended.
    """

    source: IntArray
    points: SurfacePoints
    hypothesis: int
    stress: float
    initial_stress: float
    status: Status


def refine_by_gmds(
    source: Shape,
    target: Shape,
    hypotheses: Sequence[tuple[IntArray, IntArray]],
    control: Control | None = None,
) -> Refinement:
    """Find the points of Y that correspond to matched points of X, between vertices.

    Parameters
    ----------
    source, target
        The shapes X and Y.
    hypotheses
        (n,) vertices of X and (n,) vertices of Y that correspond, farthest first; the answer to be
        refined and what else it could be. At most four are looked at.
    control
        Cancels, and ends at its deadline.

    Returns
    -------
    Refinement
        Of the points of the first hypothesis.

    Raises
    ------
    Cancelled
        Through `control`.
    ValueError
        There is no hypothesis, or one of less than three points.
    """
    dense = dense_map(source, target, hypotheses[:_HYPOTHESES], control)
    matched = hypotheses[0][0]
    in_space = EmbeddedMetric(source.surface.vertices)
    between = farthest_point_sampling(in_space, min(_POINTS, source.n_vertices)).indices
    moving = np.concatenate([matched, between[~np.isin(between, matched)]])
    moving = moving[: max(_POINTS, len(matched))]
    # The target's unit of length serves both: without normalisation, scales may differ.
    scale = np.sqrt(target.mesh.area / source.mesh.area) * source.unit / target.unit
    distances = source.metric("geodesic").between(moving) * scale
    term = Term(
        distances,
        InterpolatedMetric(target.metric("geodesic"), target.surface),
        _weights(distances, _NEAR * np.sqrt(target.mesh.area) / target.unit),
    )
    start = SurfacePoints.at_vertices(target.surface, dense.images(moving))
    solution = gmds([term], start, iterations=_SWEEPS, control=control)
    area = target.mesh.area / target.unit**2
    return Refinement(
        matched,
        solution.points.first(len(matched)),
        dense.hypothesis,
        solution.stress / area,
        solution.initial_stress / area,
        solution.status,
    )


def _weights(distances: FloatArray, near: float) -> FloatArray:
    """(N, N) inverse distances among neighbours, 0 otherwise; scaled to a mean of 1 of these."""
    count = min(_NEIGHBOURS, len(distances) - 1)
    reach = np.sort(distances, axis=1)[:, count]
    close = distances <= np.maximum(reach[:, None], reach[None, :])
    weights: FloatArray = np.where(close, 1.0 / np.maximum(distances, near), 0.0)
    np.fill_diagonal(weights, 0.0)
    weights /= weights[weights > 0.0].mean()
    return weights
