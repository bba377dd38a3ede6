"""Candidates of a registration: first images, from matched points or from the signs of eigenfunctions.

A coarse correspondence is decided at extremities, and an intrinsic symmetry of one half of a body
changes it little. So all good ones are taken, and to those are added all choices of signs of the
first eigenfunctions: those of isometric shapes agree up to signs, and an intrinsic symmetry is a
change of signs (Ovsjanikov, Sun, Guibas: "Global intrinsic symmetries of shapes", CGF 27(5), 2008).
"""

from collections.abc import Iterator, Sequence
from itertools import product

import numpy as np

from solver.arrays import IntArray
from solver.functional_maps import FunctionalMap, fit_orthonormal_map, mutual_nearest_points
from solver.registration.alignment import GLOBAL, Alignment, Pairs, rotation_onto
from solver.registration.surface import Samples, SmoothSurface

Points = tuple[IntArray, IntArray]
"""(n,) vertices of X and (n,) vertices of Y that correspond."""

MIN_POINTS = 3
"""Least number of corresponding points that say how a surface lies in space."""

_SIZE = 12
"""Eigenfunctions of the first displacement: torso and limbs of a body."""

_RIDGE = 0.1
"""Ridge of the first displacement, which few points determine."""

_SIGNED = 6
"""First eigenfunctions all of whose signs are tried: 2⁶ candidates."""


def first_pairs(
    surfaces: tuple[SmoothSurface, SmoothSurface],
    samples: tuple[Samples, Samples],
    hypotheses: Sequence[Points],
    signs: bool,
) -> Iterator[Pairs]:
    """Yield the first pairs of each candidate.

    Parameters
    ----------
    surfaces, samples
        The surfaces X and Y, and S and M samples of them; the source may be reflected.
    hypotheses
        Corresponding vertices; those of less than `MIN_POINTS` points are skipped.
    signs
        Whether to add the signs of eigenfunctions.

    Yields
    ------
    Pairs
    """
    source, target = samples
    for points in hypotheses:
        if len(points[0]) >= MIN_POINTS:
            yield pairs_from_points(surfaces, samples, points)
    if signs:
        count = min(_SIGNED, source.size - 1, target.size - 1)
        theirs = target.eigenfunctions.astype(np.float32)
        for chosen in product((1.0, -1.0), repeat=count):
            # The first eigenfunction is constant.
            start = FunctionalMap(np.diag((1.0, *chosen)))
            images = start.images(source.eigenfunctions).astype(np.float32)
            yield Pairs(*mutual_nearest_points(images, theirs[:, : count + 1]))


def pairs_from_points(
    surfaces: tuple[SmoothSurface, SmoothSurface],
    samples: tuple[Samples, Samples],
    points: Points,
) -> Pairs:
    """Nearest samples of the source displaced so that given points correspond, and the target.

    Parameters
    ----------
    surfaces, samples
        As for :func:`first_pairs`.
    points
        Corresponding vertices.
    """
    source, target = samples
    k = min(_SIZE, source.size, target.size)
    here, there = (
        surface.spectrum.eigenfunctions[vertices, :k]
        for surface, vertices in zip(surfaces, points, strict=True)
    )
    goals = there @ target.coefficients[:k]
    coefficients = source.coefficients[:k]
    turn = rotation_onto(here @ coefficients, goals, np.full((len(here), 1), 1.0 / len(here)))
    turned = coefficients @ turn
    decay = _RIDGE * source.eigenvalues[:k] / max(float(source.eigenvalues[k - 1]), 1e-300)
    gram = here.T @ here / len(here) + np.diag(decay + 1e-9)
    displacement = np.linalg.solve(gram, here.T @ (goals - here @ turned) / len(here))
    few = min(k, max(len(here) // 2, 1))
    functional = fit_orthonormal_map(here[:, :few], there[:, :few])
    return Alignment(turned + displacement, functional, turn).pairs(source, target, GLOBAL)
