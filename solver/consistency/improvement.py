"""Maps of a collection that agree with one another: pairs in doubt are mapped by way of others.

A pair whose map is in doubt may be reached more safely through other shapes: by a path whose maps
are all right with a greater probability than the direct one. Such compositions are hypotheses: each
is registered, as the direct map is, and the one of least score − log p is taken, where scores are
sums of logarithms of misfits. So a pair changes only if the collection offers a path that is more
probable, and the surfaces do not speak against it as strongly; maps that are sure stay as they are.
"""

from collections.abc import Iterator, Mapping, Sequence, Set
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Final

import numpy as np

from solver.arrays import IntArray
from solver.consistency.maps import CollectionMaps, CycleErrors, Pair, cycle_errors
from solver.consistency.paths import probable_paths
from solver.control import Control
from solver.registration import (
    RIGHT_ERROR,
    Confidence,
    DenseCorrespondence,
    Registration,
    register_map,
    smooth_surface,
)
from solver.shape import Shape

ROUNDS: Final = 2
"""Rounds over all pairs: the second goes by way of what the first has put right."""

PATHS: Final = 3
"""Compositions that are registered for a pair in doubt."""

LENGTH: Final = 4
"""Greatest number of maps in a composition: each adds its error."""

SAMPLES: Final = 200
"""Samples of each shape that cycle errors are the means of."""

DOUBTFUL: Final = RIGHT_ERROR
"""Cycle error over √area above which maps are at odds with others: that of a wrong map."""

_LEAST_PROBABILITY: Final = 1e-9
"""Least probability whose logarithm is taken."""


@dataclass(frozen=True, eq=False)
class ImprovedMap:
    """A map composed of maps through other shapes.

    Parameters
    ----------
    path
        Places of the shapes whose maps were composed, source and target included. Maps of the
        second round may be compositions of the first one; shapes that these went through are not
        among them.
    dense
        The map of all vertices, and its inverse.
    confidence
        That it is right.
    score, direct_score
        Scores of the fit of this map and of the direct one; the less, the better.
    """

    path: tuple[int, ...]
    dense: DenseCorrespondence
    confidence: Confidence
    score: float
    direct_score: float


@dataclass(frozen=True, eq=False)
class Consistency:
    """Maps of a collection, improved by one another.

    Parameters
    ----------
    maps
        All maps after the improvement.
    improved
        Those that have changed, by their pairs (i, j), i < j.
    before, after
        Cycle errors of the maps that were given, and of these.
    """

    maps: CollectionMaps
    improved: Mapping[Pair, ImprovedMap]
    before: CycleErrors
    after: CycleErrors

    def doubtful_pairs(self) -> tuple[Pair, ...]:
        """Return the pairs that do not fit: probably wrong, or at odds with most of the others."""
        return tuple(
            pair
            for pair in self.maps.pairs()
            if self.maps.probabilities[pair] <= 0.5 or _above(self.after.of_pair(pair))
        )

    def doubtful_shapes(self) -> tuple[int, ...]:
        """Return the shapes more than half of whose maps are at odds with the others.

        Of three shapes it is all or none: which of three maps is wrong, cycles do not tell.
        """
        errors = {pair: self.after.of_pair(pair) for pair in self.maps.pairs()}
        found = []
        for place in range(self.maps.count):
            own = [one for pair, one in errors.items() if place in pair and one is not None]
            if 2 * sum(map(_above, own)) > len(own):
                found.append(place)
        return tuple(found)


def improve(
    shapes: Sequence[Shape],
    images: Mapping[Pair, IntArray],
    probabilities: Mapping[Pair, float],
    control: Control | None = None,
) -> Consistency:
    """Replace maps in doubt by compositions through other shapes.

    Parameters
    ----------
    shapes
        N shapes.
    images
        (V_i,) vertices of j that the vertices of i go to, both ways of each pair that is known.
    probabilities
        That the maps of the pairs are right, by (i, j), i < j.
    control
        Reports progress and cancels; past its deadline, less is tried.

    Raises
    ------
    Cancelled
        Through `control`.
    MeshError
        The Laplacian of a shape cannot be factored.
    """
    control = control or Control()
    surfaces = [smooth_surface(shape) for shape in shapes]
    both = {**probabilities, **{(j, i): p for (i, j), p in probabilities.items()}}
    maps = CollectionMaps([one.mesh.vertices for one in surfaces], images, both)
    samples = [one.samples.vertices[:SAMPLES] for one in surfaces]
    before = cycle_errors(maps, samples)
    improved: dict[Pair, ImprovedMap] = {}
    changed: Set[Pair] = set(maps.pairs())
    for number in range(ROUNDS):
        found = dict(_round(shapes, maps, changed, number, control))
        improved |= found
        changed = found.keys()
        if not found:
            break
        maps = _updated(shapes, maps, found)
    after = cycle_errors(maps, samples) if improved else before
    return Consistency(maps, improved, before, after)


