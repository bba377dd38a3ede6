"""Uploaded shapes."""

from datetime import datetime
from typing import Annotated, Final, Literal, TypeAlias

from pydantic import FiniteFloat

from isomatch._models.answer import Answer
from isomatch._models.arguments import READ_AS_TEXT

_Direction: TypeAlias = tuple[FiniteFloat, FiniteFloat, FiniteFloat]
ViewAxes: TypeAlias = tuple[_Direction, _Direction, _Direction]

UPRIGHT: Final[ViewAxes] = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
"""The view with y up and z towards the viewer."""


class Shape(Answer):
    """An uploaded shape.

    Attributes
    ----------
    id
        Content hash: the same bytes have the same id.
    name
        The name given at upload, or the name of the file.
    file_type
        Format of the file, such as ``"off"``.
    bytes
        Size of the uploaded file.
    kind
        ``"mesh"``, or ``"points"`` for a point cloud, which a surface was made of: its vertices are
        the points of the file.
    vertices, faces
        Numbers of vertices and faces, after repair.
    file_vertices, file_faces
        Numbers of vertices and of faces of the file, before repair, where a polygon is one face:
        rows of attributes. None for shapes of earlier versions.
    area
        Surface area, in the square of the file's unit of length.
    components
        Number of connected components, those left out as debris aside. Several are linked where
        they are nearest, and matched as one surface.
    closed
        Whether the surface has no boundary.
    has_colors
        Whether the vertices have colours.
    view
        Directions to the right, up and towards the viewer in figures, rows of a rotation: upright,
        seen from the broad side. For shapes of earlier versions, y is up.
    warnings
        What was repaired, left out or linked.
    created
        Time of the upload.
    """

    id: str
    name: str
    file_type: str
    kind: Annotated[Literal["mesh", "points"], READ_AS_TEXT] = "mesh"
    bytes: int
    vertices: int
    faces: int
    file_vertices: int | None = None
    file_faces: int | None = None
    area: FiniteFloat
    components: int
    closed: bool
    has_colors: bool
    view: ViewAxes = UPRIGHT
    warnings: tuple[str, ...]
    created: datetime

    def __repr__(self) -> str:
        size = f"{self.vertices} vertices, {self.faces} faces"
        return f"<Shape {self.id} {self.name!r} of {size}>"

    __str__ = __repr__
