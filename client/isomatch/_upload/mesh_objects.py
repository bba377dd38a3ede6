"""Objects of other packages with the arrays of a mesh or of a point cloud."""

import warnings
from typing import Protocol, TypeAlias, runtime_checkable

import numpy as np
import numpy.typing as npt

from isomatch._http import UploadFile
from isomatch._upload.ply import binary_ply, points_ply


@runtime_checkable
class MeshLike(Protocol):
    """Anything with arrays of vertices and faces, such as a ``trimesh.Trimesh``."""

    @property
    def vertices(self) -> npt.ArrayLike:
        """Positions, shape (V, 3)."""

    @property
    def faces(self) -> npt.ArrayLike:
        """Vertex indices of the triangles, shape (F, 3)."""


@runtime_checkable
class TrianglesLike(Protocol):
    """Anything with arrays of vertices and triangles, such as a mesh of open3d."""

    @property
    def vertices(self) -> npt.ArrayLike:
        """Positions, shape (V, 3)."""

    @property
    def triangles(self) -> npt.ArrayLike:
        """Vertex indices of the triangles, shape (F, 3)."""


@runtime_checkable
class CloudLike(Protocol):
    """Points with their colours, such as a ``trimesh.PointCloud``."""

    @property
    def vertices(self) -> npt.ArrayLike:
        """Positions, shape (V, 3)."""

    @property
    def colors(self) -> npt.ArrayLike | None:
        """RGB or RGBA of each point; empty or None without colours."""


MeshObject: TypeAlias = MeshLike | TrianglesLike | CloudLike
"""An object with vertices and faces, with vertices and triangles, or with points alone."""


def object_file(source: MeshObject) -> UploadFile:
    """Return the arrays of an object as a mesh file.

    Raises
    ------
    ValueError
        An array is invalid.
    """
    colors = _colors(source)
    # Of a geometry of this package that is a cloud, the service made the faces.
    if getattr(source, "is_cloud", False):
        return UploadFile("points.ply", points_ply(source.vertices, colors))
    if isinstance(source, MeshLike):
        return UploadFile("mesh.ply", binary_ply(source.vertices, source.faces, colors))
    if isinstance(source, TrianglesLike):
        return UploadFile("mesh.ply", binary_ply(source.vertices, source.triangles, colors))
    return UploadFile("points.ply", points_ply(source.vertices, colors))


def is_scene(source: object) -> bool:
    """Return whether an object is a ``trimesh.Scene``, whose meshes have to be joined first."""
    return hasattr(source, "geometry") and hasattr(source, "to_mesh")


def _colors(source: MeshObject) -> npt.ArrayLike | None:
    visual = getattr(source, "visual", None)
    if visual is None:
        # A geometry of this package, and a mesh of open3d, whose array is empty without colours.
        return _given(getattr(source, "colors", getattr(source, "vertex_colors", None)))
    # trimesh: only visuals of the kind "vertex" have a colour for each vertex.
    kind = getattr(visual, "kind", None)
    if kind == "face":
        warnings.warn(
            "colours of faces are not uploaded; for their means at vertices, upload the tuple"
            " (mesh.vertices, mesh.faces, mesh.visual.vertex_colors)",
            stacklevel=2,
        )
    return _given(getattr(visual, "vertex_colors", None)) if kind == "vertex" else None


def _given(colors: npt.ArrayLike | None) -> npt.ArrayLike | None:
    return None if colors is None or not np.size(colors) else colors
