"""The surface of a shape: vertices, triangles, and the vertex numbers of the file."""

import struct
from dataclasses import dataclass, field
from itertools import pairwise
from typing import TYPE_CHECKING, Final

import numpy as np
import numpy.typing as npt

from isomatch._figures import Panel, draw_panels

if TYPE_CHECKING:
    from plotly.graph_objects import Figure

MAGIC: Final = b"isogeom1"
_HEADER: Final = "<8s4I4d"


@dataclass(frozen=True, eq=False)
class Geometry:
    """Surface of an uploaded shape, after repair.

    Attributes
    ----------
    vertices
        Positions, (V, 3) float64, to the precision of float32 relative to the shape's size.
    faces
        Rows of `vertices`, (F, 3) int64.
    vertex_ids
        0-based index of each vertex in the uploaded file, (V,) int64.
    colors
        Red, green and blue of each vertex, (V, 3) uint8; None without colours.
    view
        Directions to the right, up and towards the viewer in figures, (3, 3): those of the shape.
    is_cloud
        Whether the shape is a point cloud, whose faces were made of its points.
    """

    vertices: npt.NDArray[np.float64]
    faces: npt.NDArray[np.int64]
    vertex_ids: npt.NDArray[np.int64]
    colors: npt.NDArray[np.uint8] | None
    view: npt.NDArray[np.float64] = field(default_factory=lambda: np.eye(3))
    is_cloud: bool = False

    @classmethod
    def from_bytes(cls, data: bytes) -> "Geometry":
        """Read an answer of ``GET /v1/shapes/{id}/geometry``.

        Raises
        ------
        ValueError
            The data are something else, or are truncated.
        """
        size = struct.calcsize(_HEADER)
        if len(data) < size or not data.startswith(MAGIC):
            raise ValueError("not the geometry of a shape")
        _, n_vertices, n_faces, colored, cloud, *box = struct.unpack(_HEADER, data[:size])
        *origin, scale = box
        lengths = [12 * n_vertices, 12 * n_faces, 4 * n_vertices, 3 * n_vertices * colored]
        if len(data) != size + sum(lengths):
            raise ValueError("the geometry of the shape is truncated")
        ends = size + np.cumsum([0, *lengths])
        parts = [data[start:end] for start, end in pairwise(ends)]
        places = np.frombuffer(parts[0], "<f4").reshape(-1, 3).astype(np.float64)
        return cls(
            vertices=np.asarray(origin) + scale * places,
            faces=np.frombuffer(parts[1], "<u4").reshape(-1, 3).astype(np.int64),
            vertex_ids=np.frombuffer(parts[2], "<u4").astype(np.int64),
            colors=np.frombuffer(parts[3], "u1").reshape(-1, 3) if colored else None,
            is_cloud=cloud == 1,
        )

    def __repr__(self) -> str:
        if self.is_cloud:
            return f"<Geometry of a cloud of {len(self.vertices)} points>"
        return f"<Geometry of {len(self.vertices)} vertices and {len(self.faces)} triangles>"

    def positions(self, numbers: npt.ArrayLike) -> npt.NDArray[np.float64]:
        """Return the positions of vertices of the file.

        Parameters
        ----------
        numbers
            0-based vertex indices in the file, of any shape.

        Returns
        -------
        Positions, of the same shape with a last axis of 3.

        Raises
        ------
        ValueError
            The surface has no such vertex.
        """
        found: npt.NDArray[np.float64] = self.vertices[self.rows(numbers)]
        return found

    def rows(self, numbers: npt.ArrayLike) -> npt.NDArray[np.int64]:
        """Return the rows of `vertices` that hold vertices of the file.

        Parameters
        ----------
        numbers
            0-based vertex indices in the file, of any shape.

        Returns
        -------
        int64, of the same shape.

        Raises
        ------
        ValueError
            The surface has no such vertex.
        """
        wanted = np.asarray(numbers, dtype=np.int64)
        order = np.argsort(self.vertex_ids, kind="stable")
        places = np.searchsorted(self.vertex_ids, wanted, sorter=order)
        rows: npt.NDArray[np.int64] = order[np.minimum(places, len(order) - 1)]
        unknown = wanted[self.vertex_ids[rows] != wanted]
        if unknown.size:
            raise ValueError(f"the shape has no vertex {unknown.flat[0]}")
        return rows

    def plot(self, title: str = "") -> "Figure":
        """Draw the surface, or the points of a cloud, with plotly, in its own colours if any.

        Parameters
        ----------
        title
            Text above.

        Raises
        ------
        MissingExtra
            plotly is not installed.
        """
        # White points would not be seen on white paper.
        colors = None if self.is_cloud else np.ones_like(self.vertices)
        if self.colors is not None:
            colors = self.colors / 255.0
        panel = Panel(
            self.vertices, faces=self.faces, colors=colors, view=self.view, is_cloud=self.is_cloud
        )
        return draw_panels([panel], title)
