"""Transfers: attribute files, what is carried along a match, and the results."""

from datetime import datetime
from pathlib import PurePath
from typing import Annotated, BinaryIO, ClassVar, Final, Literal, TypeAlias

from pydantic import BaseModel, ConfigDict, Field, FiniteFloat

from broker.contracts.digests import sha256_of
from broker.contracts.result_document import ResultDocument
from broker.contracts.results import Confidence
from broker.contracts.strict import Items, StrictModel
from broker.contracts.vertices import Vertex

ATTRIBUTE_FORMATS: Final = ("npz", "csv", "ply", "obj", "glb", "seg", "txt")
"""The formats of attribute files, which are those the solver reads."""

_PREFIX: Final = "a-"
"""Beginning of the ids of attribute files, which distinguishes them from those of shapes."""

LANDMARKS: Final = "landmarks"
TEXTURE: Final = "texture"
UV: Final = "uv"

TransferKind: TypeAlias = Literal[
    "scalars", "vectors", "colors", "labels", "skinning", "landmarks", "texture", "uv"
]
Direction: TypeAlias = Literal["source_to_target", "target_to_source"]
AttributeElement: TypeAlias = Literal["vertices", "faces"]


def attributes_id(data: bytes | BinaryIO) -> str:
    """Return the id of an attribute file: its prefix, and 32 hexadecimal digits of a SHA-256."""
    return attributes_id_of(sha256_of(data))


def attributes_id_of(digest: str) -> str:
    """Return the id of the attribute file that has this SHA-256."""
    return _PREFIX + digest[:32]


def attribute_format_of(filename: str) -> str | None:
    """Return the format of an attribute file by its name; None if it is not supported."""
    suffix = PurePath(filename).suffix.removeprefix(".").lower()
    return suffix if suffix in ATTRIBUTE_FORMATS else None


class AttributeSummary(BaseModel):
    """An attribute of the vertices or of the faces of a file."""

    model_config = ConfigDict(frozen=True)

    name: str = Field(description="Its name.")
    type: Literal["number", "integer", "text"] = Field(description="Type of its values.")
    columns: tuple[str, ...] = Field(
        description="Names of its columns, such as those of joints; empty for one value in each"
        " row."
    )
    on: AttributeElement | None = Field(
        default=None,
        description="What its rows are of, if the file says so; null if their number decides.",
    )
    rows: int | None = Field(
        default=None,
        description="Number of its rows; null in documents of earlier versions.",
    )


class AttributesRecord(BaseModel):
    """An uploaded file of attributes of the vertices or of the faces of a shape."""

    model_config = ConfigDict(
        frozen=True,
        json_schema_extra={
            "examples": [
                {
                    "id": "a-1f0c2f0e3b9d4c0c8e6f1a2b3c4d5e6f",
                    "name": "segments.csv",
                    "file_type": "csv",
                    "bytes": 41873,
                    "rows": 5000,
                    "attributes": [
                        {"name": "part", "type": "text", "columns": [], "on": None, "rows": 5000}
                    ],
                    "created": "2026-03-01T12:00:00Z",
                }
            ]
        },
    )

    id: str = Field(description="Content hash: the same bytes have the same id.")
    name: str = Field(description="The name given at upload, or the name of the file.")
    file_type: str = Field(description="Format.")
    bytes: int = Field(description="Size of the file.")
    rows: int = Field(
        description="Number of rows: row i is vertex i, or face i, of the shape's file."
    )
    attributes: tuple[AttributeSummary, ...] = Field(description="What it has.")
    created: datetime = Field(description="When it was uploaded.")


Corners: TypeAlias = Annotated[tuple[Vertex, ...], Items(3, 3)]
"""The vertices of a triangle."""

Weights: TypeAlias = Annotated[tuple[Annotated[float, Field(ge=0, le=1)], ...], Items(3, 3)]
"""Barycentric coordinates."""


class SurfacePoint(BaseModel):
    """A point in a triangle of a surface."""

    model_config = ConfigDict(frozen=True, allow_inf_nan=False)

    vertices: Corners = Field(
        description="0-based indices, in the shape's file, of the triangle's corners."
    )
    weights: Weights = Field(description="Barycentric coordinates, none negative, of sum 1.")


