"""Examples of a class put into correspondence: given, by shared connectivity, or by matching."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.control import Control
from solver.errors import OptionError, PrototypeError
from solver.matching import Correspondence, MatchOptions, match
from solver.prototype.learning.carrying import carried_points
from solver.prototype.learning.distributions import Example, learn_distributions, observed
from solver.prototype.matching import match_prototype
from solver.prototype.options import PrototypeOptions
from solver.prototype.prototype import all_pairs
from solver.shape import Shape, farthest_first

_FIRST_SPREAD = 0.1
"""Relative standard deviation of distances before any example is known."""
_SPREAD_SAMPLES = 2.0
"""Examples that it counts for."""
_POOR = 3.0
"""Times the median misfit beyond which an example is poor."""
_FEW = 4
"""Examples below which a preliminary prototype would say nothing."""

_UNREACHED = "no map to it, there and back, was sure, and with so few examples nothing else tells"
_MISFIT = "its match with the reference misfits those of the others"


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
        (M,) of all shapes offered: energy of their match with a preliminary prototype; 0 where
        nothing was matched.
    left_out
        Why each of the others was left out, by its place.
    """

    examples: tuple[Example, ...]
    kept: tuple[int, ...]
    misfits: FloatArray
    left_out: Mapping[int, str] = field(default_factory=dict)

    @property
    def warnings(self) -> tuple[str, ...]:
        """What the user should know."""
        return tuple(
            f"shapes.{place}: left out, for {reason}" for place, reason in self.left_out.items()
        )


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
        A correspondence does not suit its shape, is shorter than the others, or names fewer places
        than points.
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
    apart = len(np.unique(places[reference]))
    if apart < options.points:
        raise OptionError(
            f"correspondences.{reference}",
            f"only {apart} of its vertices are in places of their own; it must have at least"
            f" {options.points}",
        )
    between = shapes[reference].metric(options.sampling_metrics[0]).between(places[reference])
    start = (int(between.mean(axis=1).argmax()),)
    traversal = farthest_first(between.__getitem__, start, options.points)
    order = np.array([place for place, _, _ in traversal])
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
        The shapes do not share their connectivity, or have fewer vertices than points.
    """
    _check_reference(shapes, reference)
    _check_vertices(shapes, options.points)
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
    """Examples put into correspondence by matching.

    Points of the reference are carried from each shape to those most similar to it, by maps that
    keep orientation: see :func:`.carried_points`. The reference is matched
    with every shape that these do not reach; of fewer than four shapes, which could not overrule a
    match that is wrong, such shapes are left out. Distances can hardly tell a match from its mirror
    image, and which of the two comes first changes from shape to shape. So of each match's answer
    and alternatives, all good by themselves, the one is taken whose distances are most likely given
    those of the examples taken before, the best matches first. Proportions can make single matches
    wrong; so a preliminary prototype, with one Gaussian of each distance and descriptor, is matched
    with all shapes, and takes their place. Then those are left out that misfit it most. Only of
    shapes that the maps reach left is known to be left, and surfaces are kept.

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
        An option does not suit the shapes, or one of them has fewer vertices than points.
    """
    control = control or Control()
    _check_reference(shapes, reference)
    _check_vertices(shapes, options.points)
    first = shapes[reference]
    sampling = options.sampling_metrics[0].settled(first.size)
    own = first.sampling(sampling, options.points).indices
    carried = carried_points(shapes, reference, own, control)
    left_out = dict.fromkeys(carried.unreached if len(shapes) < _FEW else (), _UNREACHED)
    found = {number: [vertices] for number, vertices in carried.vertices.items()}
    energies = dict.fromkeys(found, 0.0)
    matching = MatchOptions(points=options.points, metric=(sampling, "geodesic"))
    for number, shape in enumerate(shapes):
        control.check()
        if number in found or number in left_out:
            continue
        energies[number], found[number] = _matched(first, shape, own, matching, control)
    order = sorted(found, key=lambda number: (number != reference, energies[number]))
    chosen = _consistent(shapes, found, order, options)
    again, misfits = _matched_again(shapes, chosen, reference, options, control)
    chosen = {**again, **carried.vertices}
    limit = _POOR * float(np.median(np.delete(misfits, reference))) if len(shapes) > 2 else np.inf
    poor = [n for n in range(len(shapes)) if n != reference and misfits[n] > limit]
    left_out |= dict.fromkeys(poor, _MISFIT)
    kept = [n for n in range(len(shapes)) if n not in left_out]
    kept.sort(key=lambda number: number != reference)
    examples = tuple(Example(shapes[n], chosen[n], n in carried.vertices) for n in kept)
    return CorrespondingExamples(examples, tuple(kept), misfits, left_out)


def _matched(
    first: Shape, other: Shape, own: IntArray, options: MatchOptions, control: Control
) -> tuple[float, list[IntArray]]:
    """Energy of the reference's match with a shape, and all that it offers for the points."""
    quiet = Control(is_cancelled=control.is_cancelled, deadline=control.deadline)
    answer = match(first, other, options, quiet)
    several = [_in_order(first, other, one, own) for one in (answer.best, *answer.alternatives)]
    return answer.best.energy, several


