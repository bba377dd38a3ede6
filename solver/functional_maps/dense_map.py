"""Maps of all points of one shape to another, and their ranking.

Orientation-preserving maps come first, which separates left from right. Among them, the quality
score decides: how well signatures and lengths of short chords are preserved, and how clearly
orientation is.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from solver.arrays import IntArray
from solver.functional_maps.functional_map import FunctionalMap
from solver.functional_maps.map_quality import unit_spectrum
from solver.functional_maps.nearest import approximate_nearest_points, nearest_points
from solver.shape import Shape

# The ratios and scores are chosen on generated people and animals; `bench.dense` measures them.

_SIMILARITY = 0.9
"""Normalised inner product of functional maps above which they are refined to the same map."""

_BLUR_TIME = 1e-3
"""Diffusion time, on unit area, after which delta functions are compared: the highest
eigenfunctions, in which a map is least certain, count less."""

_MAX_EXHAUSTIVE = 1_000_000_000
"""Pairs of vertices that an exhaustive nearest neighbour search compares: some ten seconds."""

_MIN_ORIENTATION = 0.2
"""Absolute orientation score from which on a map preserves or reverses orientation; correct maps
have 0.5 to 0.9."""

_MIN_CLARITY = 0.05
"""Least absolute orientation score in the quality score: smaller ones are not significant."""

_MAX_CHANGE_RATIO = 2.0
"""Ratio to the least change of any map beyond which a map is not taken for its orientation."""

_CLARITY_RATIO = 0.7
"""Share of the greatest absolute orientation score that a map must have: a mixture of a map and its
mirror image may change as little."""


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
        Index of the sparse correspondence that was extended.
    signature_change, chord_change
        Mean change of signatures, and root mean square change of the lengths of short chords.
    orientation_score
        From -1 to 1, near 1 if orientation is preserved: :meth:`.Comparison.orientation_score`.
    """

    functional_map: FunctionalMap
    source: Shape
    target: Shape
    hypothesis: int
    signature_change: float
    chord_change: float
    orientation_score: float

    def images(self, vertices: IntArray) -> IntArray:
        """Images of vertices under the map.

        Parameters
        ----------
        vertices
            (S,) source vertices.

        Returns
        -------
        (S,) int64 target vertices, by exhaustive search or, on large meshes, approximately nearest.
        """
        spectrum, size = unit_spectrum(self.target), self.functional_map.size
        decay = np.exp(-_BLUR_TIME * spectrum.eigenvalues[:size])
        y = spectrum.eigenfunctions[:, :size] * decay
        x = unit_spectrum(self.source).eigenfunctions[vertices]
        images = self.functional_map.images(x) * decay
        if len(images) * len(y) <= _MAX_EXHAUSTIVE:
            return nearest_points(images, y)
        return approximate_nearest_points(images, y, 2 * int(np.sqrt(len(y))))

    @property
    def change(self) -> float:
        """Change of the shape's structures: 0 for an isometry."""
        return self.signature_change * self.chord_change

    @property
    def quality_score(self) -> float:
        """Clarity of the orientation over the change; the greater, the better.

        A map that is mirrored in parts preserves those nearly as well as the whole, but its
        orientation score is near 0.
        """
        clarity = max(abs(self.orientation_score), _MIN_CLARITY)
        return clarity / self.change if self.change > 0.0 else np.inf

    @property
    def preserves_orientation(self) -> bool:
        """Return whether the map clearly preserves orientation."""
        return self.orientation_score > _MIN_ORIENTATION

    @property
    def reverses_orientation(self) -> bool:
        """Return whether the map clearly reverses orientation."""
        return self.orientation_score < -_MIN_ORIENTATION


def rank_by_quality(found: Sequence[DenseMap]) -> list[DenseMap]:
    """Return maps by their quality score, the best first."""
    return sorted(found, key=lambda one: one.quality_score, reverse=True)


def rank_maps(found: Sequence[DenseMap], reversing: bool = False) -> list[DenseMap]:
    """Return the orientation-preserving maps by their quality score, the best first.

    Parameters
    ----------
    found
        Maps between the same shapes, at least one.
    reversing
        Whether orientation-reversing maps are wanted instead.

    Returns
    -------
    Of the maps that do not change the shape far more than another, those that preserve orientation
    nearly as clearly as any preserves or reverses it. If there are none, all maps.
    """
    ranked, sign = rank_by_quality(found), -1 if reversing else 1
    most = _MAX_CHANGE_RATIO * min(one.change for one in found)
    sound = [one for one in ranked if one.change <= most]
    clearest = max(abs(one.orientation_score) for one in sound)
    least = max(_MIN_ORIENTATION, _CLARITY_RATIO * clearest)
    return [one for one in sound if sign * one.orientation_score >= least] or ranked


def drop_similar_maps(ranked: Sequence[DenseMap], most: int) -> list[DenseMap]:
    """Leave out maps that are similar to an earlier one.

    Parameters
    ----------
    ranked
        Maps between the same shapes.
    most
        Greatest number of maps returned.
    """
    chosen: list[DenseMap] = []
    for one in ranked:
        matrix = one.functional_map.matrix
        if all(
            (matrix * other.functional_map.matrix).sum() < _SIMILARITY * len(matrix)
            for other in chosen
        ):
            chosen.append(one)
        if len(chosen) == most:
            break
    return chosen
