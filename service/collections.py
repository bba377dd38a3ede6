"""What is wrong with the shapes of a collection, whatever is to be done with it."""

from collections.abc import Mapping, Sequence

from service.problems import InvalidRequest
from service.requests import MOST_FIELDS
from worker.contracts import FieldProblem, ShapeRecord


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


def too_few_vertices(
    shapes: Mapping[str, ShapeRecord], points: int, what: str = "`points` are matched"
) -> list[FieldProblem]:
    """Return which shapes have fewer vertices than points are taken of them."""
    return [
        FieldProblem(field=field, message=f"it has {shape.vertices} vertices, and {points} {what}")
        for field, shape in shapes.items()
        if shape.vertices < points
    ]


def several_components(shapes: Mapping[str, ShapeRecord], advice: str) -> list[FieldProblem]:
    """Return which shapes have several components, with advice on what to do about it."""
    return [
        FieldProblem(
            field=field,
            message=f"it has {shape.components} components, with infinite distances between them;"
            f" {advice}",
        )
        for field, shape in shapes.items()
        if shape.components > 1
    ]


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
