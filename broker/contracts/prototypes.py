"""Prototypes of classes of shapes: their identity, their records, and results of learning."""

from datetime import datetime
from typing import BinaryIO, Final, Literal

from pydantic import BaseModel, ConfigDict, Field, FiniteFloat

from broker.contracts.digests import sha256_of
from broker.contracts.parameters import PrototypeParameters, PrototypeStructures
from broker.contracts.result_document import ResultDocument
from broker.contracts.shapes import UPRIGHT, ViewAxes

MOST_EXAMPLES: Final = 256
"""Greatest number of shapes a prototype is learned from."""

PROTOTYPE_PREFIX: Final = "p-"
"""Beginning of the ids of prototypes, which distinguishes them from those of shapes."""

ARCHIVE_TYPE: Final = "npz"


def prototype_id(archive: bytes | BinaryIO) -> str:
    """Return the id of a prototype: its prefix, and 32 hexadecimal digits of a SHA-256."""
    return prototype_id_of(sha256_of(archive))


def prototype_id_of(digest: str) -> str:
    """Return the id of the prototype whose archive has this SHA-256."""
    return PROTOTYPE_PREFIX + digest[:32]


def is_prototype(source: str) -> bool:
    """Return whether an id is that of a prototype."""
    return source.startswith(PROTOTYPE_PREFIX)


class ExampleReport(BaseModel):
    """Use of one of the given examples: learned from, or left out with the reason."""

    model_config = ConfigDict(frozen=True, allow_inf_nan=False)

    shape: str = Field(description="Id of the shape.")
    used: bool = Field(description="Whether the prototype was learned from it.")
    misfit: float = Field(
        description="Energy of its match with a preliminary prototype; 0 where nothing had to be"
        " matched."
    )
    reason: str | None = Field(description="Why it was not used; null if it was.")


class PrototypeRecord(BaseModel):
    """A prototype: distributions of the structures of a class of shapes, section 5."""

    model_config = ConfigDict(
        frozen=True,
        json_schema_extra={
            "examples": [
                {
                    "id": "p-1f0c2f0e3b9d4c0c8e6f1a2b3c4d5e6f",
                    "name": "human",
                    "version": 2,
                    "bytes": 12874,
                    "points": 32,
                    "components": 5,
                    "examples": 64,
                    "parameters": {
                        "metric": [{"name": "geodesic"}],
                        "descriptor": [{"name": "si_hks", "frequencies": 6}],
                        "sampling": [{"name": "commute_time"}, {"name": "geodesic"}],
                        "eigenpairs": 100,
                        "geodesic_method": "fast_marching",
                        "normalise": True,
                    },
                    "surfaces": 24,
                    "learned_from": None,
                    "reference": None,
                    "view": [[1, 0, 0], [0, 1, 0], [0, 0, 1]],
                    "warnings": [],
                    "created": "2026-03-01T12:00:00Z",
                }
            ]
        },
    )

    id: str = Field(description="Content hash of the archive: the same bytes have the same id.")
    name: str = Field(description="The name it was learned or uploaded under.")
    version: int = Field(
        ge=1, description="Which prototype of this name it is, counted from 1; it never changes."
    )
    bytes: int = Field(description="Size of the archive.")
    points: int = Field(description="Number N of its points.")
    components: int = Field(description="Gaussians of a mixture, at most.")
    examples: int = Field(description="Number M of the shapes it was learned from.")
    parameters: PrototypeStructures = Field(
        description="What is measured of shapes that are compared with it."
    )
    surfaces: int = Field(
        default=0,
        description="Surfaces of examples that it keeps, by which left is told from right; 0 for an"
        " archive that has none.",
    )
    learned_from: tuple[ExampleReport, ...] | None = Field(
        description="What became of each shape it was to be learned from; null if it was uploaded."
    )
    reference: str | None = Field(
        description="Id of the shape its points were chosen on; null if it was uploaded."
    )
    view: ViewAxes = Field(
        default=UPRIGHT,
        description="How the page and figures show its points: as its first surface stands. Without"
        " surfaces, and for prototypes of earlier versions, y is up.",
    )
    warnings: tuple[str, ...] = Field(description="What should be known of it.")
    created: datetime = Field(description="When it was learned or uploaded.")


class PrototypeSurface(BaseModel):
    """The simplified surface of an example of a prototype, and the prototype's points on it."""

    model_config = ConfigDict(frozen=True, allow_inf_nan=False)

    positions: tuple[tuple[float, float, float], ...] = Field(
        description="Positions of the vertices relative to the middle of the surface, scaled so"
        " that its largest extent is from -1 to 1."
    )
    faces: tuple[tuple[int, int, int], ...] = Field(
        description="Corners of the triangles, as indices of positions."
    )
    points: tuple[int, ...] = Field(
        description="Index of the position at or nearest to each point of the prototype."
    )


class PrototypeGeometry(BaseModel):
    """Positions of the points of a prototype, for drawing."""

    model_config = ConfigDict(
        frozen=True,
        json_schema_extra={
            "examples": [
                {
                    "vertices": [17, 204, 31],
                    "surface": {
                        "positions": [[-1, 0, 0], [0, 1, 0], [1, 0, 0]],
                        "faces": [[0, 1, 2]],
                        "points": [0, 1, 2],
                    },
                }
            ]
        },
    )

    vertices: tuple[int, ...] = Field(
        description="0-based vertex index of each point in the file of the reference shape."
    )
    surface: PrototypeSurface | None = Field(
        description="A surface to draw the points on; null for a prototype that keeps none."
    )


class PrototypeResult(ResultDocument):
    """Result of learning a prototype."""

    kind: Literal["prototype"] = Field(default="prototype", description="Kind of the job.")
    prototype: PrototypeRecord
    parameters: PrototypeParameters = Field(description="The parameters in force.")
    warnings: tuple[str, ...] = Field(description="What should be known about this answer.")
    timings: dict[str, FiniteFloat] = Field(description='Seconds by stage, and "total".')
