"""Dissimilarities of shapes: the least distortion of a few points, sections 2 and 6.2."""

import io
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.control import Control
from solver.labelling import LINF
from solver.similarity.qap import Bijections, least_distortions
from solver.similarity.signature import Signature, SimilarityOptions

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


@dataclass(frozen=True, eq=False)
class SignatureCollection:
    """Signatures of the shapes of a collection, made with the same options.

    Parameters
    ----------
    distances
        (K, S, N, N) of all shapes.
    descriptors
        (K, S, N, m) of all shapes.
    """

    distances: FloatArray
    descriptors: FloatArray

    def __len__(self) -> int:
        return len(self.distances)

    @classmethod
    def of(cls, signatures: Sequence[Signature], points: int) -> "SignatureCollection":
        """Put the first points of signatures together.

        Raises
        ------
        OptionError
            A signature has fewer.
        """
        cut = [signature.first(points) for signature in signatures]
        return cls(
            np.stack([signature.distances for signature in cut]),
            np.stack([signature.descriptors for signature in cut]),
        )

    def to_bytes(self) -> bytes:
        """Return the collection as the bytes of two ``.npy`` files, exact to the last bit."""
        stream = io.BytesIO()
        for array in (self.distances, self.descriptors):
            np.save(stream, array, allow_pickle=False)
        return stream.getvalue()

    @classmethod
    def from_bytes(cls, data: bytes) -> "SignatureCollection":
        """Read what :meth:`to_bytes` wrote; nothing in it is ever executed."""
        stream = io.BytesIO(data)
        return cls(*(np.load(stream, allow_pickle=False) for _ in range(2)))


def number_of_pairs(count: int) -> int:
    """Number P of unordered pairs of `count` shapes."""
    return count * (count - 1) // 2


def pairs_between(count: int, first: int, last: int) -> IntArray:
    """Some of the unordered pairs i < j of `count` shapes, which are in lexicographic order.

    Parameters
    ----------
    count
        Number K of shapes.
    first, last
        From which pair on, up to and without which.

    Returns
    -------
    (last − first, 2) int64
    """
    places = np.arange(first, last)
    rows = np.arange(count)
    begins = rows * (2 * count - rows - 1) // 2
    i = np.searchsorted(begins, places, side="right") - 1
    return np.stack([i, places - begins[i] + i + 1], axis=1).astype(np.int64)


def dissimilarities(
    collection: SignatureCollection, pairs: IntArray, options: SimilarityOptions
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
    collection
        Of K shapes, with signatures made with these options.
    pairs
        (P, 2) which are compared.
    options
        Of the comparison.

    Returns
    -------
    Bijections
        With partners of the first shape's points for each pair.
    """
    return least_distortions(
        collection.distances,
        collection.descriptors,
        pairs,
        options.first_order_weight if options.described else 0.0,
        options.objective == LINF,
    )


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
    collection, total = SignatureCollection.of(signatures, options.points), number_of_pairs(count)
    for first in range(0, total, _PAIRS_PER_CALL):
        control.report("pairs", first / total)
        some = pairs_between(count, first, min(first + _PAIRS_PER_CALL, total))
        found = dissimilarities(collection, some, options)
        i, j = some.T
        values[i, j] = values[j, i] = found.costs
        samplings[i, j] = samplings[j, i] = found.samplings
    return DissimilarityMatrix(values, values.copy(), samplings)
