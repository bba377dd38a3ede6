"""Maps between all shapes of a collection that agree with one another."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt
from pydantic import FiniteFloat

from isomatch._models import Answer, Confidence
from isomatch._results.array_result import ArrayResult
from isomatch._results.result_document import Drawable
from isomatch._results.summary import called, change, screen

if TYPE_CHECKING:
    from plotly.graph_objects import Figure


class CollectionShape(Answer):
    """One shape of a collection.

    Attributes
    ----------
    shape, name
        Id and name of the shape.
    cycle_error_before, cycle_error
        Mean cycle error of the triples that it is in, by the pairwise maps and by those of the
        result; None if it is in none.
    fits
        Whether it was mapped, and its maps agree with the others. All of them may yet be in doubt:
        see :meth:`ConsistentMaps.disagreement`.
    reason
        Why it does not fit; None if it does.
    """

    shape: str
    name: str | None
    cycle_error_before: FiniteFloat | None
    cycle_error: FiniteFloat | None
    fits: bool
    reason: str | None


class CollectionPair(Answer):
    """The map of one pair of shapes, and its inverse; measures are None if there is none.

    Attributes
    ----------
    source, source_name, target, target_name
        Ids and names of the shapes.
    mapped
        Whether there is a map.
    confidence_before, confidence
        Confidence of the pairwise match, and of the map of the result.
    cycle_error_before, cycle_error
        Median cycle error over the third shapes, by the pairwise maps and by those of the result.
    through
        Ids of the shapes through which the map was found; empty if the pairwise map was kept.
    fits
        Whether there is a map that is probably right and agrees with the others.
    reason
        Why it does not fit; None if it does.
    """

    source: str
    source_name: str | None
    target: str
    target_name: str | None
    mapped: bool
    confidence_before: Confidence | None
    confidence: Confidence | None
    cycle_error_before: FiniteFloat | None
    cycle_error: FiniteFloat | None
    through: tuple[str, ...]
    fits: bool
    reason: str | None


class ConsistentMaps(ArrayResult):
    """Maps between all shapes of a collection.

    Cycle errors are mean distances in space over the square root of the area.

    Attributes
    ----------
    version
        Version of the result format.
    shapes
        The shapes, in the order in which they were given.
    pairs
        All pairs (0, 1), (0, 2), ..., (1, 2), ... of the shapes.
    cycle_error_before, cycle_error
        Mean over all triples, by the pairwise maps and by those of the result; None without any.
    warnings
        Remarks of the service on this result.
    timings
        Seconds by stage, and ``"total"``.
    """

    version: int = 1
    shapes: tuple[CollectionShape, ...]
    pairs: tuple[CollectionPair, ...]
    cycle_error_before: FiniteFloat | None
    cycle_error: FiniteFloat | None
    warnings: tuple[str, ...]
    timings: dict[str, FiniteFloat]

    def __repr__(self) -> str:
        done = sum(pair.mapped for pair in self.pairs)
        return f"<ConsistentMaps of {done} of {len(self.pairs)} pairs>"

    def __str__(self) -> str:
        done = sum(pair.mapped for pair in self.pairs)
        heading = f"{done} of {len(self.pairs)} pairs of {len(self.shapes)} shapes mapped"
        if self.cycle_error_before is not None and self.cycle_error is not None:
            heading += f"; mean cycle error {change(self.cycle_error_before, self.cycle_error)}"
        ids = [one.shape for one in self.shapes]
        names = dict(zip(ids, called((one.name, one.shape) for one in self.shapes), strict=True))
        reasons = ((one, self.disagreement(one)) for one in self.shapes)
        shapes = [f"{names[one.shape]}: does not fit: {why}" for one, why in reasons if why]
        # What does not fit, and what was improved, is looked for first.
        ranked = sorted(self.pairs, key=lambda pair: (pair.fits, not pair.through))
        return screen(heading, [*shapes, *(_line(pair, names) for pair in ranked)])

    def pairs_of(self, shape: CollectionShape) -> tuple[CollectionPair, ...]:
        """Return the pairs that a shape is in."""
        return tuple(pair for pair in self.pairs if shape.shape in (pair.source, pair.target))

    def disagreement(self, shape: CollectionShape) -> str | None:
        """Return why a shape does not fit, or that none of its pairs does; None if it fits."""
        if shape.fits and not any(pair.fits for pair in self.pairs_of(shape)):
            return "none of its pairs does"
        return shape.reason

    def map(self, source: int, target: int) -> npt.NDArray[np.int64]:
        """Return the map from one shape to another.

        Parameters
        ----------
        source, target
            Places of two shapes in :attr:`shapes`, in either order.

        Returns
        -------
        (V,) int64: row v is the vertex of the target's file that vertex v of the source's file goes
        to, -1 if v is not matched.

        Raises
        ------
        IndexError
            There is no such shape.
        ValueError
            The two are the same, or have no map, and the message says why; or as for
            :attr:`arrays`.
        """
        count = len(self.shapes)
        if not (0 <= source < count and 0 <= target < count):
            raise IndexError(f"there are {count} shapes, counted from 0")
        if source == target:
            raise ValueError("a map is of two different shapes")
        first, second = sorted((source, target))
        # Pairs are listed as the upper triangle of a matrix, row by row.
        pair = self.pairs[first * (2 * count - first - 1) // 2 + second - first - 1]
        if not pair.mapped:
            raise ValueError(f"shapes {source} and {target} have no map: {pair.reason}")
        return self.arrays[f"map_{source}_{target}"]

    def _figure(self, drawn: Sequence[Drawable], alternative: int | None) -> "Figure":
        raise ValueError("consistent maps have no figure; use the arrays of map(source, target)")


def _line(pair: CollectionPair, names: Mapping[str, str]) -> str:
    said = [f"{names[pair.source]} - {names[pair.target]}: {pair.confidence or 'no map'}"]
    if pair.cycle_error_before is not None and pair.cycle_error is not None:
        said.append(f"cycle error {change(pair.cycle_error_before, pair.cycle_error)}")
    if pair.through:
        said.append(f"through {', '.join(names[shape] for shape in pair.through)}")
    if not pair.fits:
        said.append(f"does not fit: {pair.reason}")
    return "; ".join(said)
