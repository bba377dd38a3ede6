"""Whether shapes have the colours that what is compared of them is made of."""

from collections.abc import Mapping

from broker.contracts import (
    DissimilarityParameters,
    FieldProblem,
    MatchParameters,
    PrototypeParameters,
    ShapeRecord,
)
from service.http import InvalidRequest


def check_colors(
    parameters: MatchParameters | DissimilarityParameters | PrototypeParameters,
    shapes: Mapping[str, ShapeRecord],
) -> None:
    """Refuse descriptors made of colours for shapes that have none.

    Parameters
    ----------
    parameters
        What is compared.
    shapes
        The shapes, by the fields that name them, such as ``body.source``.

    Raises
    ------
    InvalidRequest
        A shape has no vertex colours; the field is that of the descriptor.
    """
    without = [
        field.removeprefix("body.") for field, shape in shapes.items() if not shape.has_colors
    ]
    if not without or getattr(parameters, "first_order_weight", 1.0) == 0.0:
        return
    several = isinstance(parameters.descriptor, tuple)
    wrong = tuple(
        FieldProblem(
            field=f"body.descriptor.{place}" if several else "body.descriptor",
            message=f"{choice.name!r} needs vertex colours; there are none in {', '.join(without)}",
        )
        for place, choice in enumerate(parameters.descriptors)
        if choice.about.needs_colors
    )
    if wrong:
        raise InvalidRequest(
            "Choose another descriptor, or upload the shape in a format that has colours,"
            " such as PLY, GLB, or OBJ zipped with its materials.",
            wrong,
        )
