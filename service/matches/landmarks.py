"""Check of landmarks against the numbers of vertices of the two files."""

from collections.abc import Mapping

from broker.contracts import FieldProblem, MatchParameters, ShapeRecord
from service.shapes import vertices_out_of_range


def landmarks_out_of_range(
    asked: MatchParameters, shapes: Mapping[str, ShapeRecord]
) -> list[FieldProblem]:
    """Return the problems of landmarks that no vertex of the files has as its number.

    Parameters
    ----------
    asked
        Parameters of the match.
    shapes
        The source as ``body.source``, and one or several targets.
    """
    wrong: list[FieldProblem] = []
    for field, shape in shapes.items():
        end = 0 if field == "body.source" else 1
        numbers = (
            (f"body.landmarks.{place}.{end}", pair[end])
            for place, pair in enumerate(asked.landmarks)
        )
        wrong += vertices_out_of_range(numbers, shape, field.removeprefix("body."))
    return wrong
