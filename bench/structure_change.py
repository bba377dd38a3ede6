"""Change of a structure under a transformation, and accuracy of matches with it."""

import numpy as np
from scipy.spatial import KDTree

from bench.collection import Pair
from bench.correspondence import mean_errors
from solver.arrays import FloatArray, IntArray
from solver.matching import Level, MatchOptions, SampledStructure, match
from solver.optimisation.exact import m_best_solutions
from solver.shape.choices import (
    DESCRIPTORS,
    METRICS,
    CommuteTime,
    DescriptorChoice,
    Eigenfunctions,
    MetricChoice,
    NoDescriptor,
    Photometric,
    ScaleInvariantHeatKernelSignature,
    Structure,
)
from solver.shape.descriptors import aligned_eigenfunctions

POINTS = 60
"""At which structures are compared."""

POINTWISE = Photometric(radius=0.0)
"""Colour without averaging, of which Table 1 speaks."""


def structures() -> list[Structure]:
    """Every structure with its default parameters, local ones first."""
    local = [kind() for kind in DESCRIPTORS.values() if kind is not NoDescriptor]
    return [POINTWISE, *local, *(kind() for kind in METRICS.values())]


def change(structure: Structure, pair: Pair, count: int = POINTS) -> float:
    """Change of a structure from X to τ(X), relative to how it changes from point to point of X.

    Of a descriptor, rms_i |f_X(x_i) - f_τ(X)(τ(x_i))| / rms_{i≠j} |f_X(x_i) - f_X(x_j)|; of a
    metric, rms_{i<j} |d_X(x_i, x_j) - d_τ(X)(τ(x_i), τ(x_j))| over the same for unrelated pairs of
    points of X, which is √2 times the standard deviation of d_X. So 0 is invariant, and 1 as
    different as another point, or another pair of points, of the same shape.

    Parameters
    ----------
    structure
        A metric or a descriptor. Parameters left out suit the mean size of both shapes.
    pair
        X and τ(X), with the truth.
    count
        Number of points x_i, chosen at random.
    """
    here, there = known_points(pair, count)
    if isinstance(structure, MetricChoice):
        upper = np.triu_indices(len(here), 1)
        before, after = (found[upper] for found in distances(structure, pair, here, there))
        return _rms(after - before) / float(np.sqrt(2.0) * before.std())
    assert isinstance(structure, DescriptorChoice)
    before, after = descriptors(structure, pair, here, there)
    # The mean square of a difference over all i, j is twice the variance; i = j is not counted.
    spread = 2.0 * before.var(axis=0).sum() * len(here) / (len(here) - 1)
    return _rms(np.linalg.norm(after - before, axis=1)) / float(np.sqrt(spread))


def distances(
    choice: MetricChoice, pair: Pair, here: IntArray, there: IntArray
) -> tuple[FloatArray, FloatArray]:
    """Distances among (n,) points of X, and among (m,) of τ(X): (n, n) and (m, m)."""
    source, target = (known.shape for known in pair)
    chosen = choice.settled(float(np.sqrt(source.size * target.size)))
    return source.metric(chosen).between(here), target.metric(chosen).between(there)


def descriptors(
    choice: DescriptorChoice, pair: Pair, here: IntArray, there: IntArray
) -> tuple[FloatArray, FloatArray]:
    """Descriptors at (n,) points of X and at (m,) of τ(X), that can be compared."""
    source, target = (known.shape for known in pair)
    chosen = choice.settled(float(np.sqrt(source.size * target.size)))
    if isinstance(chosen, Eigenfunctions):
        spectra = source.spectrum(), target.spectrum()
        return aligned_eigenfunctions(*spectra, chosen.count, here, there)
    return source.descriptor(chosen, here), target.descriptor(chosen, there)


def known_points(pair: Pair, count: int, seed: int = 0) -> tuple[IntArray, IntArray]:
    """Some points of the source whose places on the target are known, and these places."""
    here, there = (known.truth for known in pair)
    assert here is not None
    assert there is not None
    chosen = np.random.default_rng(seed).choice(len(here), min(count, len(here)), replace=False)
    return here[chosen], there[chosen]


def eight_points(metric: MetricChoice, descriptor: DescriptorChoice) -> MatchOptions:
    """Options of section 6.1: eight points, both distortions weighted equally, nothing else."""
    return MatchOptions(
        points=8,
        metric=(metric,),
        descriptor=(descriptor,),
        beta=1.0,
        first_order_weight=1.0,
        orientation=False,
    )


def partners_of(structure: Structure) -> MatchOptions:
    """Eight points matched by a structure and one that Table 1 calls most invariant.

    A descriptor is joined by the commute-time metric, a metric by SI-HKS.
    """
    if isinstance(structure, MetricChoice):
        return eight_points(structure, ScaleInvariantHeatKernelSignature())
    assert isinstance(structure, DescriptorChoice)
    return eight_points(CommuteTime(), structure)


def matching_error(options: MatchOptions, pair: Pair) -> float:
    """Mean error over √area of a match, each shape with samples of its own.

    It is that against the truth or its mirror image, whichever is less.
    """
    source, target = pair
    return min(mean_errors(source, target, match(source.shape, target.shape, options)))


def assignment_error(options: MatchOptions, pair: Pair) -> float:
    """Mean error over √area when the samples of τ(X) are the images of those of X.

    What is left of :func:`matching_error` if nothing but the structures can be the cause. The
    points are the farthest ones of X in the geodesic metric, and the optimum of (5) is exact.
    """
    source, target = pair
    assert source.truth is not None
    assert target.truth is not None
    assert target.symmetric_truth is not None
    places = source.shape.surface.vertices
    farthest = source.shape.sampling("geodesic", options.points).indices
    known = np.asarray(KDTree(places[source.truth]).query(places[farthest])[1])
    here, there = source.truth[known], target.truth[known]
    metric, descriptor = options.metrics[0], options.descriptors[0]
    d, e = distances(metric, pair, here, there)
    f, g = descriptors(descriptor, pair, here, there)
    level = Level(
        0,
        metric,
        descriptor,
        SampledStructure(here, d, f),
        SampledStructure(there, e, g),
        options.beta,
        options.first_order_weight,
        np.inf,
    )
    found = m_best_solutions(level.problem(level.all_candidates()), 1)
    geodesic = target.shape.metric("geodesic").distances(there[found.partners[0]])
    rows = np.arange(len(known))
    truths = target.truth[known], target.symmetric_truth[known]
    return min(float(geodesic[rows, truth].mean()) for truth in truths) / target.shape.size


def _rms(values: FloatArray) -> float:
    return float(np.sqrt((values**2).mean()))
