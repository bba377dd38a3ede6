"""Surfaces as they are written, with rows in the order of the file they were read from."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.mesh import TriangleMesh
from solver.transfer.attributes import Attribute


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
        Of its vertices, W rows each.
    """

    name: str
    vertices: FloatArray
    faces: IntArray
    attributes: tuple[Attribute, ...]

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
            Rows in the order of the file; those of the last vertices may be missing.
        name
            Its name.
        """
        ids, own = mesh.numbering
        count = max([int(ids[-1]) + 1, *(len(one.values) for one in attributes)])
        vertices = np.repeat(mesh.vertices[:1], count, axis=0)
        vertices[ids] = mesh.vertices[own]
        filled = tuple(replace(one, values=_extended(one, count)) for one in attributes)
        return cls(name, vertices, mesh.vertex_ids[mesh.faces], filled)


def _extended(attribute: Attribute, count: int) -> np.ndarray:
    values = attribute.values
    missing = {"f": np.nan, "i": -1}.get(values.dtype.kind, "")
    found = np.full((count, *values.shape[1:]), missing, dtype=values.dtype)
    found[: len(values)] = values
    return found
