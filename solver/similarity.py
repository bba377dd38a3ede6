"""Dissimilarities of shapes: the least distortion of a few points, sections 2 and 6.2."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.bijection import Bijections, least_distortions
from solver.control import Control
from solver.options import LINF
from solver.signature import Signature, SimilarityOptions

_PAIRS_PER_CALL = 200
"""A tenth of a second or so, after which progress is reported."""


@dataclass(frozen=True, eq=False)
class DissimilarityMatrix:
    """Dissimilarities among the shapes of a collection.

    Parameters
    ----------
    values
        (K, K) symmetric, zero on the diagonal.
    lower_bounds
        (K, K) what each pair's distortion is at least; equal to `values` where it is proven.
    samplings
        (K, K) the sampling in which a pair is least distorted, an index into `SAMPLINGS`.
    """

    values: FloatArray
    lower_bounds: FloatArray
    samplings: IntArray

    @property
    def certified(self) -> bool:
        """Whether every pair's optimum is proven."""
        return bool((self.lower_bounds >= self.values).all())


def pairs_of(count: int) -> IntArray:
    """(P, 2) all unordered pairs i < j of `count` shapes, in lexicographic order."""
    return np.stack(np.triu_indices(count, 1), axis=1).astype(np.int64)


def dissimilarities(
    signatures: Sequence[Signature], pairs: IntArray, options: SimilarityOptions
) -> Bijections:
    """Compare some pairs of shapes.

    The dissimilarity of two shapes is the distortion of the bijection of their N samples that
    distorts least, proven by exhaustive search, in that of their samplings where this is least. It
    is symmetric, zero for equal shapes, and does not change when a shape is moved or scaled. With
    the objective "l2" it is the energy (5) divided by N: the mean squared distortion of distances
    relative to their mean square, and the weighted mean deviation of descriptors. With "linf" it is
    dis∞ of section 2, twice the Gromov-Hausdorff distance of the matched points, in the metric's
    own unit.

    Parameters
    ----------
    signatures
        Of K shapes, made with these options.
    pairs
        (P, 2) which are compared.
    options
        Of the comparison.

    Returns
    -------
    Bijections
        With partners of the first shape's points for each pair.
    """
    distances = np.stack([signature.distances for signature in signatures])
    descriptors = np.stack([signature.descriptors for signature in signatures])
    weight = options.first_order_weight if options.described else 0.0
    return least_distortions(distances, descriptors, pairs, weight, options.objective == LINF)


def dissimilarity_matrix(
    signatures: Sequence[Signature], options: SimilarityOptions, control: Control | None = None
) -> DissimilarityMatrix:
    """Compare all shapes of a collection.

    Parameters
    ----------
    signatures
        Of K shapes, made with these options.
    options
        Of the comparison.
    control
        Progress and cancellation.

    Returns
    -------
    DissimilarityMatrix

    Raises
    ------
    Cancelled
        Through `control`.
    """
    control = control or Control()
    count = len(signatures)
    values, samplings = np.zeros((count, count)), np.zeros((count, count), dtype=np.int64)
    pairs = pairs_of(count)
    for first in range(0, len(pairs), _PAIRS_PER_CALL):
        control.report("pairs", first / len(pairs))
        some = pairs[first : first + _PAIRS_PER_CALL]
        found = dissimilarities(signatures, some, options)
        i, j = some.T
        values[i, j] = values[j, i] = found.costs
        samplings[i, j] = samplings[j, i] = found.samplings
    return DissimilarityMatrix(values, values.copy(), samplings)
