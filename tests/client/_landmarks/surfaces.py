"""Surfaces and maps between them for tests of landmarks."""

import numpy as np
import numpy.typing as npt
from isomatch import Geometry

from tests.client.shapes import blob_meshes

Floats = npt.NDArray[np.float64]


def blob() -> Geometry:
    """A lopsided blob whose vertex numbers in its file are not its rows."""
    mesh = blob_meshes()[0]
    vertices = np.asarray(mesh.vertices, dtype=np.float64)
    faces = np.asarray(mesh.faces, dtype=np.int64)
    return Geometry(vertices, faces, 3 * np.arange(len(vertices)) + 1, None)


def moved(geometry: Geometry, vertices: Floats) -> Geometry:
    """The same triangles with other positions."""
    return Geometry(vertices, geometry.faces, geometry.vertex_ids, None)


def surface_samples(geometry: Geometry, count: int, seed: int) -> Floats:
    """Random points of the surface, (count, 3)."""
    random = np.random.default_rng(seed)
    faces = geometry.faces[random.integers(0, len(geometry.faces), count)]
    weights = random.dirichlet(np.ones(3), size=count)
    found: Floats = np.einsum("nc,ncd->nd", weights, geometry.vertices[faces])
    return found
