"""Check of landmarks against the numbers of vertices of the two files."""

from collections.abc import Mapping

from broker.contracts import FieldProblem, MatchParameters, ShapeRecord


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
    wrong = []
    for field, shape in shapes.items():
        count, end = shape.file_vertices, 0 if field == "body.source" else 1
        if count is None:
            continue
        wrong += [
            FieldProblem(
                field=f"body.landmarks.{place}.{end}",
                message=f"{pair[end]} is no vertex of {field.removeprefix('body.')}, whose file has"
                f" vertices 0 to {count - 1}",
            )
            for place, pair in enumerate(asked.landmarks)
            if pair[end] >= count
        ]
    return wrong
