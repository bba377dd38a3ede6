"""The shape prototype of section 5: distributions of distances and descriptors."""

from dataclasses import dataclass, field

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.prototype.mixtures import GaussianMixtures
from solver.prototype.surfaces import ExampleSurface
from solver.shape.choices import DescriptorChoice, MetricChoice, NoDescriptor

MIN_USUAL_ENERGY = 0.1
"""Least usual energy per point: that of nearly equal examples is due to sampling alone. Chosen on
generated shapes."""

_MARGIN = 4.0
"""Tolerance of the greatest misfit, divided by the number of left-out examples: the greatest of
many is rarely exceeded within the class, that of four often. Chosen on generated shapes."""


@dataclass(frozen=True, eq=False)
class LearnedDistances:
    """Distributions 𝒟 of the distances between all points, in one metric.

    Parameters
    ----------
    metric
        The metric, with a value for every parameter.
    mixtures
        N(N − 1)/2 mixtures in one dimension: of the pairs (0, 1), (0, 2), (1, 2), (0, 3), ..., so
        that those of the first n points come first.
    log_background
        Logarithm of the uniform density of outliers: it bounds the cost of a single distance.
    """

    metric: MetricChoice
    mixtures: GaussianMixtures
    log_background: float


@dataclass(frozen=True, eq=False)
class LearnedDescriptors:
    """Distributions ℱ of one descriptor at all points.

    Parameters
    ----------
    descriptor
        The descriptor, with a value for every parameter.
    centre, axes
        (m,) and (m, r): a descriptor f is modelled by its coordinates (f − centre) · axes.
    mixtures
        N mixtures in r dimensions.
    log_background
        As for distances.
    """

    descriptor: DescriptorChoice
    centre: FloatArray
    axes: FloatArray
    mixtures: GaussianMixtures
    log_background: float

    def coordinates(self, descriptors: FloatArray) -> FloatArray:
        """(S, r) coordinates of (S, m) descriptors."""
        result: FloatArray = (descriptors - self.centre) @ self.axes
        return result


@dataclass(frozen=True, eq=False)
class Prototype:
    """A class of shapes, learned from examples.

    Parameters
    ----------
    distances
        Of each level's metric, the coarsest first; the last serves all finer levels.
    descriptors
        Of each level's descriptor, likewise; ``None`` at levels without descriptors.
    sampling
        Metrics in which targets are sampled in turn, with a value for every parameter.
    positions
        (N, 3) positions of the points on the reference shape, farthest first, for pictures.
    vertices
        (N,) their vertices there, in the user's numbers.
    components
        Greatest number K of components.
    examples
        Number M of examples.
    normalise, eigenpairs, geodesic_method
        Settings of the examples' structures, which a target must share.
    warnings
        For the user.
    surfaces
        Of examples that differ from one another; none in older archives.
    left_out_energies
        (E,) energies per point, ascending, of left-out examples at the coarsest level; empty for
        few examples and in older archives.
    """

    distances: tuple[LearnedDistances, ...]
    descriptors: tuple[LearnedDescriptors | None, ...]
    sampling: tuple[MetricChoice, ...]
    positions: FloatArray
    vertices: IntArray
    components: int
    examples: int
    normalise: bool
    eigenpairs: int
    geodesic_method: str
    warnings: tuple[str, ...] = ()
    surfaces: tuple[ExampleSurface, ...] = ()
    left_out_energies: FloatArray = field(default_factory=lambda: np.zeros(0))

    @property
    def points(self) -> int:
        """Number N of points."""
        return len(self.vertices)

    @property
    def metric_choices(self) -> tuple[MetricChoice, ...]:
        """The metrics of the levels, the coarsest first."""
        return tuple(one.metric for one in self.distances)

    @property
    def descriptor_choices(self) -> tuple[DescriptorChoice, ...]:
        """The descriptors of the levels, the coarsest first."""
        return tuple(NoDescriptor() if one is None else one.descriptor for one in self.descriptors)

    @property
    def usual_energy(self) -> float:
        """Median energy per point of the left-out examples, NaN if there are none."""
        if not len(self.left_out_energies):
            return np.nan
        return max(float(np.median(self.left_out_energies)), MIN_USUAL_ENERGY)

    @property
    def greatest_misfit(self) -> float:
        """Greatest misfit, in usual energies, without a warning; NaN without left-out examples."""
        if not len(self.left_out_energies):
            return np.nan
        margin = 1.0 + _MARGIN / len(self.left_out_energies)
        return margin * max(float(self.left_out_energies[-1]) / self.usual_energy, 1.0)


def all_pairs(count: int) -> tuple[IntArray, IntArray]:
    """(P,) first and (P,) second points i < j of all pairs: the j(j − 1)/2 + i-th is (i, j)."""
    second, first = np.tril_indices(count, -1)
    return first.astype(np.int64), second.astype(np.int64)
