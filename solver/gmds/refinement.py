"""Section 7.1: refinement of a correspondence to positions between vertices, by GMDS.

The report proposes to begin GMDS (7) where discrete matching ended. As it stands, the stress is no
smaller at the truth than beside it: bodies are only nearly isometric, and what bending does to the
distance of two far points moves both. Two things are therefore changed. Only distances between
neighbours count, the shortest most; and further points between the matched ones are moved with
them. All points begin where the dense map puts them. Then diffusion distances at a short time,
between all points, are added, both kinds of stress being weighted by the inverse of what is left of
them, as their errors have little to do with one another.
"""

from dataclasses import dataclass, replace

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.control import Control, Status
from solver.gmds.descent import Term, gmds
from solver.gmds.interpolation import InterpolatedMetric
from solver.gmds.surface import SurfacePoints
from solver.registration import EIGENPAIRS, Registration
from solver.shape import DiffusionMetric, EmbeddedMetric, Shape, farthest_point_sampling

_POINTS = 320
"""Least number of moving points, the matched ones included."""

_NEIGHBOURS = 20
"""Nearest points whose geodesic distances count."""

_NEAR = 0.02
"""Distance below which all have the same weight, in units of √area."""

_DIFFUSION_TIME = 0.002
"""Time of the diffusion distances on unit area. Shorter times distinguish points more sharply, and
add local minima."""

_LEAST_STRESS = 1e-12
"""Least stress that is inverted, on unit area; between equal shapes it vanishes."""

_SWEEPS = 8
"""Sweeps of each of the two descents. ``python -m bench.refinement`` measures their effect."""


@dataclass(frozen=True, eq=False)
class GmdsRefinement:
    """Positions of matched points on the target's surface, between its vertices.

    Parameters
    ----------
    source
        (n,) vertices of X.
    points
        n points of Y's surface, faces and barycentric coordinates.
    stress, initial_stress
        (7) of geodesic distances between neighbours among all moving points, weighted, after and
        before GMDS, in units of Y's area.
    status
        Why GMDS ended.
    hypothesis
        Index of the hypothesis that agrees with the registration, by default the first.
    """

    source: IntArray
    points: SurfacePoints
    stress: float
    initial_stress: float
    status: Status
    hypothesis: int = 0


def refine_by_gmds(
    registration: Registration, matched: IntArray, control: Control
) -> GmdsRefinement:
    """Find the points of Y that correspond to matched points of X, between vertices.

    Parameters
    ----------
    registration
        Of X to Y, which gives the initial points.
    matched
        (n,) vertices of X, farthest first.
    control
        Cancels, and ends at its deadline.

    Raises
    ------
    Cancelled
        Through `control`.
    """
    source, target = registration.source, registration.target
    in_space = EmbeddedMetric(source.surface.vertices)
    between = farthest_point_sampling(in_space, min(_POINTS, source.n_vertices)).indices
    moving = np.concatenate([matched, between[~np.isin(between, matched)]])
    moving = moving[: max(_POINTS, len(matched))]
    near = _geodesic_term(source, target, moving)
    start = SurfacePoints.at_vertices(target.surface, registration.images(moving, control))
    before = near.stress(start)
    first = gmds([near], start, iterations=_SWEEPS, control=control)
    terms = near, _diffusion_term(source, target, moving)
    both = [_normalised(term, first.answer) for term in terms]
    solution = gmds(both, first.answer, iterations=_SWEEPS, control=control)
    # Between equal shapes the stress vanishes, and rounding errors may raise it.
    ends = [(points, near.stress(points)) for points in (solution.answer, first.answer, start)]
    points, after = next(end for end in ends if end[1] <= before)
    return GmdsRefinement(matched, points.first(len(matched)), after, before, solution.status)


def _geodesic_term(source: Shape, target: Shape, points: IntArray) -> Term:
    """Stress of geodesic distances between neighbours, in units of the target's area."""
    # The target's unit of length serves both: without normalisation, scales may differ.
    distances = source.metric("geodesic").between(points) * (target.size / source.size)
    return Term(
        distances,
        InterpolatedMetric(target.metric("geodesic"), target.surface),
        _weights(distances, _NEAR * target.size) / target.size**2,
    )


def _diffusion_term(source: Shape, target: Shape, points: IntArray) -> Term:
    """Stress of diffusion distances, with weights that fall with the distance."""
    here, there = (
        DiffusionMetric(shape.unit_spectrum(EIGENPAIRS), _DIFFUSION_TIME)
        for shape in (source, target)
    )
    distances = here.between(points)
    unit = float(np.sqrt((distances**2).mean()))
    return Term(
        distances,
        InterpolatedMetric(there, target.surface),
        (1.0 + distances / unit) ** -2.0,
    )


def _normalised(term: Term, points: SurfacePoints) -> Term:
    """Return the term in units of its stress at some points."""
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
