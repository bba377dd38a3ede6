"""Uploaded shapes."""

from datetime import datetime
from typing import Literal

from pydantic import FiniteFloat

from isomatch._models.answer import Answer


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
    warnings
        What was repaired, left out or linked.
    created
        Time of the upload.
    """

    id: str
    name: str
    file_type: str
    kind: Literal["mesh", "points"] = "mesh"
    bytes: int
    vertices: int
    faces: int
    file_vertices: int | None = None
    file_faces: int | None = None
    area: FiniteFloat
    components: int
    closed: bool
    has_colors: bool
    warnings: tuple[str, ...]
    created: datetime
