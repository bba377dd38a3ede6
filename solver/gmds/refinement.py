"""Sub-vertex refinement of a correspondence by GMDS, section 7.1.

The report proposes to begin GMDS (7) where discrete matching ended. Two things are changed, because
as it stands the stress is no smaller at the truth than beside it: bodies are isometric only nearly,
and what bending does to the distance of two far points moves both. So near distances count most,
and only those of neighbours at all; and further points between the matched ones tie these to one
another. All of them begin where a dense map of the correspondence's hypotheses carries them. Where
near distances leave them, diffusion distances at a short time, between all, join in, each kind of
stress in units of what is left of it: the errors of the two have little to do with one another.
"""

from dataclasses import dataclass, replace

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.control import Control
from solver.functional_maps import EIGENPAIRS, DenseMap
from solver.gmds.descent import Status, Term, gmds
from solver.gmds.interpolation import InterpolatedMetric
from solver.gmds.surface import SurfacePoints
from solver.shape import DiffusionMetric, EmbeddedMetric, Shape, farthest_point_sampling

_POINTS = 320
"""Points that move, at least: the matched ones and others spread between them."""

_NEIGHBOURS = 20
_NEAR = 0.02
"""Distances below count alike, in units of √area."""

_DIFFUSION_TIME = 0.002
"""On unit area. The shorter, the more sharply are points told apart, and the more false minima
there are."""

_LEAST_STRESS = 1e-12
"""What is left of the stress between equal shapes."""

_SWEEPS = 8


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
        (7) of near geodesic distances, weighted, after and before GMDS, among these and the points
        between them, in units of Y's area.
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
    dense: DenseMap, matched: IntArray, control: Control | None = None
) -> Refinement:
    """Find the points of Y that correspond to matched points of X, between vertices.

    Parameters
    ----------
    dense
        What carries points of X over to Y, to begin with.
    matched
        (n,) vertices of X, farthest first.
    control
        Cancels, and ends at its deadline.

    Raises
    ------
    Cancelled
        Through `control`.
    """
    source, target = dense.source, dense.target
    in_space = EmbeddedMetric(source.surface.vertices)
    between = farthest_point_sampling(in_space, min(_POINTS, source.n_vertices)).indices
    moving = np.concatenate([matched, between[~np.isin(between, matched)]])
    moving = moving[: max(_POINTS, len(matched))]
    near = _near(source, target, moving)
    start = SurfacePoints.at_vertices(target.surface, dense.images(moving))
    before = near.stress(start)
    first = gmds([near], start, iterations=_SWEEPS, control=control)
    both = [_levelled(term, first.points) for term in (near, _diffuse(source, target, moving))]
    solution = gmds(both, first.points, iterations=_SWEEPS, control=control)
    # Rounding alone may raise a stress of nothing, between equal shapes.
    ends = [(points, near.stress(points)) for points in (solution.points, first.points, start)]
    points, after = next(end for end in ends if end[1] <= before)
    area = target.size**2
    return Refinement(
        matched,
        points.first(len(matched)),
        dense.hypothesis,
        after / area,
        before / area,
        solution.status,
    )


def _near(source: Shape, target: Shape, points: IntArray) -> Term:
    """Stress of geodesic distances between neighbours."""
    # The target's unit of length serves both: without normalisation, scales may differ.
    distances = source.metric("geodesic").between(points) * (target.size / source.size)
    return Term(
        distances,
        InterpolatedMetric(target.metric("geodesic"), target.surface),
        _weights(distances, _NEAR * target.size),
    )


def _diffuse(source: Shape, target: Shape, points: IntArray) -> Term:
    """Stress of diffusion distances, far ones by and by counting less."""
    here, there = (
        DiffusionMetric(shape.spectrum(EIGENPAIRS).scaled(1.0 / shape.size), _DIFFUSION_TIME)
        for shape in (source, target)
    )
    distances = here.between(points)
    unit = float(np.sqrt((distances**2).mean()))
    return Term(
        distances,
        InterpolatedMetric(there, target.surface),
        (1.0 + distances / unit) ** -2.0,
    )


def _levelled(term: Term, points: SurfacePoints) -> Term:
    """Return the stress in units of what it is at some points."""
    return replace(term, weights=term.weights / max(term.stress(points), _LEAST_STRESS))


def _weights(distances: FloatArray, near: float) -> FloatArray:
    """(N, N) inverse distances among neighbours, 0 otherwise; scaled to a mean of 1 of these."""
    count = min(_NEIGHBOURS, len(distances) - 1)
    reach = np.sort(distances, axis=1)[:, count]
    close = distances <= np.maximum(reach[:, None], reach[None, :])
    weights: FloatArray = np.where(close, 1.0 / np.maximum(distances, near), 0.0)
    np.fill_diagonal(weights, 0.0)
    weights /= weights[weights > 0.0].mean()
    return weights
