"""Candidates of a partial registration: labellings of points of the part with points of the whole.

Section 4.1 of the paper without a hierarchy: a few points of the part, the best correspondences by
geodesic distance. Cuts lengthen shortest paths, but between most points little. The scale of the
part is not known: the labellings of several scales are taken. Where the surfaces only overlap,
points of the part may stay unmatched at a cost.

Each labelling of a part is aligned twice: by its points alone, and by all samples of the part, the
partner of each being as far from the labelled points. The former leaves more open, the latter is
misled where cuts lengthen shortest paths.

The best labellings of one problem are variants of a few: of the best 300 of three scales, 5 to 27
differ by 0.15 √area. So many are enumerated, and those that differ are tried.
"""

from collections.abc import Iterator

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.control import Control
from solver.functional_maps import FunctionalMap, nearest_points
from solver.labelling import UNMATCHED, LabellingProblem, pairs_with_landmarks
from solver.optimisation.exact import m_best_solutions
from solver.registration.alignment import Alignment, Pairs, WeightedBasis, fit_displacement
from solver.registration.candidates import FIRST_SIZE, MIN_POINTS, Points, first_ridge
from solver.registration.partial.alignment import PartSamples, fit_to_part
from solver.registration.partial.partiality import Labellings
from solver.registration.surface import Samples, SmoothSurface, smooth_surface
from solver.shape import Shape

_WHOLE_POINTS = 36
"""Points of the whole. A choice: the labels of each of 8 or 12 points of the part."""

_KNOWN = 100.0
"""What it earns to match a landmark: more than any distortion costs, so that none is unmatched."""

_NODES = 100_000
"""Search nodes: a fraction of a second. The labellings need not be proven the best."""


def labelled_points(
    whole: Shape, part: Shape, scale: float, how: Labellings, landmarks: Points, control: Control
) -> Iterator[Points]:
    """Yield corresponding vertices of the whole and of the part.

    Parameters
    ----------
    whole, part
        The shapes.
    scale
        √area of the whole in the part's unit.
    how
        What is tried.
    landmarks
        Vertices of the whole and of the part that correspond.
    control
        Cancels.
    """
    known = len(landmarks[0])
    count = min(max(how.points, known), part.n_vertices, whole.n_vertices)
    ours = part.sampling("geodesic", count, tuple(landmarks[1].tolist()))
    others = min(max(_WHOLE_POINTS, known), whole.n_vertices)
    theirs = whole.sampling("geodesic", others, tuple(landmarks[0].tolist()))
    candidates = np.argwhere(pairs_with_landmarks(count, others, known))
    distances: FloatArray = ours.distances / (part.size * scale)
    unit = float(np.sqrt((distances**2).sum() / (count * (count - 1)))) or 1.0
    changes = _changes_of_curvature(whole, part, (theirs.indices, ours.indices), scale)
    for occlusion_cost, curvature in how.costs:
        problem = LabellingProblem(
            candidates,
            curvature * changes[*candidates.T] - _KNOWN * (candidates[:, 0] < known),
            distances / unit,
            theirs.distances / (whole.size * unit),
            2.0 / (count - 1),
            occlusion_cost,
        )
        found = m_best_solutions(problem, how.count, node_limit=_NODES, control=control)
        for partners in _tried(found.partners, how, theirs.distances / whole.size):
            matched = partners != UNMATCHED
            if matched.sum() >= MIN_POINTS:
                yield theirs.indices[partners[matched]], ours.indices[matched]


def _tried(labellings: IntArray, how: Labellings, distances: FloatArray) -> IntArray:
    """(T, n) the best of labellings, and of the others those that differ.

    Parameters
    ----------
    labellings
        (K, n) partners, the best first.
    how
        How many, and by how much.
    distances
        (m, m) between points of the whole. A point that one of two labellings leaves unmatched
        counts as much as one with unrelated partners.
    """
    # UNMATCHED is -1: it finds the last row and column.
    between = np.pad(distances, (0, 1), constant_values=distances.mean())
    between[UNMATCHED, UNMATCHED] = 0.0
    chosen = np.empty_like(labellings)
    count = 0
    for number, one in enumerate(labellings):
        if number < how.best or (between[one, chosen[:count]].mean(axis=1) > how.apart).all():
            chosen[count] = one
            count += 1
    return chosen[:count]


def _changes_of_curvature(whole: Shape, part: Shape, points: Points, scale: float) -> FloatArray:
    """(n, m) mean change of the standardised curvature from n points of a part to m of a whole."""
    bent, fixed = smooth_surface(whole), smooth_surface(part)
    here = fixed.averages.standardised_by(bent.averages, scale, points[1])
    there = bent.averages.standardised[points[0]]
    changes: FloatArray = np.abs(here[:, None] - there).mean(axis=2)
    return changes


def first_alignment(
    whole: SmoothSurface, part: SmoothSurface, points: Points, scale: float
) -> Alignment:
    """Displace the whole so that given points correspond."""
    here, there = points
    k = min(FIRST_SIZE, whole.samples.size)
    weights = np.full((len(here), 1), 1.0 / len(here))
    coefficients, turn = fit_displacement(
        WeightedBasis(whole.spectrum.eigenfunctions[here, :k], weights),
        whole.samples.coefficients[:k],
        part.mesh.vertices[there],
        first_ridge(whole.samples.eigenvalues[:k]),
        scale,
    )
    return Alignment(coefficients, FunctionalMap(np.empty((0, k))), turn)


def alignment_by_distances(
    shapes: tuple[Shape, Shape], samples: tuple[Samples, PartSamples], points: Points, scale: float
) -> Alignment:
    """Displace the whole so that points as far from given ones on both surfaces correspond.

    Parameters
    ----------
    shapes
        The whole and the part.
    samples
        Of both. Each of the part has as partner that of the whole whose geodesic distances to the
        given points are nearest to its own.
    points
        Vertices of the whole and of the part that correspond.
    scale
        √area of the whole in the part's unit.
    """
    (whole, part), (ours, theirs) = shapes, samples
    here, there = (
        (shape.metric("geodesic").distances(vertices)[:, one.vertices].T / unit).astype(np.float32)
        for shape, one, vertices, unit in (
            (whole, ours, points[0], whole.size),
            (part, theirs, points[1], part.size * scale),
        )
    )
    pairs = Pairs.of_part(nearest_points(there, here), len(ours))
    return fit_to_part(ours, theirs, pairs, scale, FIRST_SIZE)
