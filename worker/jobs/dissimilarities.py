"""Results of comparing a collection: the document, and the same as arrays."""

from collections.abc import Mapping

import numpy as np

from broker.contracts import NEIGHBOURS, DissimilaritiesPayload, DissimilarityResult
from solver.arrays import FloatArray, npz_bytes
from solver.similarity import RetrievalScores, rankings, retrieval_scores

_DIGITS = 9
"""Significant digits of the numbers in the document; the arrays have full precision."""

_MAX_PLACES = 300
"""Decimal places to round to at most; 10**309 overflows a float."""


def result_of(
    payload: DissimilaritiesPayload,
    values: FloatArray,
    timings: Mapping[str, float],
    names: tuple[str, ...] | None = None,
) -> DissimilarityResult:
    """Return the result document.

    Parameters
    ----------
    payload
        The job, of K shapes.
    values
        (K(K−1)/2,) dissimilarities of all pairs, in lexicographic order.
    timings
        Seconds by stage.
    names
        Names of the shapes.
    """
    count = len(payload.shapes)
    matrix = _square(values, count)
    scores = None if payload.labels is None else retrieval_scores(matrix, payload.labels)
    rounded = _rounded(values)
    # Not validated: the values are ours, and may be a million.
    return DissimilarityResult.model_construct(
        shapes=payload.shapes,
        names=names,
        labels=payload.labels,
        parameters=payload.parameters,
        matrix=tuple(map(tuple, _square(rounded, count).tolist())),
        # Parts of the contract: every search is exhaustive, so that each optimum is proven.
        lower_bounds=tuple(rounded.tolist()),
        certified=True,
        uncertified=(),
        nearest=tuple(map(tuple, rankings(matrix)[:, :NEIGHBOURS].tolist())),
        mean_average_precision=None if scores is None else scores.mean_average_precision,
        precision_at_1=None if scores is None else scores.precision_at_1,
        average_precisions=None if scores is None else _listed(scores),
        warnings=_warnings(scores),
        timings=dict(timings),
    )


def arrays_of(result: DissimilarityResult, values: FloatArray) -> bytes:
    """Return a result as the bytes of an ``.npz`` file without pickled objects.

    Parameters
    ----------
    result
        The result document.
    values
        (K(K−1)/2,) dissimilarities of all pairs in full precision.
    """
    count = len(result.shapes)
    arrays = {
        "shapes": np.array(result.shapes),
        "matrix": _square(values, count),
        "lower_bounds": values,
        "certified": np.ones(len(values), dtype=np.bool_),
        "nearest": np.array(result.nearest, dtype=np.int64).reshape(count, -1),
    }
    if result.names is not None:
        arrays["names"] = np.array(result.names)
    if result.labels is not None:
        arrays["labels"] = np.array(result.labels)
    return npz_bytes(arrays)


def _warnings(scores: RetrievalScores | None) -> tuple[str, ...]:
    if scores is None or scores.mean_average_precision is not None:
        return ()
    return (
        "no two shapes have the same label, so that there are no scores; give shapes of one class"
        " one label",
    )


def _square(values: FloatArray, count: int) -> FloatArray:
    matrix = np.zeros((count, count))
    matrix[np.triu_indices(count, 1)] = values
    return matrix + matrix.T


def _rounded(values: FloatArray) -> FloatArray:
    """The values rounded to significant digits."""
    places = _DIGITS - 1 - np.floor(np.log10(np.where(values > 0.0, values, 1.0)))
    scale: FloatArray = 10.0 ** np.minimum(places, _MAX_PLACES)
    return np.round(values * scale) / scale


def _listed(scores: RetrievalScores) -> tuple[float | None, ...]:
    return tuple(None if np.isnan(value) else float(value) for value in scores.average_precisions)
