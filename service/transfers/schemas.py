"""Attribute files as the API shows them, and requests to carry attributes or landmarks."""

from typing import Annotated, Any

from pydantic import AfterValidator, BeforeValidator, ConfigDict, Field
from pydantic_core import PydanticCustomError

from broker.contracts import (
    LANDMARKS,
    TEXTURE,
    UV,
    AttributeElement,
    AttributesRecord,
    Direction,
    SurfacePoint,
    TransferKind,
    integral,
)
from service.jobs import JobRequest
from service.names import NamedId, showable

_MATCH = "5f0c2f0e3b9d4c0c8e6f1a2b3c4d5e6f"
_TOLERANCE = 1e-3
"""Greatest error of a sum of weights, as in the solver."""

_FILE = "a-1f0c2f0e3b9d4c0c8e6f1a2b3c4d5e6f"


class Attributes(AttributesRecord):
    """An uploaded file of attributes of the vertices or of the faces of a shape."""


def _point_at_vertex(given: Any) -> Any:
    """A vertex is the point with all of the weight at one corner."""
    given = integral(given)
    if isinstance(given, int) and not isinstance(given, bool):
        return {"vertices": [given] * 3, "weights": [1.0, 0.0, 0.0]}
    return given


def _whole_point(point: SurfacePoint) -> SurfacePoint:
    if abs(sum(point.weights) - 1.0) > _TOLERANCE:
        raise PydanticCustomError("weights", "The sum of `weights` should be 1")
    return point


Point = Annotated[
    SurfacePoint,
    BeforeValidator(_point_at_vertex, json_schema_input_type=int | SurfacePoint),
    AfterValidator(_whole_point),
]
AttributeName = Annotated[str, Field(min_length=1, max_length=100), AfterValidator(showable)]


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
    names: tuple[AttributeName, ...] = Field(
        default=(),
        max_length=1024,
        strict=False,
        fail_fast=True,
        description="Attributes to transfer; of skinning, joints: their weights are divided by"
        " their sum. None for all of the kind.",
    )
    influences: Annotated[int, Field(ge=1, le=1024)] | None = Field(
        default=None,
        description="Of skinning weights, how many joints each vertex keeps, those of greatest"
        " weight; null for all. Some programs read no more than four from GLB files.",
    )
    points: tuple[Point, ...] = Field(
        default=(),
        max_length=10_000,
        strict=False,
        fail_fast=True,
        description="The landmarks, vertices or points in triangles of the shape that they come"
        ' from; only with `what` "landmarks".',
    )

    @property
    def contradictions(self) -> dict[str, str]:
        """What is wrong with fields given the others, by field."""
        wrong: dict[str, str] = {}
        landmarks = self.what == LANDMARKS
        if landmarks and not self.points:
            wrong["points"] = '`what` is "landmarks"; give the landmarks'
        if not landmarks and self.points:
            wrong["points"] = 'only "landmarks" have points; leave them out, or change `what`'
        for name in ("attributes", "names", "on"):
            if self.what in (LANDMARKS, TEXTURE, UV) and getattr(self, name):
                wrong[name] = f"not supported with {self.what!r}; leave it out, or change `what`"
        if self.influences is not None and self.what != "skinning":
            wrong["influences"] = "only skinning weights have influences; leave it out"
        twice = next((one for one in self.names if self.names.count(one) > 1), None)
        if twice is not None:
            wrong["names"] = f"{twice[:40]!r} is there twice; give each name once"
        if self.on == "faces" and self.what == "skinning":
            wrong["on"] = "skinning weights are of vertices; leave it out"
        return wrong
