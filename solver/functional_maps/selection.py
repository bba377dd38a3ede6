"""Selection of the map of all vertices that extends a match.

Intrinsically a correspondence and its mirror image cannot be distinguished, and the energy accepts
either. Their extensions to all vertices can: one preserves the orientation of the surface, the
other reverses it. Where all hypotheses reverse it, or it is not clear, further maps are made: from
the signs of eigenfunctions, by restarting the best maps from fewer eigenfunctions, and by composing
these with a reflection of the source.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.control import Control
from solver.functional_maps.dense_map import (
    DenseMap,
    drop_similar_maps,
    rank_by_quality,
    rank_maps,
)
from solver.functional_maps.extension import complete_map, extend_hypotheses, extend_map
from solver.functional_maps.functional_map import FunctionalMap
from solver.functional_maps.map_quality import Comparison
from solver.functional_maps.symmetry import compose_maps, find_reflection, maps_from_signs
from solver.shape import Shape

MIN_POINTS_EXTENDED = 3
"""Least number of matched points from which a map of all vertices is made."""

# The other constants are chosen on generated people and animals; `bench.dense` measures them.

_HYPOTHESES = 4
"""Hypotheses that are extended, and again if none of the first preserves orientation."""

_CLEAR_ORIENTATION = 0.65
"""Orientation score of correct maps between nearly isometric shapes; maps of less may be mirrored
in parts."""

_CHANGE_RATIO = 1.1
"""Ratio to the least change of any map from which on a map is not clearly the best: the mirror
image of the latter may be better."""

_RESTARTED_MAPS = 3
"""Best maps that are restarted, and composed with a reflection."""

_RESTART_SIZES = 10, 16, 24, 36
"""Eigenfunctions from which a map is restarted. The more there are, the less changes."""


@dataclass(frozen=True, eq=False)
class DenseCorrespondence:
    """A map of all vertices.

    Parameters
    ----------
    source
        (K,) the user's numbers of all vertices of the source's surface, ascending.
    target
        (K,) the user's number of the vertex nearest to each one's image; several may have the same.
    faces
        (K, 3) the user's numbers of the corners of the target's triangle that holds each image.
    barycentric
        (K, 3) barycentric coordinates of each image in its triangle; each row has the sum 1.
    hypothesis
        Hypothesis that was extended: 0 for the match's best, or one more than a place among its
        alternatives.
    """

    source: IntArray
    target: IntArray
    faces: IntArray
    barycentric: FloatArray
    hypothesis: int


def select_map(
    source: Shape,
    target: Shape,
    hypotheses: Sequence[tuple[IntArray, IntArray]],
    control: Control,
    further: bool = True,
) -> DenseMap | None:
    """Extend a match's hypotheses to all vertices, and select the best orientation-preserving map.

    Parameters
    ----------
    source, target
        The shapes X and Y.
    hypotheses
        (n,) vertices of X and (n,) vertices of Y that correspond, the likeliest first. Those
        of less than three points are skipped.
    control
        May cancel; past its deadline, less is tried.
    further
        Whether maps may be made that extend none of the hypotheses, if it is not clear that one of
        these preserves orientation. Where landmarks choose between symmetric solutions, they
        should not.

    Returns
    -------
    Its `hypothesis` is a place among those given, or their number if it extends none of them;
    ``None`` if the first has too few points.

    Raises
    ------
    Cancelled
        Through `control`.
    """
    if len(hypotheses[0][0]) < MIN_POINTS_EXTENDED:
        return None
    comparison = Comparison(source, target)
    places = [i for i, (x, _) in enumerate(hypotheses) if len(x) >= MIN_POINTS_EXTENDED]
    found: list[DenseMap] = []
    for some in places[:_HYPOTHESES], places[_HYPOTHESES : 2 * _HYPOTHESES]:
        for place in some:
            found += extend_hypotheses(comparison, [hypotheses[place]], control, first=place)
        if rank_maps(found)[0].preserves_orientation:
            break
    if further and not _is_clear(found):
        none_of_them = len(hypotheses)
        found += maps_from_signs(comparison, control, none_of_them)
        found += _restart(comparison, found, control, none_of_them)
        found += list(_reflect(comparison, found, control, none_of_them))
    return complete_map(comparison, rank_maps(found)[0])


def _is_clear(found: Sequence[DenseMap]) -> bool:
    """Return whether the best map clearly preserves orientation, and none changes much less."""
    best = rank_maps(found)[0]
    least = min(one.change for one in found)
    return best.orientation_score >= _CLEAR_ORIENTATION and best.change <= _CHANGE_RATIO * least


def _restart(
    comparison: Comparison, found: Sequence[DenseMap], control: Control, hypothesis: int
) -> list[DenseMap]:
    """Restart ZoomOut from fewer eigenfunctions of the best maps, which may lead to other maps."""
    best = drop_similar_maps(rank_by_quality(found), _RESTARTED_MAPS)
    starts = [one.functional_map.matrix[:size, :size] for one in best for size in _RESTART_SIZES]
    return [
        extend_map(comparison, FunctionalMap(matrix), hypothesis)
        for matrix in control.in_time(starts)
    ]


def _reflect(
    comparison: Comparison, found: Sequence[DenseMap], control: Control, hypothesis: int
) -> Iterator[DenseMap]:
    """Compose the best maps with the reflection of X."""
    if control.expired:
        return
    reflected = find_reflection(comparison.source.shape, control)
    if reflected is None:
        return
    for one in drop_similar_maps(rank_by_quality(found), _RESTARTED_MAPS):
        yield from compose_maps(comparison, reflected, one, control, hypothesis)


def dense_correspondence(found: DenseMap) -> DenseCorrespondence:
    """Return a map of all vertices in the users' own numbers."""
    source, target = found.source.mesh, found.target.mesh
    ids, vertices = source.numbering
    images = found.images(np.arange(source.n_vertices, dtype=np.int64))
    nearest = images[vertices]
    corners = target.faces.ravel()
    # Of the triangles that share a vertex, any holds it.
    held = np.empty(target.n_vertices, dtype=np.int64)
    held[corners] = np.arange(len(corners))
    faces, corner = np.divmod(held[nearest], 3)
    return DenseCorrespondence(
        ids,
        target.vertex_ids[nearest],
        target.vertex_ids[target.faces[faces]],
        np.eye(3)[corner],
        found.hypothesis,
    )
