"""Maps of all vertices to a surface, in turn with a displacement beyond the eigenfunctions."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.control import Control
from solver.functional_maps import FunctionalMap, nearest_points
from solver.mesh import vertex_normals
from solver.registration.alignment import LOCAL, Alignment, Weights
from solver.registration.descent import descend, project
from solver.registration.rigidity import RigidDisplacement
from solver.registration.surface import MIRROR, SmoothSurface

_LENGTH = 0.02
"""ℓ of :class:`.RigidDisplacement`. From 0.015 to 0.03, errors change by 5 %."""

_WIDTH = 0.03
"""h of :class:`.RigidDisplacement`. With single rings instead, errors are a quarter more."""

_ROUNDS = 12
"""Rounds of displacement and new images. Four more change errors by 3 %."""

_MOMENTUM = 0.9
"""Share of a displacement that is added to the next one. Without, thrice as many rounds are needed
(Nesterov, "A method of solving a convex programming problem with convergence rate O(1/k²)", 1983).
"""

_NEAR = Weights(spectrum=0.0, space=LOCAL.space, normals=LOCAL.normals)
"""Of the embedding beyond the eigenfunctions: with spectral coordinates, errors are 6 % more."""


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
    weights
        Of the embedding in which images are found.
    """

    source: SmoothSurface
    target: SmoothSurface
    functional_map: FunctionalMap
    positions: FloatArray
    reflected: bool
    weights: Weights = LOCAL

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
        here, there = self._embedded, self._target_embedded
        if vertices is not None:
            here = here[vertices]
        if start is None:
            samples = self.target.samples.vertices
            start = samples[nearest_points(here, there[samples])]
        return descend(here, there, *self.target.adjacency, start)

    def on_triangles(self, images: IntArray) -> tuple[IntArray, FloatArray]:
        """Images of all vertices between vertices: triangles, and barycentric coordinates.

        Parameters
        ----------
        images
            (V,) nearest target vertices.
        """
        target = self.target
        embedded = self._embedded, self._target_embedded
        return project(*embedded, target.mesh.faces, *target.incident, images)

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
        rest = self.source.mesh
        if self.reflected:
            rest = replace(rest, vertices=rest.vertices * MIRROR)
        rigid = RigidDisplacement(rest, _LENGTH, _WIDTH)
        current, ahead, images = self, self, self.images()
        for _ in control.in_time(range(_ROUNDS)):
            positions = rigid.step(ahead.positions, ahead._places(images))
            further = positions + _MOMENTUM * (positions - current.positions)
            current, ahead = (
                replace(self, positions=one, weights=_NEAR) for one in (positions, further)
            )
            images = ahead.images(start=images)
        return current, current.images(start=images)

    def _places(self, images: IntArray) -> FloatArray:
        """(V, 3) images of all vertices between vertices."""
        faces, barycentric = self.on_triangles(images)
        corners = self.target.mesh.vertices[self.target.mesh.faces[faces]]
        places: FloatArray = (barycentric[:, :, None] * corners).sum(axis=1)
        return places

    @cached_property
    def _embedded(self) -> FloatArray:
        faces = self.source.mesh.faces
        side = -self.source.side if self.reflected else self.source.side
        normals = side * vertex_normals(self.positions, faces)
        return self._embedding(
            lambda: self.functional_map.images(self.source.spectrum.eigenfunctions),
            self.positions,
            normals,
        )

    @cached_property
    def _target_embedded(self) -> FloatArray:
        target = self.target
        return self._embedding(
            lambda: target.spectrum.eigenfunctions[:, : self.functional_map.size],
            target.mesh.vertices,
            target.normals,
        )

    def _embedding(
        self, spectral: Callable[[], FloatArray], positions: FloatArray, normals: FloatArray
    ) -> FloatArray:
        """Embedding as of :meth:`.Alignment.embed`, in single precision."""
        weights = self.weights
        parts = [weights.space * positions, weights.normals * normals]
        if weights.spectrum:
            parts.append(weights.spectrum / np.sqrt(self.functional_map.size) * spectral())
        return np.hstack(parts).astype(np.float32)