def _round(
    shapes: Sequence[Shape],
    maps: CollectionMaps,
    changed: Set[Pair],
    number: int,
    control: Control,
) -> Iterator[tuple[Pair, ImprovedMap]]:
    """Yield the maps that are better than those of the round before.

    Only pairs that have changed then, or may be reached by way of one, are tried.
    """
    pairs = list(maps.pairs())
    for place, pair in enumerate(pairs):
        control.check()
        if control.expired:
            return
        control.report("consistency", (number + place / len(pairs)) / ROUNDS)
        direct = maps.probabilities[pair]
        paths = [
            one
            for one in probable_paths(maps.probabilities, pair, PATHS, LENGTH)
            if one[0] > direct
        ]
        ways = {pair, *(step for _, path in paths for step in _steps(path))}
        if not paths or changed.isdisjoint(ways):
            continue
        if (better := _better(shapes, maps, pair, paths, control)) is not None:
            yield pair, better


def _steps(path: Sequence[int]) -> Iterator[Pair]:
    """Yield the pairs (i, j), i < j, whose maps a path consists of."""
    return ((min(step), max(step)) for step in pairwise(path))


def _better(
    shapes: Sequence[Shape],
    maps: CollectionMaps,
    pair: Pair,
    paths: Sequence[tuple[float, tuple[int, ...]]],
    control: Control,
) -> ImprovedMap | None:
    """Return the best composition, registered; None if the direct map is better, or the same."""
    source, target = (shapes[place] for place in pair)

    def registered(path: Sequence[int]) -> Registration:
        return register_map(source, target, maps.along(path), maps.along(path[::-1]), control)

    direct = registered(pair)
    found = [(probability, path, registered(path)) for probability, path in paths]
    probability, path, chosen = min(found, key=lambda one: one[2].score - np.log(one[0]))
    known = direct.score - np.log(max(maps.probabilities[pair], _LEAST_PROBABILITY))
    if not chosen.differs_from(direct) or chosen.score - np.log(probability) >= known:
        return None
    # It is right if all maps of the path are.
    confidence = chosen.among(direct).confidence.at_least(probability)
    return ImprovedMap(path, chosen.dense(control), confidence, chosen.score, direct.score)


def _updated(
    shapes: Sequence[Shape], maps: CollectionMaps, found: Mapping[Pair, ImprovedMap]
) -> CollectionMaps:
    images, probabilities = dict(maps.images), dict(maps.probabilities)
    for (i, j), one in found.items():
        images[i, j], images[j, i] = images_of(one.dense, shapes[i], shapes[j])
        probabilities[i, j] = probabilities[j, i] = one.confidence.probability
    return replace(maps, images=images, probabilities=probabilities)


def images_of(
    dense: DenseCorrespondence, source: Shape, target: Shape
) -> tuple[IntArray, IntArray]:
    """Return a map and its inverse by the vertices of the meshes, not of the user's files.

    Returns
    -------
    (V,) vertices of the target, and (W,) vertices of the source.

    Raises
    ------
    ValueError
        The map leaves vertices out, as that of a part does.
    """
    assert dense.inverse is not None
    forward = _by_vertex(dense.source, dense.target, source, target)
    return forward, _by_vertex(dense.inverse.source, dense.inverse.target, target, source)


def _by_vertex(given: IntArray, images: IntArray, source: Shape, target: Shape) -> IntArray:
    found = np.full(source.mesh.n_vertices, -1)
    found[source.mesh.vertices_of(given)] = target.mesh.vertices_of(images)
    if left_out := int((found < 0).sum()):
        raise ValueError(
            f"the map leaves out {left_out} of {len(found)} vertices; maps of a collection are of"
            ' whole shapes: match them with partial="none"'
        )
    return found


def _above(error: float | None) -> bool:
    return error is not None and error > DOUBTFUL
