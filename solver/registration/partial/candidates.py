"""Candidates of a partial registration: labellings of points of the part with points of the whole.

Section 4.1 of the paper without a hierarchy: a few points of the part, the best correspondences by
geodesic distance. Cuts lengthen shortest paths, but between most points little. The scale of the
part is not known: the labellings of several scales are taken.
"""

from collections.abc import Iterator

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.control import Control
from solver.functional_maps import FunctionalMap
from solver.labelling import LabellingProblem
from solver.optimisation.exact import m_best_solutions
from solver.registration.alignment import Alignment
from solver.registration.partial.alignment import fit_displacement
from solver.registration.surface import SmoothSurface
from solver.shape import Shape

_POINTS, _WHOLE_POINTS = 8, 36
"""Points of the part and of the whole. With fourteen of the part, more answers are wrong."""

_SOLUTIONS = 100
"""Labellings of each scale. Three times as many find no more right answers."""

_NODES = 100_000
"""Search nodes: a fraction of a second. The labellings need not be proven the best."""

SHARES = (0.35, 0.55, 0.85)
"""Shares of the whole's area that the part is taken to have: scales a quarter apart."""

_SIZE = 12
"""Eigenfunctions of the first displacement."""

_RIDGE = 0.1
"""Ridge of the first displacement, which few points determine."""


def labelled_points(
    whole: Shape, part: Shape, scale: float, control: Control
) -> Iterator[tuple[IntArray, IntArray]]:
    """Yield corresponding vertices of the whole and of the part.

    Parameters
    ----------
    whole, part
        The shapes.
    scale
        √area of the whole in the part's unit.
    control
        Cancels.
    """
    count = min(_POINTS, part.n_vertices, whole.n_vertices)
    ours = part.sampling("geodesic", count)
    theirs = whole.sampling("geodesic", min(_WHOLE_POINTS, whole.n_vertices))
    distances: FloatArray = ours.distances / (part.size * scale)
    unit = float(np.sqrt((distances**2).sum() / (count * (count - 1)))) or 1.0
    problem = LabellingProblem(
        np.argwhere(np.ones((count, len(theirs)), dtype=np.bool_)),
        np.zeros(count * len(theirs)),
        distances / unit,
        theirs.distances / (whole.size * unit),
        2.0 / (count - 1),
        np.inf,
    )
    found = m_best_solutions(problem, _SOLUTIONS, node_limit=_NODES, control=control)
    for partners in found.partners:
        yield theirs.indices[partners], ours.indices


def first_alignment(
    whole: SmoothSurface, part: SmoothSurface, points: tuple[IntArray, IntArray], scale: float
) -> Alignment:
    """Displace the whole so that given points correspond."""
    here, there = points
    k = min(_SIZE, whole.samples.size)
    values = whole.samples.eigenvalues[:k]
    coefficients, turn = fit_displacement(
        whole.samples,
        whole.spectrum.eigenfunctions[here, :k],
        part.mesh.vertices[there],
        np.full((len(here), 1), 1.0 / len(here)),
        scale,
        _RIDGE * values / max(float(values[-1]), 1e-300),
    )
    return Alignment(coefficients, FunctionalMap(np.empty((0, k))), turn)
