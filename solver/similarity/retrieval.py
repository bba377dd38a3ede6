"""Section 6.2: retrieval of the shapes of a query's class by dissimilarity, and its scores."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from solver.arrays import FloatArray, IntArray


@dataclass(frozen=True, eq=False)
class RetrievalScores:
    """Scores of a retrieval experiment in which every shape is the query once.

    The other shapes are ranked by their dissimilarity from the query, the least first; those of its
    class are relevant. Queries that have no other shape of their class count for nothing.

    Parameters
    ----------
    mean_average_precision
        Mean over the queries of the average precision: the mean, over the relevant shapes, of the
        share of relevant ones among all those ranked up to it. 1 if every query has its own class
        first; ``None`` without a query that counts.
    precision_at_1
        Share of the queries whose first ranked shape is relevant; ``None`` likewise.
    average_precisions
        (K,) of each query; NaN for those that do not count.
    """

    mean_average_precision: float | None
    precision_at_1: float | None
    average_precisions: FloatArray


def rankings(dissimilarities: FloatArray) -> IntArray:
    """Rank all other shapes for each shape, the least dissimilar first.

    Parameters
    ----------
    dissimilarities
        (K, K); row q is that of query q, whose own entry is not looked at.

    Returns
    -------
    (K, K-1) indices. Of equal dissimilarities, the smaller index comes first.
    """
    count = len(dissimilarities)
    order = np.argsort(dissimilarities, axis=1, kind="stable")
    others: IntArray = order[order != np.arange(count)[:, None]].astype(np.int64)
    return others.reshape(count, max(count - 1, 0))


def retrieval_scores(dissimilarities: FloatArray, labels: Sequence[object]) -> RetrievalScores:
    """Score a dissimilarity matrix against the classes of its shapes.

    Of equal dissimilarities, those of relevant shapes are ranked last, so that a constant matrix
    does not score by the order of the shapes.

    Parameters
    ----------
    dissimilarities
        (K, K); row q is that of query q, whose own entry is not looked at.
    labels
        (K,) class of each shape.

    Raises
    ------
    ValueError
        There are not as many labels as shapes, or a dissimilarity is NaN.
    """
    count = len(dissimilarities)
    if dissimilarities.shape != (count, count) or len(labels) != count:
        raise ValueError("a square matrix and a label for each of its rows are needed")
    if np.isnan(dissimilarities).any():
        raise ValueError("a dissimilarity is not a number")
    classes = np.unique([str(label) for label in labels], return_inverse=True)[1]
    averages, firsts = np.full(count, np.nan), np.full(count, np.nan)
    for query, row in enumerate(dissimilarities):
        others = np.delete(np.arange(count), query)
        relevant = classes[others] == classes[query]
        if relevant.any():
            hits = relevant[np.lexsort((relevant, row[others]))]
            precision = np.cumsum(hits) / np.arange(1, count)
            averages[query], firsts[query] = precision[hits].mean(), hits[0]
    counted = np.isfinite(averages)
    if not counted.any():
        return RetrievalScores(None, None, averages)
    return RetrievalScores(float(averages[counted].mean()), float(firsts[counted].mean()), averages)
