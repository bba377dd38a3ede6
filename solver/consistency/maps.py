"""Maps between the surfaces of a collection, and how far they agree with one another.

Maps of three shapes are *cycle consistent* if the map from X to Z is that from X to Y, followed by
that from Y to Z. Maps of a collection that are all right are; of those that are not, one is wrong.
"""

from collections.abc import Hashable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TypeVar

import numpy as np

from solver.arrays import FloatArray, IntArray

_Key = TypeVar("_Key", bound=Hashable)

Pair = tuple[int, int]
"""Places of two different shapes, the source first."""


@dataclass(frozen=True, eq=False)
class CollectionMaps:
    """Maps of all vertices between N surfaces, for the pairs with a known map.

    Parameters
    ----------
    positions
        (V_i, 3) vertices of each surface, at √area 1.
    images
        (V_i,) vertices of j that the vertices of i go to, for ordered pairs (i, j): with a pair,
        the other way round is known, too.
    probabilities
        That the map of a pair is right, in [0, 1], for the same pairs, both ways the same.
    """

    positions: Sequence[FloatArray]
    images: Mapping[Pair, IntArray]
    probabilities: Mapping[Pair, float]

    @property
    def count(self) -> int:
        """Number N of surfaces."""
        return len(self.positions)

    def pairs(self) -> Iterator[Pair]:
        """Yield the known pairs (i, j), i < j, in order."""
        return (pair for pair in sorted(self.images) if pair[0] < pair[1])

    def along(self, path: Sequence[int], vertices: IntArray | None = None) -> IntArray:
        """Compose the maps along a path.

        Parameters
        ----------
        path
            Places of two or more shapes; the maps between successive ones are known.
        vertices
            (S,) vertices of the first, by default all.

        Returns
        -------
        (S,) vertices of the last.
        """
        first, second, *rest = path
        images = self.images[first, second]
        found = images if vertices is None else images[vertices]
        for here, there in zip([second, *rest], rest, strict=False):
            found = self.images[here, there][found]
        return found


@dataclass(frozen=True, eq=False)
class CycleErrors:
    """Cycle errors of a collection: mean distances in space, over √area.

    Parameters
    ----------
    triples
        For (i, j, k) with i < j, mean distance on j between the images of samples of i by the map
        of (i, j), and by way of k.
    """

    triples: Mapping[tuple[int, int, int], float]

    def of_pair(self, pair: Pair) -> float | None:
        """Median over the third shapes; None if there is none by which both maps are known.

        Of two middle ones the lesser: among four shapes, a right map has two third shapes, and one
        of the ways is wrong where one other map is.
        """
        i, j = sorted(pair)
        found = self._of_pairs.get((i, j))
        return float(np.quantile(found, 0.5, method="lower")) if found else None

    def of_shape(self, place: int) -> float | None:
        """Mean over the triples that a shape is in; None if there is none."""
        found = self._of_shapes.get(place)
        return float(np.mean(found)) if found else None

    @cached_property
    def _of_pairs(self) -> Mapping[Pair, Sequence[float]]:
        return _grouped(((i, j), error) for (i, j, _), error in self.triples.items())

    @cached_property
    def _of_shapes(self) -> Mapping[int, Sequence[float]]:
        items = self.triples.items()
        return _grouped((place, error) for triple, error in items for place in triple)

    @property
    def mean(self) -> float | None:
        """Mean over all triples; None if there is none."""
        return float(np.mean(list(self.triples.values()))) if self.triples else None


def cycle_errors(maps: CollectionMaps, samples: Sequence[IntArray]) -> CycleErrors:
    """Measure the cycle errors of maps, their disagreement with one another.

    Parameters
    ----------
    maps
        The maps; where one of a triple is not known, the triple is left out.
    samples
        (S_i,) vertices of each surface, spread over it, that distances are the means of.
    """
    triples = {}
    for i, j in maps.pairs():
        direct = maps.images[i, j][samples[i]]
        for k in range(maps.count):
            if k not in (i, j) and (i, k) in maps.images and (k, j) in maps.images:
                around = maps.along((i, k, j), samples[i])
                triples[i, j, k] = apart(maps.positions[j], direct, around)
    return CycleErrors(triples)


def _grouped(items: Iterable[tuple[_Key, float]]) -> Mapping[_Key, Sequence[float]]:
    """Group values by their keys, in order."""
    groups: dict[_Key, list[float]] = {}
    for key, value in items:
        groups.setdefault(key, []).append(value)
    return groups


def apart(positions: FloatArray, images: IntArray, others: IntArray) -> float:
    """Mean distance in space between (S,) vertices and (S,) others."""
    return float(np.linalg.norm(positions[images] - positions[others], axis=1).mean())
