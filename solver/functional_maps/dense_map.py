"""A map of all points of one shape to another, and which of several is best.

Those that keep orientation, which tells left from right, come first; of them the one that preserves
signatures and the lengths of short chords best, and orientation most clearly.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from solver.arrays import IntArray
from solver.functional_maps.functional_map import FunctionalMap
from solver.functional_maps.map_quality import unit_spectrum
from solver.functional_maps.nearest import nearest_points, nearly_nearest_points
from solver.shape import Shape

_SAME = 0.9
"""Maps that agree in as much of what they do to eigenfunctions end alike."""

_BLUR = 1e-3
"""Time, on unit area, after which heat kernels are compared: the highest eigenfunctions, of which a
map is least certain, count less."""

_EXHAUSTIVE = 1_000_000_000
"""Pairs of vertices that are compared when a map is made one of vertices: some ten seconds."""

_ORIENTED = 0.2
"""Orientation of maps of which it can be said at all: of right ones it is 0.5 to 0.9."""

_UNORIENTED = 0.05
"""Of maps that have less, orientation says nothing."""

_MUCH = 2.0
"""Maps that preserve so much less than another are not taken, however they turn the surface."""

_NEARLY = 0.7
"""Share of the clearest orientation that a map must have: a mixture of one map and its mirror image
can preserve as much."""


@dataclass(frozen=True, eq=False)
class DenseMap:
    """A map from all points of X to points of Y.

    Parameters
    ----------
    functional_map
        In the first eigenfunctions of both.
    source, target
        The shapes.
    hypothesis
        Index of the sparse correspondence that it came from.
    signature_change, chord_change
        How it changes signatures on average, and lengths of short chords (root mean square).
    orientation
        From -1 to 1, near 1 if it keeps orientation; see :meth:`Comparison.orientation`.
    """

    functional_map: FunctionalMap
    source: Shape
    target: Shape
    hypothesis: int
    signature_change: float
    chord_change: float
    orientation: float

    def images(self, vertices: IntArray) -> IntArray:
        """(S,) target vertices that (S,) source vertices go to.

        Where a search among all would take long, only those around are searched.
        """
        spectrum, size = unit_spectrum(self.target), self.functional_map.size
        decay = np.exp(-_BLUR * spectrum.eigenvalues[:size])
        y = spectrum.eigenfunctions[:, :size] * decay
        x = unit_spectrum(self.source).eigenfunctions[vertices]
        images = self.functional_map.images(x) * decay
        if len(images) * len(y) <= _EXHAUSTIVE:
            return nearest_points(images, y)
        return nearly_nearest_points(images, y, 2 * int(np.sqrt(len(y))))

    @property
    def change(self) -> float:
        """How little of the shape is preserved."""
        return self.signature_change * self.chord_change

    @property
    def doubt(self) -> float:
        """How little is preserved, and how little clear it is whether orientation is.

        Parts of a map that are mirrored where others are not preserve nearly as much as the whole,
        but orientation only in part.
        """
        return self.change / max(abs(self.orientation), _UNORIENTED)

    @property
    def keeps(self) -> bool:
        """Whether it clearly keeps orientation."""
        return self.orientation > _ORIENTED

    @property
    def reverses(self) -> bool:
        """Whether it clearly reverses orientation."""
        return self.orientation < -_ORIENTED


def oriented_first(found: Sequence[DenseMap], turn: int = 1) -> list[DenseMap]:
    """Put maps in order by what they preserve, and those that keep orientation alone, if they can.

    Parameters
    ----------
    found
        Maps between the same shapes.
    turn
        -1 for those that reverse orientation instead.

    Returns
    -------
    Those that keep orientation as clearly as any map keeps or reverses it, by `doubt`, without
    those that preserve far less than some other; if there are none, all, by `doubt` alone.
    """
    ranked = sorted(found, key=lambda one: one.doubt)
    most = _MUCH * min(one.change for one in found)
    sound = [one for one in ranked if one.change <= most]
    least = max(_ORIENTED, _NEARLY * max(abs(one.orientation) for one in sound))
    return [one for one in sound if turn * one.orientation >= least] or ranked


def first_of_each(ranked: Sequence[DenseMap], most: int) -> list[DenseMap]:
    """Leave out maps that agree with one before.

    Parameters
    ----------
    ranked
        Maps between the same shapes.
    most
        How many are wanted.
    """
    chosen: list[DenseMap] = []
    for one in ranked:
        matrix = one.functional_map.matrix
        if all(
            (matrix * other.functional_map.matrix).sum() < _SAME * len(matrix) for other in chosen
        ):
            chosen.append(one)
        if len(chosen) == most:
            break
    return chosen
