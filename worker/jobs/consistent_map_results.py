"""Results of consistent maps: the improvement, its document, and the maps as arrays."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from broker.contracts import (
    CollectionPair,
    CollectionShape,
    ConsistentMapsPayload,
    ConsistentMapsResult,
)
from solver.arrays import IntArray, npz_bytes
from solver.consistency import DOUBTFUL, Consistency, ImprovedMap, images_of, improve
from solver.control import Control
from solver.mesh import TriangleMesh
from solver.registration import Confidence, DenseCorrespondence
from solver.shape import Shape
from worker.jobs.match_results import confidence_of
from worker.jobs.registration_warnings import boundary_of, named_warnings, possible_parts

Pair = tuple[int, int]

_PARTS = "with a long boundary, as parts of a surface have"
_AS_WHOLES = (
    "all shapes were matched as wholes, so that vertices without a partner have images, too; match"
    " parts in pairs"
)


@dataclass(frozen=True, eq=False)
class PairwiseMap:
    """Map of a pair by its match alone, with the warnings of the match that no shape has."""

    dense: DenseCorrespondence
    confidence: Confidence
    warnings: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class Collection:
    """Shapes and their maps; a text is the reason why there is none.

    Parameters
    ----------
    shapes
        By place, as the request names them.
    pairs
        By the places of source and target, the source first.
    """

    shapes: Sequence[Shape | str]
    pairs: Mapping[Pair, PairwiseMap | str]

    @property
    def maps(self) -> dict[Pair, PairwiseMap]:
        """Maps of the pairs that have one."""
        return {pair: one for pair, one in self.pairs.items() if isinstance(one, PairwiseMap)}

    @property
    def mapped(self) -> list[int]:
        """Places of the shapes that a map leads from or to, ascending."""
        return sorted({place for pair in self.maps for place in pair})


@dataclass(frozen=True, eq=False)
class ImprovedCollection:
    """Consistency of the mapped shapes, asked by the places of the request."""

    found: Consistency
    places: Sequence[int]

    def shape(self, place: int) -> int | None:
        """Return the place among the mapped shapes."""
        return self.places.index(place) if place in self.places else None

    def pair(self, pair: Pair) -> Pair:
        """Return the places of a mapped pair among the mapped shapes."""
        return self.places.index(pair[0]), self.places.index(pair[1])

    def replaced(self, pair: Pair) -> ImprovedMap | None:
        """Return the map that replaced that of a mapped pair, if one did."""
        return self.found.improved.get(self.pair(pair))


def consistent_maps_of(
    payload: ConsistentMapsPayload,
    names: Sequence[str | None],
    collection: Collection,
    control: Control,
) -> tuple[ConsistentMapsResult, bytes]:
    """Improve the maps of a collection by one another.

    Parameters
    ----------
    payload
        Of the job, which names the shapes.
    names
        Names of the shapes.
    collection
        The shapes and their pairwise maps, of which there is one at least.
    control
        Reports progress and cancels; past its deadline, less is tried.

    Returns
    -------
    The document, without timings, and the arrays as the bytes of an ``.npz`` file.

    Raises
    ------
    Cancelled
        Through `control`.
    """
    improved = _improved(collection, control)
    document = ConsistentMapsResult(
        shapes=_shape_reports(payload, names, collection, improved),
        pairs=_pair_reports(payload, names, collection, improved),
        cycle_error_before=improved.found.before.mean,
        cycle_error=improved.found.after.mean,
        warnings=_warnings(payload, names, collection),
        timings={},
    )
    return document, _arrays(payload, collection, improved)


def _improved(collection: Collection, control: Control) -> ImprovedCollection:
    places, maps = collection.mapped, collection.maps
    mapped = (collection.shapes[place] for place in places)
    shapes = [shape for shape in mapped if isinstance(shape, Shape)]
    images: dict[Pair, IntArray] = {}
    probabilities: dict[Pair, float] = {}
    for pair, one in maps.items():
        i, j = (places.index(place) for place in pair)
        images[i, j], images[j, i] = images_of(one.dense, shapes[i], shapes[j])
        probabilities[i, j] = one.confidence.probability
    return ImprovedCollection(improve(shapes, images, probabilities, control), places)


def _shape_reports(
    payload: ConsistentMapsPayload,
    names: Sequence[str | None],
    collection: Collection,
    improved: ImprovedCollection,
) -> tuple[CollectionShape, ...]:
    found, reports = improved.found, []
    doubtful = found.doubtful_shapes()
    for place, (shape, name) in enumerate(zip(payload.shapes, names, strict=True)):
        own, given = improved.shape(place), collection.shapes[place]
        before = None if own is None else found.before.of_shape(own)
        after = None if own is None else found.after.of_shape(own)
        reason = None
        if own is None:
            reason = given if isinstance(given, str) else "none of its pairs could be matched"
        elif own in doubtful:
            reason = (
                f"most of its maps disagree with others: their cycle errors are above {DOUBTFUL}"
            )
        reports.append(
            CollectionShape(
                shape=shape,
                name=name,
                cycle_error_before=before,
                cycle_error=after,
                fits=reason is None,
                reason=reason,
            )
        )
    return tuple(reports)


def _pair_reports(
    payload: ConsistentMapsPayload,
    names: Sequence[str | None],
    collection: Collection,
    improved: ImprovedCollection,
) -> tuple[CollectionPair, ...]:
    doubtful = frozenset(improved.found.doubtful_pairs())
    return tuple(
        _pair_report(payload, names, pair, one, improved, doubtful)
        for pair, one in collection.pairs.items()
    )


def _pair_report(
    payload: ConsistentMapsPayload,
    names: Sequence[str | None],
    pair: Pair,
    given: PairwiseMap | str,
    improved: ImprovedCollection,
    doubtful: frozenset[Pair],
) -> CollectionPair:
    source, target = pair
    unmapped = CollectionPair(
        source=payload.shapes[source],
        source_name=names[source],
        target=payload.shapes[target],
        target_name=names[target],
        mapped=False,
        confidence_before=None,
        confidence=None,
        cycle_error_before=None,
        cycle_error=None,
        through=(),
        fits=False,
        reason=given if isinstance(given, str) else None,
    )
    if isinstance(given, str):
        return unmapped
    own, found, replaced = improved.pair(pair), improved.found, improved.replaced(pair)
    confidence = given.confidence if replaced is None else replaced.confidence
    reason = None
    if own in doubtful:
        wrong = confidence_of(confidence).in_doubt
        about = "it is probably wrong" if wrong else f"its cycle error is above {DOUBTFUL}"
        reason = f"{about}; see its confidence and its cycle error"
    path = () if replaced is None else replaced.path[1:-1]
    changes = {
        "mapped": True,
        "confidence_before": confidence_of(given.confidence),
        "confidence": confidence_of(confidence),
        "cycle_error_before": found.before.of_pair(own),
        "cycle_error": found.after.of_pair(own),
        "through": tuple(payload.shapes[improved.places[place]] for place in path),
        "fits": reason is None,
        "reason": reason,
    }
    return unmapped.model_copy(update=changes)


def _warnings(
    payload: ConsistentMapsPayload, names: Sequence[str | None], collection: Collection
) -> tuple[str, ...]:
    """Return those of shapes and pairs, and which may be parts: those with the most boundary."""
    named = [name or shape for shape, name in zip(payload.shapes, names, strict=True)]
    usable = [
        (name, one.mesh)
        for name, one in zip(named, collection.shapes, strict=True)
        if isinstance(one, Shape)
    ]
    boundaries = [boundary_of(mesh) for _, mesh in usable]
    parts = possible_parts([name for name, _ in usable], boundaries, min(boundaries))
    return (
        *named_warnings((name, mesh.warnings) for name, mesh in usable),
        *named_warnings(
            (f"{named[i]} with {named[j]}", one.warnings) for (i, j), one in collection.maps.items()
        ),
        *([f"{_PARTS}: {parts}; {_AS_WHOLES}"] if parts else []),
    )


def _arrays(
    payload: ConsistentMapsPayload, collection: Collection, improved: ImprovedCollection
) -> bytes:
    """Return the maps as the bytes of an ``.npz`` file without pickled objects.

    `shapes` (N,) ids; `map_I_J` (V_I,) int64 for each mapped pair, both ways: row v is the vertex
    of the file of shape J that vertex v of the file of shape I goes to, -1 if v is not matched.
    """
    arrays: dict[str, npt.NDArray[Any]] = {"shapes": np.array(payload.shapes)}
    for (i, j), one in collection.maps.items():
        replaced = improved.replaced((i, j))
        dense = one.dense if replaced is None else replaced.dense
        assert dense.inverse is not None
        for here, there, directed in ((i, j, dense), (j, i, dense.inverse)):
            shape = collection.shapes[here]
            assert isinstance(shape, Shape)
            arrays[f"map_{here}_{there}"] = _rows_of_file(shape.mesh, directed)
    return npz_bytes(arrays)


def _rows_of_file(mesh: TriangleMesh, dense: DenseCorrespondence) -> IntArray:
    rows = np.full(mesh.vertex_rows, -1, dtype=np.int64)
    rows[dense.source] = dense.target
    return rows
