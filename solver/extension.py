"""A match extended to all vertices, by the hypothesis that preserves most and keeps orientation.

Intrinsically a correspondence and its mirror image cannot be told apart, and the energy takes
either. Extended to all vertices they can: one keeps the surface's orientation, the other turns it
inside out. Where all hypotheses do that, the best of them is composed with the reflection of the
source; where it is not clear what they do, further ones are made of the eigenfunctions' signs.
"""

from collections.abc import Sequence

import numpy as np

from solver.arrays import IntArray
from solver.comparison import Comparison
from solver.control import Control
from solver.dense import DenseMap, best_map, extensions, oriented_first
from solver.match import DenseCorrespondence
from solver.shape import Shape
from solver.symmetry import maps_by_signs, reflection

LEAST_EXTENDED = 3
"""Matched points that a map of all vertices takes at least."""

_HYPOTHESES = 4
"""Looked at first; as many again if none of them keeps orientation."""

_CLEAR = 0.55
"""Orientation, or its opposite, that maps of nearly isometric shapes have; others may be right in
part, and mirrored in part."""

_LITTLE = 1.1
"""Where a map keeps orientation and changes that much more than one that reverses it, the latter's
mirror image may be better."""


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
        (n,) vertices of X and (n,) vertices of Y that correspond, the best by energy first. Those
        of less than three points are passed over.
    control
        May cancel; past its deadline, less is tried.
    further
        Whether hypotheses may be made beyond those given, by reflection and by signs. Where
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
    if further and abs(oriented_first(found)[0].orientation) < _CLEAR:
        found += maps_by_signs(comparison, control, len(hypotheses))
    mirrored = _mirrored(found, hypotheses[0][0], control) if further else None
    if mirrored is not None:
        found += extensions(comparison, [mirrored], control, first=len(hypotheses))
    return best_map(comparison, oriented_first(found), hypotheses[0][0])


def _mirrored(
    found: Sequence[DenseMap], vertices: IntArray, control: Control
) -> tuple[IntArray, IntArray] | None:
    """Where vertices of X go by the best map that reverses orientation, if reflected before.

    ``None`` where that is not worth it: a map that keeps orientation preserves as much.
    """
    best = oriented_first(found)[0]
    reversing = [one for one in found if one.reverses]
    if not reversing or control.seconds_left() <= 0.0:
        return None
    chosen = oriented_first(reversing, turn=-1)[0]
    if best.orientation >= _CLEAR and best.change <= _LITTLE * chosen.change:
        return None
    reflected = reflection(chosen.source, control)
    if reflected is None:
        return None
    return vertices, chosen.images(reflected.images(vertices))


def dense_correspondence(found: DenseMap) -> DenseCorrespondence:
    """Name the image of every vertex of the source by the users' own numbers."""
    source, target = found.source.mesh, found.target.mesh
    ids, vertices = source.numbering
    images = found.images(np.arange(source.n_vertices, dtype=np.int64))
    return DenseCorrespondence(ids, target.vertex_ids[images[vertices]], found.hypothesis)
