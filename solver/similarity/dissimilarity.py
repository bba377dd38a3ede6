"""Section 6.2: dissimilarities of shapes, the least distortion (section 2) of a few points."""

import io
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.labelling import LINF
from solver.similarity.qap import QapSolutions, least_distortions
from solver.similarity.signature import Signature, SimilarityOptions


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
        Range of the pairs' positions in that order, the last one excluded.

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
) -> QapSolutions:
    """Compare some pairs of shapes.

    The dissimilarity of two shapes is the least distortion of a bijection of their N samples, over
    all samplings, proven by exhaustive search. It is symmetric, zero for equal shapes, and
    invariant to rigid motions and scale. With the objective "l2" it is the energy (5) divided by N:
    the mean squared distortion of distances relative to their mean square, and the weighted mean
    deviation of descriptors relative to that over the collection. With "linf" it is dis∞ of section
    2, in the metric's own unit; half of it bounds the Gromov-Hausdorff distance of the samples from
    above.

    Parameters
    ----------
    collection
        Of K shapes, with signatures made with these options.
    pairs
        (P, 2) indices of the shapes to be compared.
    options
        Options of the comparison.

    Returns
    -------
    QapSolutions
        Costs, samplings, and partners of the first shape's points for each pair.

    Examples
    --------
    A triangle and the same one scaled by 2: the l2 dissimilarity is relative to the distances'
    mean square, hence not zero.

    >>> triangle = np.array([[0.0, 3.0, 4.0], [3.0, 0.0, 5.0], [4.0, 5.0, 0.0]])
    >>> distances = np.stack([triangle, 2.0 * triangle])[:, None]
    >>> collection = SignatureCollection(distances, np.zeros((2, 1, 3, 0)))
    >>> found = dissimilarities(collection, np.array([[0, 1]]), SimilarityOptions(points=3))
    >>> found.costs.tolist(), found.partners.tolist()
    ([0.4], [[0, 1, 2]])
    """
    return least_distortions(
        collection.distances,
        collection.descriptors,
        pairs,
        options.first_order_weight if options.described else 0.0,
        options.objective == LINF,
    )
