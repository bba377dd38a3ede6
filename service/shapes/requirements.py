"""Checks of shapes against the parameters of a job, from their records, before it is queued."""

from collections.abc import Collection, Iterable, Mapping, Sequence
from typing import TypeAlias

from broker.contracts import (
    DissimilarityParameters,
    FieldProblem,
    MatchParameters,
    PrototypeParameters,
    ShapeRecord,
)
from service.http import MOST_FIELDS, InvalidRequest

Parameters: TypeAlias = MatchParameters | DissimilarityParameters | PrototypeParameters


def shape_fields(shapes: Sequence[str]) -> dict[str, str]:
    """Return the ids of a list of shapes by the fields that name them."""
    return {f"body.shapes.{place}": shape for place, shape in enumerate(shapes)}


def repeated_shapes(
    shapes: Sequence[str], names: Sequence[str | None] | None = None
) -> list[FieldProblem]:
    """Return the problems of shapes that are listed more than once.

    Parameters
    ----------
    shapes
        Their ids.
    names
        Their names, where the request has them.
    """
    first: dict[str, int] = {}
    wrong = []
    for place, shape in enumerate(shapes):
        if shape in first:
            one, other = (None if names is None else names[at] for at in (place, first[shape]))
            same = "this shape" if one is None or one == other else f"{one!r}"
            as_other = "" if other is None else f" ({other!r})"
            message = f"{same} is the same as shapes.{first[shape]}{as_other}; give each once"
            wrong.append(FieldProblem(field=f"body.shapes.{place}", message=message))
        first.setdefault(shape, place)
    return wrong


def check_shapes(
    asked: Parameters,
    shapes: Mapping[str, ShapeRecord],
    detail: str,
    further: Sequence[FieldProblem] = (),
) -> None:
    """Refuse shapes that do not meet the requirements of a job.

    Parameters
    ----------
    asked
        Parameters of the job.
    shapes
        By the fields that name them, such as ``body.source``.
    detail
        Detail of the problem that is raised.
    further
        Problems of the request besides those found here.

    Raises
    ------
    InvalidRequest
        A shape has no vertex colours and a descriptor needs them, or would be simplified to fewer
        vertices than `points`.
    """
    without = [
        field.removeprefix("body.") for field, shape in shapes.items() if not shape.has_colors
    ]
    uncolored: list[FieldProblem] = []
    if without and getattr(asked, "first_order_weight", 1.0) > 0.0:
        colored = {choice.name for choice in asked.descriptors if choice.about.needs_colors}
        message = (
            f"needs vertex colours, which are missing in {', '.join(without[:MOST_FIELDS])}; choose"
            " another descriptor, or upload the shape in a format that has colours, such as PLY,"
            " GLB, or OBJ zipped with its materials"
        )
        uncolored = descriptor_problems(asked, colored, message)
    refuse((*further, *uncolored, *simplified_too_far(asked, shapes)), detail)


def descriptor_problems(
    asked: Parameters, unsuitable: Collection[str], message: str
) -> list[FieldProblem]:
    """Return the problems of the chosen descriptors whose names are unsuitable."""
    several = isinstance(asked.descriptor, tuple)
    return [
        FieldProblem(
            field=f"body.descriptor.{place}" if several else "body.descriptor",
            message=f"{choice.name!r} {message}",
        )
        for place, choice in enumerate(asked.descriptors)
        if choice.name in unsuitable
    ]


def few_vertices(shapes: Mapping[str, ShapeRecord], points: int) -> list[FieldProblem]:
    """Return the problems of shapes that have fewer vertices than `points`."""
    return [
        FieldProblem(
            field=field,
            message=f"it has {shape.vertices} vertices, fewer than `points` ({points}); take fewer"
            " points",
        )
        for field, shape in shapes.items()
        if shape.vertices < points
    ]


def vertices_out_of_range(
    numbers: Iterable[tuple[str, int]], shape: ShapeRecord, name: str
) -> list[FieldProblem]:
    """Return the problems of numbers that no vertex of a shape's file has.

    Parameters
    ----------
    numbers
        Fields, and the number that each gives.
    shape
        The shape. Those of earlier versions do not know the vertices of their file.
    name
        Name of the shape in the messages.
    """
    count = shape.file_vertices
    if count is None:
        return []
    message = f"is no vertex of {name}, whose file has vertices 0 to {count - 1}"
    return [
        FieldProblem(field=field, message=f"{number} {message}")
        for field, number in numbers
        if number >= count
    ]


def simplified_too_far(asked: Parameters, shapes: Mapping[str, ShapeRecord]) -> list[FieldProblem]:
    """Return the problem of `simplify`, if it leaves fewer vertices than `points`."""
    if asked.simplify is None or asked.simplify >= asked.points:
        return []
    simplified = [
        field.removeprefix("body.")
        for field, shape in shapes.items()
        if shape.vertices > asked.simplify
    ]
    if not simplified:
        return []
    message = (
        f"{', '.join(simplified[:MOST_FIELDS])} would have {asked.simplify} vertices, fewer than"
        f" `points` ({asked.points}); simplify less, or take fewer points"
    )
    return [FieldProblem(field="body.simplify", message=message)]


def refuse(wrong: Sequence[FieldProblem], detail: str) -> None:
    """Raise problems of a request, if there are any.

    Raises
    ------
    InvalidRequest
        With the first `MOST_FIELDS` of the problems.
    """
    if not wrong:
        return
    if len(wrong) > MOST_FIELDS:
        detail += f" The first {MOST_FIELDS} of {len(wrong)} are named."
    raise InvalidRequest(detail, tuple(wrong[:MOST_FIELDS]))


def counted(count: int, noun: str, plural: str | None = None) -> str:
    """Return "1 face", "2 faces", "1,000 faces"."""
    return f"{count:,} {noun if count == 1 else plural or noun + 's'}"
