"""Maps of all vertices to a surface, in turn with a displacement beyond the eigenfunctions."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from solver.arrays import FloatArray, IntArray, RealArray
from solver.control import Control
from solver.functional_maps import FunctionalMap, nearest_points
from solver.mesh import vertex_normals
from solver.registration.alignment import LOCAL, Alignment
from solver.registration.descent import descend, project
from solver.registration.rigidity import RigidDisplacement
from solver.registration.surface import MIRROR, SmoothSurface

_LENGTH = 0.05
"""ℓ of :class:`.RigidDisplacement`: a quarter of the finest wavelength of the eigenfunctions."""

_ROUNDS = 3
"""Rounds of displacement and new images. Six instead change errors by 3 %."""

_STEPS = 2
"""Steps of a displacement in a round."""


@dataclass(frozen=True, eq=False)
class SurfaceMap:
    """A displaced surface X and its images on the surface Y.

    Parameters
    ----------
    source, target
        The surfaces X and Y.
    functional_map
        Of size k.
    positions
        (V, 3) vertices of the displaced source, at √area 1.
    reflected
        Whether the source is reflected in the plane x = 0, so that its winding is reversed.
    """

    source: SmoothSurface
    target: SmoothSurface
    functional_map: FunctionalMap
    positions: FloatArray
    reflected: bool

    @classmethod
    def of(
        cls, source: SmoothSurface, target: SmoothSurface, alignment: Alignment, reflected: bool
    ) -> "SurfaceMap":
        """Return the map of a registration in eigenfunctions.

        Details of the source that are not smooth are turned with it.
        """
        k = alignment.size
        turn = (MIRROR if reflected else np.ones(3))[:, None] * alignment.turn
        displacement = alignment.coefficients - source.coefficients[:k] @ turn
        functions = source.spectrum.eigenfunctions[:, :k]
        positions = source.mesh.vertices @ turn + functions @ displacement
        return cls(source, target, alignment.functional_map, positions, reflected)

    def images(self, vertices: IntArray | None = None, start: IntArray | None = None) -> IntArray:
        """Nearest target vertices in the embedding, found by descent.

        Parameters
        ----------
        vertices
            (S,) source vertices, by default all.
        start
            (S,) target vertices to begin at, by default the nearest samples.
        """
        here = self._embedded if vertices is None else self._embedded[vertices]
        return _nearest_vertices(here, self._target_embedded, self.target, start)

    def on_triangles(self, images: IntArray) -> tuple[IntArray, FloatArray]:
        """Images of all vertices between vertices: triangles, and barycentric coordinates.

        Parameters
        ----------
        images
            (V,) nearest target vertices.
        """
        return _on_triangles(self._embedded, self._target_embedded, self.target, images)

    def inverse(self) -> tuple[IntArray, IntArray, FloatArray]:
        """Nearest points of the displaced source to all target vertices, in the same embedding.

        Every target vertex has one, whether or not an image of the source is near it.

        Returns
        -------
        (W,) nearest source vertices, (W,) source triangles, and (W, 3) barycentric coordinates.
        """
        here, there = self._target_embedded, self._embedded
        vertices = _nearest_vertices(here, there, self.source)
        return vertices, *_on_triangles(here, there, self.source, vertices)

    def refined(self, control: Control) -> tuple["SurfaceMap", IntArray]:
        """Displace the source as rigidly as possible towards its images, and find them again.

        Parameters
        ----------
        control
            May cancel; past its deadline, fewer rounds are made.

        Returns
        -------
        The refined map, and (V,) target vertices nearest to all source vertices.

        Raises
        ------
        Cancelled
            Through `control`.
        MeshError
            The source's Laplacian cannot be factored.
        """
        current, images = self, self.images()
        for _ in control.in_time(range(_ROUNDS)):
            positions = current.positions
            for _ in range(_STEPS):
                positions = self._rigid.step(positions, self.target.mesh.vertices[images])
            functional = current._fitted(images)
            current = replace(current, positions=positions, functional_map=functional)
            images = current.images(start=images)
        return current, images

    @cached_property
    def _rigid(self) -> RigidDisplacement:
        return RigidDisplacement(self.source.mesh, _LENGTH)

    def _fitted(self, images: IntArray) -> FunctionalMap:
        """Orthogonal functional map fitted to the images of all vertices, by their areas."""
        k, ours = self.functional_map.size, self.source.spectrum
        weighted = ours.eigenfunctions[:, :k] * ours.mass[:, None]
        theirs = self.target.spectrum.eigenfunctions[images, :k]
        left, _, right = np.linalg.svd(theirs.T @ weighted)
        return FunctionalMap(np.ascontiguousarray(left @ right))

    @cached_property
    def _embedded(self) -> RealArray:
        faces = self.source.mesh.faces
        side = -self.source.side if self.reflected else self.source.side
        normals = side * vertex_normals(self.positions, faces)
        spectral = self.functional_map.images(self.source.spectrum.eigenfunctions)
        return _embedding(spectral, self.positions, normals)

    @cached_property
    def _target_embedded(self) -> RealArray:
        target = self.target
        spectral = target.spectrum.eigenfunctions[:, : self.functional_map.size]
        return _embedding(spectral, target.mesh.vertices, target.normals)


def _nearest_vertices(
    queries: RealArray, points: RealArray, surface: SmoothSurface, start: IntArray | None = None
) -> IntArray:
    """(S,) vertices of an embedded surface nearest to queries, by descent from nearest samples."""
    if start is None:
        samples = surface.samples.vertices
        start = samples[nearest_points(queries, points[samples])]
    return descend(queries, points, *surface.mesh.neighbours, start)


def _on_triangles(
    queries: RealArray, points: RealArray, surface: SmoothSurface, vertices: IntArray
) -> tuple[IntArray, FloatArray]:
    """Nearest points in the triangles round the nearest vertices of an embedded surface."""
    return project(queries, points, surface.mesh.faces, *surface.mesh.incident_faces, vertices)


def _embedding(spectral: FloatArray, positions: FloatArray, normals: FloatArray) -> RealArray:
    """Embedding as of :meth:`.Alignment.embed`, in single precision."""
    parts = (
        LOCAL.spectrum / np.sqrt(spectral.shape[1]) * spectral,
        LOCAL.space * positions,
        LOCAL.normals * normals,
    )
    return np.hstack(parts).astype(np.float32)
