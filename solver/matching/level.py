"""One level of hierarchical matching (4.1): two samplings, their structures, and problem (5)."""

from dataclasses import dataclass, field

import numpy as np

from solver.arrays import BoolArray, FloatArray, IntArray
from solver.labelling import (
    NO_TRIPLES,
    UNMATCHED,
    Distortion,
    LabellingProblem,
    measure_distortion,
    pairs_with_landmarks,
)
from solver.matching.third_order import ThirdOrderTerm
from solver.shape.choices import DescriptorChoice, MetricChoice
from solver.shape.descriptors import descriptor_deviation


@dataclass(frozen=True, eq=False)
class SampledStructure:
    """Sampled points of one shape and its structures there.

    Parameters
    ----------
    vertices
        (n,) vertex indices, farthest first.
    distances
        (n, n) metric d of this level among them.
    descriptors
        (n, m) descriptor f at them; ``None`` when the level has no first-order term.
    """

    vertices: IntArray
    distances: FloatArray
    descriptors: FloatArray | None

    def first(self, count: int) -> "SampledStructure":
        """Return the first samples."""
        descriptors = None if self.descriptors is None else self.descriptors[:count]
        return SampledStructure(self.vertices[:count], self.distances[:count, :count], descriptors)


@dataclass(frozen=True, eq=False)
class Level:
    """One level of the hierarchy: the sampled structures and the weights of problem (5).

    Parameters
    ----------
    index
        0 for the coarsest.
    metric, descriptor
        The structures.
    source, target
        Sampled structures of X and Y.
    beta, first_order_weight, occlusion_cost
        β, the weight of the first-order term and γ (∞: all points are matched), of
        :class:`.MatchOptions`.
    landmarks
        Number L of landmarks: the first L samples of both shapes correspond, in order.
    third_order
        Third-order term, if the level has one.
    """

    index: int
    metric: MetricChoice
    descriptor: DescriptorChoice
    source: SampledStructure
    target: SampledStructure
    beta: float
    first_order_weight: float
    occlusion_cost: float
    landmarks: int = field(default=0, kw_only=True)
    third_order: ThirdOrderTerm | None = field(default=None, kw_only=True)

    def problem(self, candidates: IntArray) -> LabellingProblem:
        """Problem (5) on given candidates.

        Distances are divided by the root mean square of both shapes' distances between source
        samples and between as many target samples, and a pair weighs 2/(N − 1), so that the sum
        over pairs grows like the sum over points. Descriptors of as many samples are divided by
        their root mean square deviation from their mean; if they are constant, there is no
        first-order term. Both shapes share the divisors, so that no difference of scale is lost;
        more target samples do not change them.

        Parameters
        ----------
        candidates
            (V, 2) indices into the two samplings, in lexicographic order.
        """
        unit = self._length_unit()
        n, third = len(self.source.vertices), self.third_order
        return LabellingProblem(
            candidates,
            self._unary(candidates),
            self.source.distances / unit,
            self.target.distances / unit,
            self.beta * 2.0 / max(n - 1, 1),
            self.occlusion_cost,
            triples=NO_TRIPLES if third is None else third.costs(candidates, n),
        )

    def allowed(self) -> BoolArray:
        """(N, M) pairs that agree with the landmarks, each of which has one partner."""
        sizes = len(self.source.vertices), len(self.target.vertices)
        return pairs_with_landmarks(*sizes, self.landmarks)

    def all_candidates(self) -> IntArray:
        """(V, 2) all allowed pairs, the candidates of the coarsest level: N·M without landmarks."""
        return np.argwhere(self.allowed()).astype(np.int64)

    def distortion(self, partners: IntArray) -> Distortion:
        """Distortion of a correspondence at this level, in the structures' own units.

        Parameters
        ----------
        partners
            (N,) index of each source sample's target sample, `UNMATCHED` for none.
        """
        x = np.flatnonzero(partners != UNMATCHED)
        y = partners[x]
        source, target = self.source.descriptors, self.target.descriptors
        return measure_distortion(
            self.source.distances[np.ix_(x, x)],
            self.target.distances[np.ix_(y, y)],
            None if source is None else source[x],
            None if target is None else target[y],
        )

    def _length_unit(self) -> float:
        n = len(self.source.vertices)
        squares = self.source.distances**2, self.target.distances[:n, :n] ** 2
        mean = sum(float(square.sum()) for square in squares) / max(
            sum(square.shape[0] * (square.shape[0] - 1) for square in squares), 1
        )
        return float(np.sqrt(mean)) or 1.0

    def _unary(self, candidates: IntArray) -> FloatArray:
        source, target = self.source.descriptors, self.target.descriptors
        if source is None or target is None or self.first_order_weight == 0.0:
            return np.zeros(len(candidates))
        both = np.concatenate([source, target[: len(source)]])
        unit = descriptor_deviation(both)
        if unit == 0.0:
            return np.zeros(len(candidates))
        x, y = candidates.T
        distance: FloatArray = np.linalg.norm(source[x] - target[y], axis=1)
        return self.first_order_weight * distance / unit
