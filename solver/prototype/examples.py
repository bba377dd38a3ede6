"""Examples of a class put into correspondence: given, by shared connectivity, or by matching."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.control import Control
from solver.errors import OptionError, PrototypeError
from solver.match import Correspondence
from solver.matching import match
from solver.options import MatchOptions
from solver.prototype.learning import Example
from solver.prototype.options import PrototypeOptions
from solver.prototype.prototype import all_pairs
from solver.shape import Shape

_FIRST_SPREAD = 0.1
"""Relative standard deviation of distances before any example is known."""
_SPREAD_SAMPLES = 2.0
"""Examples that it counts for."""
_POOR = 3.0
"""Times the median misfit beyond which an example is poor."""
_HOPELESS = 0.15
"""Mean squared relative misfit of distances that is poor whatever the others are."""


@dataclass(frozen=True, eq=False)
class CorrespondingExamples:
    """Examples with what became of those that were offered.

    Parameters
    ----------
    examples
        M' <= M examples, the reference first.
    kept
        (M',) their places among the shapes offered.
    misfits
        (M,) of all shapes offered: mean squared deviation of their distances from the mean of the
        others', relative to the mean square distance; 0 where nothing was matched.
    warnings
        What the user should know, with places of shapes that were left out.
    """

    examples: tuple[Example, ...]
    kept: tuple[int, ...]
    misfits: FloatArray
    warnings: tuple[str, ...] = ()


def given_examples(
    shapes: Sequence[Shape],
    correspondences: Sequence[IntArray],
    options: PrototypeOptions,
    reference: int = 0,
) -> CorrespondingExamples:
    """Examples whose corresponding vertices are known.

    Parameters
    ----------
    shapes
        M shapes.
    correspondences
        M arrays of equal length of the user's vertex numbers: those at equal places correspond.
    options
        Of the prototype. Its points are taken from those given, farthest first.
    reference
        Place of the shape whose distances say which are farthest.

    Raises
    ------
    OptionError
        A correspondence does not suit its shape, or is shorter than the others.
    """
    _check_reference(shapes, reference)
    if len(correspondences) != len(shapes):
        raise OptionError("correspondences", f"{len(shapes)} are needed, one of each shape")
    places = []
    for number, (shape, ids) in enumerate(zip(shapes, correspondences, strict=True)):
        if len(ids) != len(correspondences[0]):
            raise OptionError(f"correspondences.{number}", "it must be as long as the others")
        if len(ids) < options.points:
            raise OptionError(
                f"correspondences.{number}", f"it must have at least {options.points} vertices"
            )
        places.append(_places_of(shape, np.asarray(ids), f"correspondences.{number}"))
    between = shapes[reference].metric(options.sampling_metrics[0]).between(places[reference])
    order = _farthest_first(between, options.points)
    return _together(shapes, [vertices[order] for vertices in places], reference)


def connected_examples(
    shapes: Sequence[Shape], options: PrototypeOptions, reference: int = 0
) -> CorrespondingExamples:
    """Examples that share their connectivity: vertex i of one is vertex i of all.

    Parameters
    ----------
    shapes
        M shapes.
    options
        Of the prototype, whose points are those of a farthest point sampling of the reference.
    reference
        Its place.

    Raises
    ------
    OptionError
        The shapes do not share their connectivity.
    """
    _check_reference(shapes, reference)
    first = shapes[reference]
    for number, shape in enumerate(shapes):
        ids = shape.mesh.vertex_ids, shape.mesh.faces
        if not (
            np.array_equal(ids[0], first.mesh.vertex_ids)
            and np.array_equal(ids[1], first.mesh.faces)
        ):
            raise OptionError(
                f"shapes.{number}", "its triangles are not those of the reference, vertex by vertex"
            )
    vertices = first.sampling(options.sampling_metrics[0], options.points).indices
    return _together(shapes, [vertices] * len(shapes), reference)


def matched_examples(
    shapes: Sequence[Shape],
    options: PrototypeOptions,
    reference: int = 0,
    control: Control | None = None,
) -> CorrespondingExamples:
    """Examples put into correspondence by matching the reference with each.

    Distances can hardly tell a match from its mirror image, and which of the two comes first
    changes from shape to shape. So of each match's answer and alternatives, all good by
    themselves, the one is taken whose distances are most likely given those of the examples taken
    before, the best matches first. Then those are left out that misfit the others most.

    Parameters
    ----------
    shapes
        M shapes.
    options
        Of the prototype.
    reference
        Place of the shape that is matched with the others, and is the first example.
    control
        Reports progress and cancels.

    Raises
    ------
    Cancelled
        Through `control`.
    OptionError
        An option does not suit the shapes.
    """
    control = control or Control()
    _check_reference(shapes, reference)
    first = shapes[reference]
    own = first.sampling("commute_time", options.points).indices
    found: dict[int, list[IntArray]] = {reference: [own]}
    energies = {reference: 0.0}
    quiet = Control(is_cancelled=control.is_cancelled, deadline=control.deadline)
    for number, shape in enumerate(shapes):
        control.report("matches of the examples", number / len(shapes))
        if number == reference:
            continue
        answer = match(first, shape, MatchOptions(points=options.points), quiet)
        energies[number] = answer.best.energy
        found[number] = [
            _in_order(first, shape, one, own) for one in (answer.best, *answer.alternatives)
        ]
    order = sorted(found, key=lambda number: energies[number])
    chosen, misfits = _consistent(shapes, found, order, options)
    limit = max(_POOR * float(np.median(misfits)), 1e-6)
    poor = [n for n in range(len(shapes)) if n != reference and misfits[n] > min(limit, _HOPELESS)]
    warnings = tuple(
        f"shape {number} was left out: its match with the reference misfits those of the others"
        for number in poor
    )
    kept = [n for n in range(len(shapes)) if n not in poor]
    kept.sort(key=lambda number: number != reference)
    examples = tuple(Example(shapes[n], chosen[n]) for n in kept)
    return CorrespondingExamples(examples, tuple(kept), misfits, warnings)


def _check_reference(shapes: Sequence[Shape], reference: int) -> None:
    if not shapes:
        raise PrototypeError("a prototype needs at least one example")
    if not 0 <= reference < len(shapes):
        raise OptionError("reference", "it is none of the shapes")


def _together(
    shapes: Sequence[Shape], vertices: Sequence[IntArray], reference: int
) -> CorrespondingExamples:
    order = sorted(range(len(shapes)), key=lambda number: number != reference)
    examples = tuple(Example(shapes[n], vertices[n]) for n in order)
    return CorrespondingExamples(examples, tuple(order), np.zeros(len(shapes)))


def _places_of(shape: Shape, ids: IntArray, field: str) -> IntArray:
    """Vertices of the shape's mesh that have the user's numbers."""
    known = shape.mesh.vertex_ids
    order = np.argsort(known, kind="stable")
    place = np.minimum(np.searchsorted(known[order], ids), len(known) - 1)
    found: IntArray = order[place]
    if (known[found] != ids).any():
        missing = int(ids[known[found] != ids][0])
        raise OptionError(field, f"vertex {missing} is not on the shape")
    return found


def _farthest_first(distances: FloatArray, count: int) -> IntArray:
    """(count,) points in order of a farthest point sampling."""
    order = [int(distances.mean(axis=1).argmax())]
    nearest = distances[order[0]].copy()
    nearest[order[0]] = -1.0
    while len(order) < count:
        order.append(int(nearest.argmax()))
        nearest = np.minimum(nearest, distances[order[-1]])
        nearest[order] = -1.0
    return np.array(order, dtype=np.int64)


def _in_order(first: Shape, other: Shape, found: Correspondence, own: IntArray) -> IntArray:
    """(N,) vertices of the other shape that a match gave the reference's points."""
    source = _places_of(first, found.source, "source")
    target = _places_of(other, found.target, "target")
    partner = dict(zip(source.tolist(), target.tolist(), strict=True))
    return np.array([partner[vertex] for vertex in own.tolist()], dtype=np.int64)


def _consistent(
    shapes: Sequence[Shape],
    found: dict[int, list[IntArray]],
    order: list[int],
    options: PrototypeOptions,
) -> tuple[dict[int, IntArray], FloatArray]:
    """Choose one correspondence of each shape, and measure how it misfits the others."""
    metric = options.metrics[0]
    chosen: dict[int, IntArray] = {}
    rows: dict[int, FloatArray] = {}
    total = square = np.zeros(0)
    for number in order:
        offers = [
            shapes[number].metric(metric).between(one)[all_pairs(len(one))] for one in found[number]
        ]
        if not rows:
            best = 0
            prior = _SPREAD_SAMPLES * (_FIRST_SPREAD**2) * float((offers[0] ** 2).mean())
            total, square = np.zeros_like(offers[0]), np.zeros_like(offers[0])
        else:
            mean = total / len(rows)
            variance = (np.maximum(square - len(rows) * mean**2, 0.0) + prior) / (
                len(rows) + _SPREAD_SAMPLES
            )
            best = int(np.argmin([((row - mean) ** 2 / variance).sum() for row in offers]))
        chosen[number], rows[number] = found[number][best], offers[best]
        total, square = total + offers[best], square + offers[best] ** 2
    misfits = np.zeros(len(shapes))
    if len(rows) > 2:
        for number, row in rows.items():
            rest = (total - row) / (len(rows) - 1)
            misfits[number] = float(((row - rest) ** 2).mean() / max((rest**2).mean(), 1e-300))
    return chosen, misfits
