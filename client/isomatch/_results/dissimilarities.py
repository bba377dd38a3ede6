"""Dissimilarities of a collection of shapes, complete or partial."""

from collections.abc import Sequence
from functools import cached_property
from itertools import zip_longest
from typing import TYPE_CHECKING, Annotated, Any, TypeAlias

import numpy as np
import numpy.typing as npt
from pydantic import (
    BeforeValidator,
    ConfigDict,
    FiniteFloat,
    PlainSerializer,
    SkipValidation,
    WithJsonSchema,
)

from isomatch._figures import draw_dissimilarities
from isomatch._models import Answer, AnsweredState, DissimilarityParameters
from isomatch._results.result_document import Drawable, Result
from isomatch._results.summary import called

if TYPE_CHECKING:
    from plotly.graph_objects import Figure


def _numbers(given: Any) -> npt.NDArray[np.float64]:
    numbers = np.asarray(given, dtype=np.float64)
    if not np.isfinite(numbers).all():
        raise ValueError("Input should be finite numbers")
    return numbers


def _known(given: Any) -> npt.NDArray[np.float64]:
    # null, an unknown entry, becomes NaN.
    return np.asarray(given, dtype=np.float64)


def _places(given: Any) -> npt.NDArray[np.int64]:
    return np.asarray(given, dtype=np.int64)


_NUMBER, _PLACE = {"type": "number"}, {"type": "integer"}
_LIST: PlainSerializer = PlainSerializer(lambda array: array.tolist())


def _rows(of: dict[str, Any]) -> WithJsonSchema:
    return WithJsonSchema({"type": "array", "items": {"type": "array", "items": of}})


_Floats: TypeAlias = Annotated[npt.NDArray[np.float64], SkipValidation]
_Square: TypeAlias = Annotated[_Floats, BeforeValidator(_numbers), _LIST, _rows(_NUMBER)]
_Line: TypeAlias = Annotated[
    _Floats, BeforeValidator(_numbers), _LIST, WithJsonSchema({"type": "array", "items": _NUMBER})
]
_Places: TypeAlias = Annotated[
    npt.NDArray[np.int64], SkipValidation, BeforeValidator(_places), _LIST, _rows(_PLACE)
]
_Partly: TypeAlias = Annotated[
    _Floats, BeforeValidator(_known), _LIST, _rows({"anyOf": [_NUMBER, {"type": "null"}]})
]


class Dissimilarities(Result):
    """Dissimilarities of all pairs of the K shapes of a collection.

    Attributes
    ----------
    version
        Version of the result format.
    shapes
        Ids of the shapes, in the order given.
    names
        Their names; None in results of earlier versions.
    labels
        Labels of the shapes; None if none were given.
    parameters
        Parameters of the job, with defaults filled in.
    matrix
        Dissimilarities, (K, K) float64, symmetric with zero diagonal, to nine digits;
        :meth:`isomatch.Job.save_arrays` has full precision.
    lower_bounds
        Lower bounds of the pairs, (K (K - 1) / 2,) float64: the upper triangle of `matrix`, row by
        row, as ``matrix[numpy.triu_indices(K, 1)]``.
    certified
        Whether every dissimilarity is proven to be minimal.
    uncertified
        Pairs of shape numbers whose dissimilarity is not proven to be minimal.
    nearest
        Numbers of the nearest other shapes of each shape, (K, n) int64, nearest first.
    mean_average_precision, precision_at_1
        Retrieval scores of the labels; None without labels, or if no two shapes share one.
    average_precisions
        Average precision of each shape; None for a shape whose label no other has.
    warnings
        Remarks of the service on this result.
    timings
        Seconds by stage, summed over workers, and ``"total"``, the elapsed seconds.
    """

    model_config = ConfigDict(arbitrary_types_allowed=True)

    version: int = 1
    shapes: tuple[str, ...]
    names: tuple[str, ...] | None = None
    labels: tuple[str, ...] | None
    parameters: DissimilarityParameters
    matrix: _Square
    lower_bounds: _Line
    certified: bool
    uncertified: tuple[tuple[int, int], ...]
    nearest: _Places
    mean_average_precision: FiniteFloat | None
    precision_at_1: FiniteFloat | None
    average_precisions: tuple[FiniteFloat | None, ...] | None
    warnings: tuple[str, ...]
    timings: dict[str, FiniteFloat]

    def __repr__(self) -> str:
        line = f"<Dissimilarities of {len(self.shapes)} shapes"
        if self.certified:
            line += ", certified"
        if self.mean_average_precision is not None:
            line += f", mean average precision {self.mean_average_precision:.3f}"
        return line + ">"

    __str__ = __repr__

    @cached_property
    def lower_bound_matrix(self) -> npt.NDArray[np.float64]:
        """`lower_bounds` as a symmetric matrix, (K, K) float64."""
        square = np.zeros_like(self.matrix)
        square[np.triu_indices(len(square), 1)] = self.lower_bounds
        return square + square.T

    def _figure(self, drawn: Sequence[Drawable], alternative: int | None) -> "Figure":
        names = called(zip_longest(self.names or (), self.shapes))
        title = f"{len(self.shapes)} shapes"
        if self.mean_average_precision is not None:
            title += f", mean average precision {self.mean_average_precision:.3f}"
        return draw_dissimilarities(self.matrix, names, self.labels, title)


class PartialDissimilarities(Answer):
    """Dissimilarities computed so far.

    Attributes
    ----------
    job, state
        Id and state of the job.
    shapes, names, labels
        Ids of the shapes, the names that were given them, and their labels; each may be None.
    pairs, pairs_done
        Number of pairs of shapes, and of those whose dissimilarity is known.
    matrix
        Dissimilarities, (K, K) float64; NaN where they are not known.
    """

    model_config = ConfigDict(arbitrary_types_allowed=True)

    job: str
    state: AnsweredState
    shapes: tuple[str, ...]
    names: tuple[str | None, ...] | None = None
    labels: tuple[str, ...] | None
    pairs: int
    pairs_done: int
    matrix: _Partly

    def plot(self) -> "Figure":
        """Draw what is known, as :meth:`Dissimilarities.plot` does; the rest stays empty.

        Raises
        ------
        MissingExtra
            plotly is not installed.
        """
        names = called(zip_longest(self.names or (), self.shapes))
        title = f"{len(self.shapes)} shapes, {self.pairs_done} of {self.pairs} pairs known"
        return draw_dissimilarities(self.matrix, names, self.labels, title)
