"""Surfaces and maps between them for tests of landmarks."""

import numpy as np
import numpy.typing as npt
from isomatch import Geometry, VertexMap

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


def identity(geometry: Geometry) -> VertexMap:
    """The map of each vertex to itself."""
    ids = geometry.vertex_ids
    corners = np.zeros((len(ids), 3), dtype=np.int64)
    weights = np.zeros((len(ids), 3))
    for face in geometry.faces:
        corners[face] = ids[face]
    weights[corners == ids[:, None]] = 1.0
    return VertexMap(ids, ids, corners, weights)


def surface_samples(geometry: Geometry, count: int, seed: int) -> Floats:
    """Random points of the surface, (count, 3)."""
    random = np.random.default_rng(seed)
    faces = geometry.faces[random.integers(0, len(geometry.faces), count)]
    weights = random.dirichlet(np.ones(3), size=count)
    found: Floats = np.einsum("nc,ncd->nd", weights, geometry.vertices[faces])
    return found
