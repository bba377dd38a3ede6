"""Surfaces as they are written, with rows in the order of the file they were read from."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.mesh import TriangleMesh
from solver.mesh.textures import Paint
from solver.transfer.attributes import Attribute
from solver.transfer.overlap import FACES, file_faces


@dataclass(frozen=True, eq=False)
class WrittenSurface:
    """A surface with attributes.

    Parameters
    ----------
    name
        Its name.
    vertices, faces
        (W, 3) positions and (F, 3) triangles.
    attributes
        Of its vertices, W rows each, or of its faces, F rows each.
    paint
        Texture coordinates, textures and materials of its faces; ``None`` without.
    """

    name: str
    vertices: FloatArray
    faces: IntArray
    attributes: tuple[Attribute, ...]
    paint: Paint | None = None

    @classmethod
    def of(
        cls, mesh: TriangleMesh, attributes: Sequence[Attribute], name: str = "surface"
    ) -> "WrittenSurface":
        """Return a mesh whose vertex i is vertex i of the user's file.

        Parameters
        ----------
        mesh
            The mesh. Vertices of the file that no face uses are put where its first vertex is.
        attributes
            Rows in the order of the file; those of the last vertices may be missing. Triangles have
            the values of the faces that they were cut from.
        name
            Its name.
        """
        ids, own = mesh.numbering
        count = mesh.vertex_rows
        vertices = np.repeat(mesh.vertices[:1], count, axis=0)
        vertices[ids] = mesh.vertices[own]
        filled = tuple(
            _of_triangles(one, mesh) if one.on == FACES else _extended(one, count)
            for one in attributes
        )
        return cls(name, vertices, mesh.vertex_ids[mesh.faces], filled)

    def cut(self) -> tuple["WrittenSurface", IntArray]:
        """Repeat vertices where they have several values.

        With attributes of faces each triangle has vertices of its own, which have its values. With
        texture coordinates vertices on seams are repeated.

        Returns
        -------
        The surface, and (W,) the corner that each of its vertices is, of the 3 F of all triangles.
        """
        corners = self.faces.ravel()
        first = inverse = np.arange(len(corners))
        if self.paint is not None and all(one.on != FACES for one in self.attributes):
            table = np.column_stack([corners, self.paint.coordinates.reshape(-1, 2)])
            _, first, inverse = np.unique(table, axis=0, return_index=True, return_inverse=True)
        attributes = tuple(
            replace(
                one,
                values=one.values[first // 3] if one.on == FACES else one.values[corners[first]],
                on=None,
            )
            for one in self.attributes
        )
        faces = inverse.reshape(-1, 3)
        return replace(
            self, vertices=self.vertices[corners[first]], faces=faces, attributes=attributes
        ), first


def _of_triangles(attribute: Attribute, mesh: TriangleMesh) -> Attribute:
    return replace(attribute, values=attribute.values[file_faces(mesh)])


def _extended(attribute: Attribute, count: int) -> Attribute:
    values = attribute.values
    missing = {"f": np.nan, "i": -1}.get(values.dtype.kind, "")
    found = np.full((count, *values.shape[1:]), missing, dtype=values.dtype)
    found[: len(values)] = values
    return replace(attribute, values=found)
