"""Whether shapes can be compared as a request asks: all that their records tell beforehand."""

from collections.abc import Mapping, Sequence

from broker.contracts import (
    DissimilarityParameters,
    FieldProblem,
    MatchParameters,
    PrototypeParameters,
    ShapeRecord,
)
from service.colors import check_colors
from service.http import MOST_FIELDS, InvalidRequest


def named(shapes: Sequence[str]) -> dict[str, str]:
    """Return ids of shapes by the fields that name them."""
    return {f"body.shapes.{place}": shape for place, shape in enumerate(shapes)}


def repeated(shapes: Sequence[str]) -> list[FieldProblem]:
    """Return which shapes are there already."""
    first: dict[str, int] = {}
    wrong = []
    for place, shape in enumerate(shapes):
        if shape in first:
            message = f"this shape is the same as shapes.{first[shape]}; give each once"
            wrong.append(FieldProblem(field=f"body.shapes.{place}", message=message))
        first.setdefault(shape, place)
    return wrong


def check_shapes(
    asked: MatchParameters | DissimilarityParameters | PrototypeParameters,
    shapes: Mapping[str, ShapeRecord],
    detail: str,
    further: Sequence[FieldProblem] = (),
) -> None:
    """Refuse shapes that cannot be compared with one another, or not so.

    Parameters
    ----------
    asked
        How they are to be compared.
    shapes
        By the fields that name them, such as ``body.source``.
    detail
        What is said of it all.
    further
        What else is wrong.

    Raises
    ------
    InvalidRequest
        A shape has no vertex colours and needs them, or several components, or would be simplified
        to fewer vertices than points are taken of it.
    """
    check_colors(asked, shapes)
    refuse(
        (*further, *several_components(asked, shapes), *simplified_too_far(asked, shapes)), detail
    )


def too_few_vertices(
    shapes: Mapping[str, ShapeRecord], points: int, what: str
) -> list[FieldProblem]:
    """Return which shapes have fewer vertices than points are taken of them.

    Parameters
    ----------
    shapes
        By the fields that name them.
    points
        How many.
    what
        What becomes of these: "are matched".
    """
    return [
        FieldProblem(field=field, message=f"it has {shape.vertices} vertices, and {points} {what}")
        for field, shape in shapes.items()
        if shape.vertices < points
    ]


def several_components(
    asked: MatchParameters | DissimilarityParameters | PrototypeParameters,
    shapes: Mapping[str, ShapeRecord],
) -> list[FieldProblem]:
    """Return which shapes have several components, of which not the largest is to be taken."""
    if asked.largest_component:
        return []
    advice = "ask for `largest_component`, or name another shape"
    if isinstance(asked, PrototypeParameters):
        advice = "upload one component of it, or leave it out"
    return [
        FieldProblem(
            field=field,
            message=f"it has {shape.components} components, with infinite distances between them;"
            f" {advice}",
        )
        for field, shape in shapes.items()
        if shape.components > 1
    ]


def simplified_too_far(
    asked: MatchParameters | DissimilarityParameters | PrototypeParameters,
    shapes: Mapping[str, ShapeRecord],
) -> list[FieldProblem]:
    """Return what is wrong with `simplify`, if it leaves fewer vertices than points are taken."""
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
        f"{', '.join(simplified[:MOST_FIELDS])} would have {asked.simplify} vertices, and `points`"
        f" asks for {asked.points} of them; simplify less, or take fewer points"
    )
    return [FieldProblem(field="body.simplify", message=message)]


def refuse(wrong: Sequence[FieldProblem], detail: str) -> None:
    """Refuse what is wrong with a collection, if anything is.

    Raises
    ------
    InvalidRequest
        With the first of the problems.
    """
    if not wrong:
        return
    if len(wrong) > MOST_FIELDS:
        detail += f" The first {MOST_FIELDS} of {len(wrong)} are named."
    raise InvalidRequest(detail, tuple(wrong[:MOST_FIELDS]))
