"""Candidates of a registration: pairs from matched points, signs of eigenfunctions, or a rotation.

A coarse correspondence is decided at extremities, and an intrinsic symmetry of one half of a body
changes it little. So all good ones are taken, and to those are added all choices of signs of the
first eigenfunctions: those of isometric shapes agree up to signs, and an intrinsic symmetry is a
change of signs (Ovsjanikov, Sun, Guibas: "Global intrinsic symmetries of shapes", CGF 27(5), 2008).
Where handles differ, as those of scanned bones do, eigenfunctions do not agree; a rotation in space
is tried for shapes that are in the same pose.
"""

from collections.abc import Iterable, Iterator, Sequence
from itertools import product

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.functional_maps import FunctionalMap, fit_orthonormal_map, mutual_nearest_points
from solver.registration.alignment import (
    GLOBAL,
    LEAST_RIDGE_OF_FEW,
    Alignment,
    Pairs,
    WeightedBasis,
    embedding,
    fit_displacement,
    rotation_onto,
)
from solver.registration.surface import Samples, SmoothSurface

Points = tuple[IntArray, IntArray]
"""(n,) vertices of X and (n,) vertices of Y that correspond."""

NO_LANDMARKS: Points = (np.empty(0, dtype=np.int64), np.empty(0, dtype=np.int64))

MIN_POINTS = 3
"""Least number of corresponding points that say how a surface lies in space."""

FEWEST = 4
"""Least number of eigenfunctions that do: the constant one, and one for each dimension."""

FIRST_SIZE = 12
"""Eigenfunctions of the first displacement: torso and limbs of a body."""

_FIRST_RIDGE = 0.1
"""Ridge of the first displacement, over that of its last eigenfunction."""

_SIGNED = 6
"""First eigenfunctions all of whose signs are tried: 2⁶ candidates."""

_TURNS = 8
"""Rounds of rotating the source onto its nearest neighbours."""


def first_pairs(
    surfaces: tuple[SmoothSurface, SmoothSurface],
    samples: tuple[Samples, Samples],
    hypotheses: Sequence[Points],
) -> Iterator[Pairs]:
    """Yield the first pairs of each candidate.

    Parameters
    ----------
    surfaces, samples
        The surfaces X and Y, and S and M samples of them; the source may be reflected.
    hypotheses
        Corresponding vertices; those of less than `MIN_POINTS` points are skipped.

    Yields
    ------
    Pairs
        Of every hypothesis, every choice of signs, and the rotation in space that fits best.
    """
    for points in hypotheses:
        if len(points[0]) >= MIN_POINTS:
            yield pairs_from_points(surfaces, samples, points)
    count = 1 + min(_SIGNED, *(one.size - 1 for one in samples))
    for signs in _choices(count):
        yield _spectral_pairs(samples, np.diag(signs))
    yield _rotated(samples)


def exchanged_pairs(samples: tuple[Samples, Samples]) -> Iterator[Pairs]:
    """Yield the pairs of all choices of signs, with two successive eigenfunctions exchanged.

    Eigenfunctions of shapes that are not isometric may come in another order, as those of longer
    limbs have smaller eigenvalues.

    Parameters
    ----------
    samples
        Of X and Y.

    Yields
    ------
    Pairs
        Of every exchange of two of the first eigenfunctions but the constant one, and every choice
        of signs: 5 · 2⁶ where there are enough.
    """
    count = 1 + min(_SIGNED, *(one.size - 1 for one in samples))
    for place in range(1, count - 1):
        order = np.arange(count)
        order[[place, place + 1]] = place + 1, place
        for signs in _choices(count):
            yield _spectral_pairs(samples, np.diag(signs)[order])


def varied_pairs(
    samples: tuple[Samples, Samples], alignments: Iterable[Alignment]
) -> Iterator[Pairs]:
    """Yield the pairs of alignments, and of these with other signs of the first eigenfunctions.

    A map that is right on one half of a body, and exchanges the limbs of the other, is put right by
    the signs of some of the eigenfunctions.

    Parameters
    ----------
    samples
        Of X and Y.
    alignments
        The best so far.
    """
    for alignment in alignments:
        yield alignment.pairs(*samples, GLOBAL)
        matrix = alignment.functional_map.matrix
        count = min(1 + _SIGNED, len(matrix))
        for signs in _choices(count):
            if (signs < 0.0).any():
                yield _spectral_pairs(samples, matrix[:count, :count] * signs)


def _choices(count: int) -> Iterator[FloatArray]:
    """Yield all signs of the first eigenfunctions but the first, which is constant."""
    for signs in product((1.0, -1.0), repeat=count - 1):
        yield np.array((1.0, *signs))


def _spectral_pairs(samples: tuple[Samples, Samples], matrix: FloatArray) -> Pairs:
    """Nearest samples in the spectral embedding, under a small functional map."""
    source, target = samples
    ours = FunctionalMap(matrix).images(source.eigenfunctions).astype(np.float32)
    theirs = target.eigenfunctions[:, : len(matrix)].astype(np.float32)
    return Pairs.of_all(*mutual_nearest_points(ours, theirs))


def _rotated(samples: tuple[Samples, Samples]) -> Pairs:
    """Nearest samples of the source, rotated in space and not bent, and the target.

    Of the four rotations of principal axes onto one another, each improved by iterative closest
    points, the one that brings both nearest together: Besl and McKay, "A method for registration of
    3-D shapes", IEEE TPAMI 14(2), 1992.
    """
    (here, normals), (there, target_normals) = (one.smoothed(one.size) for one in samples)
    here, there = here - here.mean(axis=0), there - there.mean(axis=0)
    axes, target_axes = (np.linalg.svd(one, full_matrices=False)[2] for one in (here, there))
    embedded = embedding(there, target_normals, GLOBAL)
    found: list[tuple[float, Pairs]] = []
    for first, second in product((1.0, -1.0), repeat=2):
        third = first * second * np.linalg.det(axes) * np.linalg.det(target_axes)
        turn = (axes.T * (first, second, third)) @ target_axes
        for _ in range(_TURNS):
            turned = embedding(here @ turn, normals @ turn, GLOBAL)
            pairs = Pairs.of_all(*mutual_nearest_points(turned, embedded))
            turn = rotation_onto(here, pairs.partners(there, 3), pairs.weights)
        apart = (turned - embedded[pairs.images]) ** 2, (turned[pairs.back] - embedded) ** 2
        found.append((sum(float(one.sum(axis=1).mean()) for one in apart), pairs))
    return min(found, key=lambda one: one[0])[1]


def first_ridge(eigenvalues: FloatArray) -> FloatArray:
    """(k,) ridge of a first displacement, which few points determine.

    Parameters
    ----------
    eigenvalues
        (k,) first ones.
    """
    least = LEAST_RIDGE_OF_FEW
    return _FIRST_RIDGE * eigenvalues / max(float(eigenvalues[-1]), least) + least


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
    k = min(FIRST_SIZE, source.size, target.size)
    here, there = (
        surface.spectrum.eigenfunctions[vertices, :k]
        for surface, vertices in zip(surfaces, points, strict=True)
    )
    goals = there @ target.coefficients[:k]
    basis = WeightedBasis(here, np.full((len(here), 1), 1.0 / len(here)))
    ridge = first_ridge(source.eigenvalues[:k])
    coefficients, turn = fit_displacement(basis, source.coefficients[:k], goals, ridge)
    few = min(k, max(len(here) // 2, 1))
    functional = fit_orthonormal_map(here[:, :few], there[:, :few])
    return Alignment(coefficients, functional, turn).pairs(source, target, GLOBAL)
