"""Shapes: uploaded meshes, named by the hash of their bytes."""

from datetime import datetime
from pathlib import PurePath
from typing import Annotated, BinaryIO, Final, Literal, TypeAlias

from pydantic import BaseModel, ConfigDict, Field
from typing_extensions import TypeAliasType

from broker.contracts.digests import sha256_of

MESH_FORMATS: Final = (
    "csv",
    "glb",
    "gltf",
    "las",
    "laz",
    "obj",
    "off",
    "ply",
    "stl",
    "txt",
    "xyz",
    "zip",
)
"""The formats that can be uploaded, which are those the solver reads; csv, txt and xyz are point
clouds, zip holds another."""

_Direction: TypeAlias = tuple[float, float, float]
# An alias by name, so that OpenAPI describes it once.
ViewAxes = TypeAliasType(
    "ViewAxes",
    Annotated[
        tuple[_Direction, _Direction, _Direction],
        Field(description="Directions to the right, up and towards the viewer: a rotation's rows."),
    ],
)

UPRIGHT: Final[ViewAxes] = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
"""The view of a file whose y axis is up and whose z axis is towards the viewer."""


def shape_id(data: bytes | BinaryIO) -> str:
    """Return the id of a file: the first 32 hexadecimal digits of its SHA-256."""
    return shape_id_of(sha256_of(data))


def shape_id_of(digest: str) -> str:
    """Return the id of the file that has this SHA-256."""
    return digest[:32]


def file_type_of(filename: str) -> str | None:
    """Return the mesh format of a file by its name; None if it is not supported."""
    suffix = PurePath(filename).suffix.removeprefix(".").lower()
    return suffix if suffix in MESH_FORMATS else None


class ShapeRecord(BaseModel):
    """An uploaded shape."""

    model_config = ConfigDict(
        frozen=True,
        json_schema_extra={
            "examples": [
                {
                    "id": "9b74c9897bac770ffc029102a200c5de",
                    "name": "cat0.off",
                    "file_type": "off",
                    "kind": "mesh",
                    "bytes": 402118,
                    "vertices": 5000,
                    "faces": 9996,
                    "file_vertices": 5000,
                    "file_faces": 9996,
                    "area": 13402.7,
                    "components": 1,
                    "closed": True,
                    "has_colors": False,
                    "view": [[1, 0, 0], [0, 0, 1], [0, -1, 0]],
                    "warnings": [],
                    "created": "2026-03-01T12:00:00Z",
                }
            ]
        },
    )

    id: str = Field(description="Content hash: the same bytes have the same id.")
    name: str = Field(description="The name given at upload, or the name of the file.")
    file_type: str = Field(description="Format of the file.")
    kind: Literal["mesh", "points"] = Field(
        default="mesh",
        description='"points" for a point cloud, which a surface was made of: its vertices are the'
        " points of the file, its triangles were computed.",
    )
    bytes: int = Field(description="Size of the uploaded file.")
    vertices: int = Field(description="Number of vertices, after repair.")
    faces: int = Field(description="Number of triangles, after repair.")
    file_vertices: int | None = Field(
        default=None,
        description="Number of vertices of the file, before repair: rows of attributes of"
        " vertices. Null for shapes of earlier versions.",
    )
    file_faces: int | None = Field(
        default=None,
        description="Number of faces of the file, polygons included: rows of attributes of faces."
        " Null for shapes of earlier versions.",
    )
    area: float = Field(description="Surface area, in the square of the file's unit of length.")
    components: int = Field(
        description="Number of connected components, those left out as debris aside. Several"
        " are linked where they are nearest, and matched as one surface."
    )
    closed: bool = Field(description="Whether the surface has no boundary.")
    has_colors: bool = Field(description="Whether the vertices have colours.")
    view: ViewAxes = Field(
        default=UPRIGHT,
        description="How the page and figures show it: upright, seen from its broad side. For"
        " shapes of earlier versions, y is up.",
    )
    warnings: tuple[str, ...] = Field(description="What was repaired, left out or linked.")
    created: datetime = Field(description="When it was uploaded.")