class TransferredPoint(SurfacePoint):
    """Image of a landmark."""

    position: tuple[float, float, float] | None = Field(
        default=None,
        description="Where it is, in the coordinates of the shape's file; missing in results of"
        " earlier versions.",
    )


Coordinate: TypeAlias = Annotated[float, Field(ge=-3.4e38, le=3.4e38)]
"""A finite number that mesh files can hold."""


class GivenLandmark(StrictModel):
    """A landmark in space."""

    label: Annotated[str, Field(max_length=200)] | None = Field(
        default=None, description="Its name; null for none."
    )
    position: Annotated[tuple[Coordinate, ...], Items(3, 3)] | None = Field(
        description="Where it is, in the coordinates of the shape's file; null if it is missing."
    )


class TransferredLandmark(BaseModel):
    """A landmark, its image, and how far that can be trusted. Lengths are over √area."""

    model_config = ConfigDict(frozen=True, allow_inf_nan=False)

    label: str | None = Field(description="Its name; null for none.")
    on_source: TransferredPoint | None = Field(
        description="The point of the surface of `source` that it stands for; null if it is missing"
        " or was left out."
    )
    position: tuple[float, float, float] | None = Field(
        description="Where its image is, in the coordinates of the file of `target`; null if it has"
        " none."
    )
    vertices: Corners | None = Field(
        description="0-based indices, in the file of `target`, of the corners of the triangle that"
        " holds the image."
    )
    weights: Weights | None = Field(
        description="Barycentric coordinates of the image there, none negative, of sum 1."
    )
    confidence: float | None = Field(
        description="Probability that the image is within 0.05 of the right place; null if there"
        " is no image, no round trip, or no confidence of the match.",
    )
    round_trip: float | None = Field(
        description="Distance on `source` between the landmark and the image of its image; null if"
        " the image has no partner, as at the edge of a part."
    )
    distortion: float | None = Field(
        description="Deviation of the map from a rigid motion, within 0.1 of the landmark: root"
        " mean square distance after the best rotation, over 0.1; null if that is not known."
    )
    from_surface: float | None = Field(
        description="Distance of the given position from the surface of `source`; null if a point"
        " of the surface was given, or the landmark is missing or was left out."
    )


class TransferResult(ResultDocument):
    """Attributes or landmarks that were transferred from one shape of a match to the other."""

    ADDED: ClassVar = frozenset({"on", "confidence", "landmarks"})

    kind: Literal["transfer"] = Field(default="transfer", description="Kind of the job.")
    match: str = Field(description="Id of the job that matched the shapes.")
    source: str = Field(description="Id of the shape that values come from.")
    target: str = Field(description="Id of the shape that values were transferred to.")
    source_name: str | None = Field(description="Its name.")
    target_name: str | None = Field(description="Its name.")
    what: TransferKind = Field(description="Kind of the values.")
    direction: Direction = Field(description="Direction in the match.")
    on: Literal["vertices", "faces", "corners"] = Field(
        default="vertices",
        description="What of the file of `target` the rows are of; of texture coordinates, the"
        " corners of the triangles of its surface, three after three.",
    )
    rows: int = Field(
        description="Number of rows of the attributes: row i is vertex i, or face i, of the file of"
        " `target`, or a corner."
    )
    attributes: tuple[AttributeSummary, ...] = Field(
        description="What was transferred; the values are in the files of the job."
    )
    points: tuple[TransferredPoint | None, ...] | None = Field(
        description="Of landmarks, their images on `target`, in their order, null where one has no"
        " partner; null for other kinds."
    )
    landmarks: tuple[TransferredLandmark, ...] | None = Field(
        default=None,
        description="Landmarks, in the order in which they were given; null for other kinds, and in"
        " documents of earlier versions.",
    )
    confidence: Confidence | None = Field(
        default=None,
        description="Confidence of the match that they were transferred along; null if it is not"
        " known, as for point clouds, for the map of an alternative and in documents of earlier"
        " versions.",
    )
    warnings: tuple[str, ...] = Field(description="What should be known about this answer.")
    timings: dict[str, FiniteFloat] = Field(description='Seconds, "total".')
