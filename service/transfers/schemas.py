"""Attribute files as the API shows them, and requests to carry attributes or landmarks."""

from collections.abc import Iterator
from typing import Annotated, Any, Final

from pydantic import AfterValidator, ConfigDict, Discriminator, Field, Tag, field_validator
from pydantic_core import PydanticCustomError

from broker.contracts import (
    LANDMARKS,
    TEXTURE,
    UV,
    AttributeElement,
    AttributesRecord,
    Direction,
    GivenLandmark,
    Items,
    SurfacePoint,
    TransferKind,
    Vertex,
)
from service.jobs import JobRequest
from service.names import NamedId, showable

_MATCH = "5f0c2f0e3b9d4c0c8e6f1a2b3c4d5e6f"
_TOLERANCE = 1e-3
"""Greatest error of a sum of weights, as in the solver."""

_FILE = "a-1f0c2f0e3b9d4c0c8e6f1a2b3c4d5e6f"


class Attributes(AttributesRecord):
    """An uploaded file of attributes of the vertices or of the faces of a shape."""


def _whole_point(point: SurfacePoint) -> SurfacePoint:
    if abs(sum(point.weights) - 1.0) > _TOLERANCE:
        raise PydanticCustomError("weights", "The sum of `weights` should be 1")
    return point


def _form_of_point(given: Any) -> str | None:
    if isinstance(given, dict | SurfacePoint):
        return SURFACE_POINT
    return VERTEX if isinstance(given, int) and not isinstance(given, bool) else None


# Tags look like the names Pydantic gives to branches, which are no part of a field's address.
VERTEX: Final = "choice[vertex]"
SURFACE_POINT: Final = "choice[point]"
Point = Annotated[
    Annotated[Vertex, Tag(VERTEX)]
    | Annotated[SurfacePoint, AfterValidator(_whole_point), Tag(SURFACE_POINT)],
    Discriminator(
        _form_of_point,
        custom_error_type="point_type",
        custom_error_message="Input should be the number of a vertex, or an object with `vertices`"
        " and `weights`, a point in a triangle",
    ),
]
AttributeName = Annotated[str, Field(min_length=1, max_length=100), AfterValidator(showable)]


class Landmark(GivenLandmark):
    """A landmark in space."""

    @field_validator("label")
    @classmethod
    def _one_line(cls, label: str | None) -> str | None:
        return label if label is None else showable(label)


class TransferRequest(JobRequest):
    """What is transferred along a match, and in which direction."""

    model_config = ConfigDict(
        strict=True,
        extra="forbid",
        json_schema_extra={
            "examples": [
                {"match": _MATCH, "attributes": _FILE, "what": "labels"},
                {"match": _MATCH, "what": "colors", "direction": "target_to_source"},
                {"match": _MATCH, "attributes": _FILE, "what": "labels", "on": "faces"},
                {
                    "match": _MATCH,
                    "attributes": _FILE,
                    "what": "skinning",
                    "names": ["Hips", "LeftLeg"],
                    "influences": 4,
                },
                {
                    "match": _MATCH,
                    "what": "landmarks",
                    "points": [17, {"vertices": [4, 9, 7], "weights": [0.25, 0.5, 0.25]}],
                },
                {
                    "match": _MATCH,
                    "what": "landmarks",
                    "landmarks": [
                        {"label": "nasion", "position": [12.5, 83.1, 140.2]},
                        {"label": "bregma", "position": [10.1, 97.4, 188.0]},
                    ],
                },
            ]
        },
    )

    match: NamedId = Field(description="Id of the job of a match with `dense`.")
    what: TransferKind = Field(
        description="Kind of the values: scalars, vectors and colours by barycentric means"
        " (components of vectors one by one: directions are not rotated), labels by majority,"
        " skinning weights by means of sum 1; landmarks, which are points; the texture in the"
        " shape's own file, as colours of vertices, and in GLB files as an image; or, as uv, its"
        " texture coordinates, whose images are in GLB files."
    )
    direction: Direction = Field(
        default="source_to_target",
        description="From the source of the match to its target, or from its target to its source.",
    )
    attributes: NamedId | None = Field(
        default=None,
        description="Id of a file of attributes of the shape that values come from; null for"
        " the attributes in the file of that shape itself, whose colours include its texture.",
    )
    on: AttributeElement | None = Field(
        default=None,
        description="Whether vertices or faces of the other shape take the values; null for what"
        " the values are of. A face takes the label of most of its area, or the mean over it, and"
        " so does the area round a vertex where values are of faces.",
    )
    names: Annotated[tuple[AttributeName, ...], Items(0, 1024)] = Field(
        default=(),
        description="Attributes to transfer; of skinning, joints: their weights are divided by"
        " their sum. None for all of the kind.",
    )
    influences: Annotated[int, Field(ge=1, le=1024)] | None = Field(
        default=None,
        description="Of skinning weights, how many joints each vertex keeps, those of greatest"
        " weight; null for all. Some programs read no more than four from GLB files.",
    )
    points: Annotated[tuple[Point, ...], Items(0, 10_000, fail_fast=True)] = Field(
        default=(),
        description="The landmarks, vertices or points in triangles of the shape that they come"
        ' from; only with `what` "landmarks".',
    )
    landmarks: Annotated[tuple[Landmark, ...], Items(0, 10_000, fail_fast=True)] = Field(
        default=(),
        description="The landmarks by their positions, instead of `points`. Each stands for the"
        " nearest point of the surface of the shape that they come from; those farther than"
        " 0.05 √area from it are left out, with a warning. If all are, or if x and y have the wrong"
        " sign (LPS for RAS), the job fails.",
    )

    @property
    def surface_points(self) -> tuple[SurfacePoint, ...]:
        """The landmarks; one at a vertex has all of the weight at one corner."""
        return tuple(
            SurfacePoint(vertices=(point,) * 3, weights=(1.0, 0.0, 0.0))
            if isinstance(point, int)
            else point
            for point in self.points
        )

    def contradictions(self) -> Iterator[tuple[str, str]]:
        """What is wrong with fields given the others: their names, and messages."""
        landmarks = self.what == LANDMARKS
        if landmarks and not self.points and not self.landmarks:
            yield "points", '`what` is "landmarks"; give the landmarks'
        if not landmarks and self.points:
            yield "points", 'only "landmarks" have points; leave them out, or change `what`'
        if not landmarks and self.landmarks:
            yield "landmarks", 'leave them out, or change `what` to "landmarks"'
        if self.points and self.landmarks:
            yield "landmarks", "give `landmarks` or `points`, not both"
        if self.landmarks and all(one.position is None for one in self.landmarks):
            yield "landmarks", "all are missing; give a position"
        for name in ("attributes", "names", "on"):
            if self.what in (LANDMARKS, TEXTURE, UV) and getattr(self, name):
                yield name, f"not supported with {self.what!r}; leave it out, or change `what`"
        if self.influences is not None and self.what != "skinning":
            yield "influences", "only skinning weights have influences; leave it out"
        twice = next((one for one in self.names if self.names.count(one) > 1), None)
        if twice is not None:
            yield "names", f"{twice[:40]!r} is there twice; give each name once"
        if self.on == "faces" and self.what == "skinning":
            yield "on", "skinning weights are of vertices; leave it out"
