"""Attributes of the vertices and faces of shapes, and points between vertices."""

from datetime import datetime
from typing import Annotated

from pydantic import Field, FiniteFloat

from isomatch._models.answer import Answer


class AttributeSummary(Answer):
    """An attribute of the vertices or of the faces of a file.

    Attributes
    ----------
    name
        Its name.
    type
        Type of its values: ``"number"``, ``"integer"`` or ``"text"``.
    columns
        Names of its columns, such as those of joints; empty for one value in each row.
    on
        ``"vertices"`` or ``"faces"``, if the file says what its rows are of; None if their number
        decides.
    rows
        Number of its rows; None in documents of earlier versions.
    """

    name: str
    type: str
    columns: tuple[str, ...]
    on: str | None = None
    rows: int | None = None


class Attributes(Answer):
    """An uploaded file of attributes of the vertices or of the faces of a shape.

    Attributes
    ----------
    id
        Content hash: the same bytes have the same id.
    name
        The name given at upload, or the name of the file.
    file_type
        Format, such as ``"csv"``.
    bytes
        Size of the uploaded file.
    rows
        Number of rows; row i is vertex i, or face i, of the shape's file.
    attributes
        What it has.
    created
        Time of the upload.
    """

    id: str
    name: str
    file_type: str
    bytes: int
    rows: int
    attributes: tuple[AttributeSummary, ...]
    created: datetime


class SurfacePoint(Answer):
    """A point in a triangle of a shape.

    Attributes
    ----------
    vertices
        Vertex indices of the triangle's corners in the shape's file.
    weights
        Barycentric coordinates, of sum 1.
    position
        Where it is, in the coordinates of the shape's file; None in results of earlier versions,
        and of a point that was given.
    """

    vertices: Annotated[tuple[int, ...], Field(min_length=3, max_length=3)]
    weights: Annotated[tuple[FiniteFloat, ...], Field(min_length=3, max_length=3)]
    position: tuple[FiniteFloat, FiniteFloat, FiniteFloat] | None = None


class TransferredLandmark(Answer):
    """A landmark carried to another shape. Lengths are over the square root of the area.

    Attributes
    ----------
    label
        Its name; None for none.
    on_source
        Point of the surface that it stands for; None if it is missing, or was left out as it is
        farther than 0.05 from the surface.
    position
        Where its image is, in the coordinates of the other shape's file; None if it has none.
    vertices, weights
        The image as a point in a triangle, see :class:`SurfacePoint`.
    confidence
        Probability that the image is within 0.05 of the right place; None if it is not known.
    round_trip
        Distance of the landmark from the image of its image; None if the image has no partner.
    distortion
        Deviation of the map from a rigid motion within 0.1 of the landmark.
    from_surface
        Distance of the given position from the surface; None of a point of the surface.
    """

    label: str | None
    on_source: SurfacePoint | None
    position: tuple[FiniteFloat, FiniteFloat, FiniteFloat] | None
    vertices: Annotated[tuple[int, ...], Field(min_length=3, max_length=3)] | None
    weights: Annotated[tuple[FiniteFloat, ...], Field(min_length=3, max_length=3)] | None
    confidence: FiniteFloat | None
    round_trip: FiniteFloat | None
    distortion: FiniteFloat | None
    from_surface: FiniteFloat | None
