"""Examples of a class in correspondence: given, or by shared connectivity (section 5)."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.errors import OptionError, PrototypeError
from solver.prototype.learning.observations import Example
from solver.prototype.options import PrototypeOptions
from solver.shape import Shape, farthest_first


@dataclass(frozen=True, eq=False)
class CorrespondingExamples:
    """Examples in correspondence, and the shapes that were left out.

    Parameters
    ----------
    examples
        M' <= M examples, the reference first.
    kept
        (M',) their places among the given shapes.
    misfits
        (M,) energies of all given shapes matched with a preliminary prototype; 0 where nothing was
        matched.
    left_out
        By place, why each of the other shapes was left out.
    """

    examples: tuple[Example, ...]
    kept: tuple[int, ...]
    misfits: FloatArray
    left_out: Mapping[int, str] = field(default_factory=dict)

    @property
    def warnings(self) -> tuple[str, ...]:
        """Warnings for the user."""
        return tuple(
            f"shapes.{place}: left out, for {reason}" for place, reason in self.left_out.items()
        )


def given_examples(
    shapes: Sequence[Shape],
    correspondences: Sequence[IntArray],
    options: PrototypeOptions,
    reference: int = 0,
) -> CorrespondingExamples:
    """Return examples whose corresponding vertices are given.

    Parameters
    ----------
    shapes
        M shapes.
    correspondences
        M arrays of (K,) vertex numbers of the user's; those at equal places correspond.
    options
        Of the prototype. Its points are taken from those given, farthest first.
    reference
        Place of the reference, on which points are sampled farthest first.

    Raises
    ------
    OptionError
        A correspondence does not suit its shape, differs in length from the others, or has fewer
        distinct vertices than points.
    """
    check_reference(shapes, reference)
    if len(correspondences) != len(shapes):
        raise OptionError("correspondences", f"{len(shapes)} are needed, one for each shape")
    places = []
    for number, (shape, ids) in enumerate(zip(shapes, correspondences, strict=True)):
        if len(ids) != len(correspondences[0]):
            raise OptionError(f"correspondences.{number}", "it must be as long as the others")
        if len(ids) < options.points:
            raise OptionError(
                f"correspondences.{number}", f"it must have at least {options.points} vertices"
            )
        places.append(vertices_of(shape, np.asarray(ids), f"correspondences.{number}"))
    apart = len(np.unique(places[reference]))
    if apart < options.points:
        raise OptionError(
            f"correspondences.{reference}",
            f"only {apart} of its vertices are distinct; it must have at least {options.points}",
        )
    between = shapes[reference].metric(options.sampling_metrics[0]).between(places[reference])
    start = (int(between.mean(axis=1).argmax()),)
    traversal = farthest_first(between.__getitem__, start, options.points)
    order = np.array([place for place, _, _ in traversal])
    return arrange(shapes, [vertices[order] for vertices in places], reference)


def connected_examples(
    shapes: Sequence[Shape], options: PrototypeOptions, reference: int = 0
) -> CorrespondingExamples:
    """Return examples with the same connectivity: vertex i of one corresponds to vertex i of all.

    Parameters
    ----------
    shapes
        M shapes.
    options
        Of the prototype, whose points are those of a farthest point sampling of the reference.
    reference
        Place of the reference.

    Raises
    ------
    OptionError
        The shapes do not share their connectivity, or have fewer vertices than points.
    """
    check_reference(shapes, reference)
    check_vertices(shapes, options.points)
    first = shapes[reference]
    for number, shape in enumerate(shapes):
        ids = shape.mesh.vertex_ids, shape.mesh.faces
        if not (
            np.array_equal(ids[0], first.mesh.vertex_ids)
            and np.array_equal(ids[1], first.mesh.faces)
        ):
            raise OptionError(
                f"shapes.{number}", "its triangles differ from those of the reference"
            )
    vertices = first.sampling(options.sampling_metrics[0], options.points).indices
    return arrange(shapes, [vertices] * len(shapes), reference)


def check_reference(shapes: Sequence[Shape], reference: int) -> None:
    """Raise an error if the reference is not among the shapes."""
    if not shapes:
        raise PrototypeError("a prototype needs at least one example")
    if not 0 <= reference < len(shapes):
        raise OptionError(
            "reference", f"{reference} is out of range: there are {len(shapes)} shapes"
        )


def check_vertices(shapes: Sequence[Shape], points: int) -> None:
    """Raise an error if a shape has fewer vertices than points."""
    for number, shape in enumerate(shapes):
        if shape.n_vertices < points:
            raise OptionError(
                f"shapes.{number}",
                f"it has {shape.n_vertices} vertices, fewer than {points} points; simplify it less,"
                " or take fewer points",
            )


def arrange(
    shapes: Sequence[Shape], vertices: Sequence[IntArray], reference: int
) -> CorrespondingExamples:
    """Return all shapes as examples, the reference first."""
    order = sorted(range(len(shapes)), key=lambda number: number != reference)
    examples = tuple(Example(shapes[n], vertices[n]) for n in order)
    return CorrespondingExamples(examples, tuple(order), np.zeros(len(shapes)))


def vertices_of(shape: Shape, ids: IntArray, field: str) -> IntArray:
    """Return the vertices of the shape's mesh with the user's numbers, or merged with those."""
    found = shape.mesh.vertices_of(ids)
    if (found < 0).any():
        raise OptionError(field, f"vertex {int(ids[found < 0][0])} is not on the shape")
    return found