def _check_reference(shapes: Sequence[Shape], reference: int) -> None:
    if not shapes:
        raise PrototypeError("a prototype needs at least one example")
    if not 0 <= reference < len(shapes):
        raise OptionError("reference", "it is none of the shapes")


def _check_vertices(shapes: Sequence[Shape], points: int) -> None:
    for number, shape in enumerate(shapes):
        if shape.n_vertices < points:
            raise OptionError(
                f"shapes.{number}",
                f"it has {shape.n_vertices} vertices, and {points} points are taken; simplify it"
                " less, or take fewer",
            )


def _together(
    shapes: Sequence[Shape], vertices: Sequence[IntArray], reference: int
) -> CorrespondingExamples:
    order = sorted(range(len(shapes)), key=lambda number: number != reference)
    examples = tuple(Example(shapes[n], vertices[n]) for n in order)
    return CorrespondingExamples(examples, tuple(order), np.zeros(len(shapes)))


def _places_of(shape: Shape, ids: IntArray, field: str) -> IntArray:
    """Vertices of the shape's mesh that have the user's numbers, or stand for those that have."""
    found = shape.mesh.vertices_of(ids)
    if (found < 0).any():
        raise OptionError(field, f"vertex {int(ids[found < 0][0])} is not on the shape")
    return found


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
) -> dict[int, IntArray]:
    """Choose one correspondence of each shape, such that they agree."""
    metric = options.metrics[0]
    chosen: dict[int, IntArray] = {}
    total = square = np.zeros(0)
    for taken, number in enumerate(order):
        offers = [
            shapes[number].metric(metric).between(one)[all_pairs(len(one))] for one in found[number]
        ]
        if not taken:
            best = 0
            prior = _SPREAD_SAMPLES * (_FIRST_SPREAD**2) * float((offers[0] ** 2).mean())
            total, square = np.zeros_like(offers[0]), np.zeros_like(offers[0])
        else:
            mean = total / taken
            variance = (np.maximum(square - taken * mean**2, 0.0) + prior) / (
                taken + _SPREAD_SAMPLES
            )
            best = int(np.argmin([((row - mean) ** 2 / variance).sum() for row in offers]))
        chosen[number] = found[number][best]
        total, square = total + offers[best], square + offers[best] ** 2
    return chosen


def _matched_again(
    shapes: Sequence[Shape],
    chosen: dict[int, IntArray],
    reference: int,
    options: PrototypeOptions,
    control: Control,
) -> tuple[dict[int, IntArray], FloatArray]:
    """Match a preliminary prototype with all shapes but the reference; return its energies too."""
    misfits = np.zeros(len(shapes))
    if len(shapes) < _FEW:
        return chosen, misfits
    order = [reference, *(number for number in chosen if number != reference)]
    quiet = Control(is_cancelled=control.is_cancelled, deadline=control.deadline)
    examples = [Example(shapes[number], chosen[number]) for number in order]
    single = replace(options, components=1)
    preliminary = learn_distributions(observed(examples, single, quiet), single)
    again = dict(chosen)
    for number in order[1:]:
        control.check()
        answer = match_prototype(
            preliminary, shapes[number], MatchOptions(points=options.points), quiet
        )
        misfits[number] = answer.best.energy
        target = _places_of(shapes[number], answer.best.target, "target")
        again[number] = target[np.argsort(answer.best.source)]
    return again, misfits
