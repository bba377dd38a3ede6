"""A match extended to all vertices, by the hypothesis that preserves most and keeps orientation.

Intrinsically a correspondence and its mirror image cannot be told apart, and the energy takes
either. Extended to all vertices they can: one keeps the surface's orientation, the other turns it
inside out. Where all hypotheses do that, or where it is not clear what they do, further maps are
made: by the eigenfunctions' signs, by refining the best ones again from fewer eigenfunctions, and
by composing these with the reflection of the source.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from solver.arrays import IntArray
from solver.control import Control
from solver.functional_maps.dense_map import DenseMap, first_of_each, oriented_first
from solver.functional_maps.extension import completed, extension, extensions
from solver.functional_maps.functional_map import FunctionalMap
from solver.functional_maps.map_quality import Comparison
from solver.functional_maps.symmetry import composed, maps_by_signs, reflection
from solver.shape import Shape

LEAST_EXTENDED = 3
"""Matched points that a map of all vertices takes at least."""

_HYPOTHESES = 4
"""Looked at first; as many again if none of them keeps orientation."""

_CLEAR = 0.65
"""Orientation that maps of nearly isometric shapes have; others may be right in part, and mirrored
in part."""

_RESTARTED = 3
"""Maps that are refined again, and composed."""

_RESTARTS = 10, 16, 24, 36
"""Eigenfunctions from which a map is refined again. The more there are, the less changes."""

_LITTLE = 1.1
"""Where a map keeps orientation and changes that much more than another, the latter's mirror image
may be better."""


@dataclass(frozen=True, eq=False)
class DenseCorrespondence:
    """A map of all vertices.

    Parameters
    ----------
    source
        (K,) the user's numbers of all vertices of the source's surface, ascending.
    target
        (K,) the user's number of the target vertex that each goes to; several may go to one.
    hypothesis
        What was extended: 0 for the match's best, or one more than a place among its alternatives.
    """

    source: IntArray
    target: IntArray
    hypothesis: int


def extended_map(
    source: Shape,
    target: Shape,
    hypotheses: Sequence[tuple[IntArray, IntArray]],
    control: Control,
    further: bool = True,
) -> DenseMap | None:
    """Extend the best of a match's hypotheses to all vertices.

    Parameters
    ----------
    source, target
        The shapes X and Y.
    hypotheses
        (n,) vertices of X and (n,) vertices of Y that correspond, the likeliest first. Those
        of less than three points are passed over.
    control
        May cancel; past its deadline, less is tried.
    further
        Whether maps may be made that extend none of those given, where it is not clear that one
        of them keeps orientation. Where
        landmarks say which of two symmetric solutions is meant, they should not.

    Returns
    -------
    Its `hypothesis` is a place among those given, or their number for one that is none of them;
    ``None`` if the first has too few points.

    Raises
    ------
    Cancelled
        Through `control`.
    """
    if len(hypotheses[0][0]) < LEAST_EXTENDED:
        return None
    comparison = Comparison(source, target)
    places = [i for i, (x, _) in enumerate(hypotheses) if len(x) >= LEAST_EXTENDED]
    found: list[DenseMap] = []
    for some in places[:_HYPOTHESES], places[_HYPOTHESES : 2 * _HYPOTHESES]:
        for place in some:
            found += extensions(comparison, [hypotheses[place]], control, first=place)
        if oriented_first(found)[0].keeps:
            break
    if further and not _is_clear(found):
        found += maps_by_signs(comparison, control, len(hypotheses))
        found += list(_restarted(comparison, found, control, len(hypotheses)))
        found += list(_reflected(comparison, found, control, len(hypotheses)))
    return completed(comparison, oriented_first(found)[0])


def _is_clear(found: Sequence[DenseMap]) -> bool:
    """Whether a map clearly keeps orientation, and none that does not preserves much more."""
    best = oriented_first(found)[0]
    least = min(one.change for one in found)
    return best.orientation >= _CLEAR and best.change <= _LITTLE * least


def _restarted(
    comparison: Comparison, found: Sequence[DenseMap], control: Control, hypothesis: int
) -> Iterator[DenseMap]:
    """Refine the best maps again from fewer of their eigenfunctions; they may end elsewhere."""
    ranked = sorted(found, key=lambda one: one.doubt)
    for one in first_of_each(ranked, _RESTARTED):
        for size in _RESTARTS:
            control.check()
            if control.seconds_left() <= 0.0:
                return
            matrix = one.functional_map.matrix[:size, :size]
            yield extension(comparison, FunctionalMap(matrix), hypothesis)


def _reflected(
    comparison: Comparison, found: Sequence[DenseMap], control: Control, hypothesis: int
) -> Iterator[DenseMap]:
    """Compose the best maps with the reflection of X."""
    if control.seconds_left() <= 0.0:
        return
    reflected = reflection(comparison.source.shape, control)
    if reflected is None:
        return
    for one in first_of_each(sorted(found, key=lambda one: one.doubt), _RESTARTED):
        yield from composed(comparison, reflected, one, control, hypothesis)


def dense_correspondence(found: DenseMap) -> DenseCorrespondence:
    """Name the image of every vertex of the source by the users' own numbers."""
    source, target = found.source.mesh, found.target.mesh
    ids, vertices = source.numbering
    images = found.images(np.arange(source.n_vertices, dtype=np.int64))
    return DenseCorrespondence(ids, target.vertex_ids[images[vertices]], found.hypothesis)
