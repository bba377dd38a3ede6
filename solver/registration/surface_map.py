"""Maps of all vertices to a surface, in turn with a displacement beyond the eigenfunctions."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from solver.arrays import FloatArray, IntArray, RealArray
from solver.control import Control
from solver.functional_maps import FunctionalMap, nearest_points
from solver.mesh import descend, project, vertex_normals
from solver.registration.alignment import LOCAL, Alignment, Weights, embedding
from solver.registration.rigidity import RigidDisplacement
from solver.registration.surface import MIRROR, SmoothSurface

ROUNDS = 12
"""Rounds of displacement and new images. Four more change errors by 2 to 4 %."""

_MOMENTUM = 0.9
"""Share of a displacement that is added to the next one: without, four times as many rounds are
needed. Nesterov, "A method of solving a convex programming problem with convergence rate O(1/k²)",
1983.
"""

_WITHOUT_SPECTRUM = Weights(spectrum=0.0, space=LOCAL.space, normals=LOCAL.normals)
"""Of the embedding beyond the eigenfunctions: with spectral coordinates, errors are 5 % more."""


Images = tuple[IntArray, IntArray, FloatArray]
"""(V,) nearest vertices, (V,) triangles and (V, 3) barycentric coordinates."""


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
    embedded_target
        (W, m) the target in it.
    """

    source: SmoothSurface
    target: SmoothSurface
    functional_map: FunctionalMap
    positions: FloatArray
    reflected: bool
    weights: Weights
    embedded_target: RealArray

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
        functional = alignment.functional_map
        embedded = _embedded_target(target, LOCAL, functional.size)
        return cls(source, target, functional, positions, reflected, LOCAL, embedded)

    @property
    def rest(self) -> RigidDisplacement:
        """The source at rest.

        Raises
        ------
        MeshError
            Its Laplacian cannot be factored.
        """
        return self.source.reflected_at_rest if self.reflected else self.source.at_rest

    def images(self, vertices: IntArray | None = None, start: IntArray | None = None) -> IntArray:
        """Nearest target vertices in the embedding, found by descent.

        Parameters
        ----------
        vertices
            (S,) source vertices, by default all.
        start
            (S,) target vertices to begin at, by default the nearest samples.
        """
        if vertices is None and start is None:
            return self._images
        here = _rows(self._embedded, vertices)
        return _nearest_vertices(here, self.embedded_target, self.target, start)

    def on_triangles(
        self, images: IntArray, vertices: IntArray | None = None
    ) -> tuple[IntArray, FloatArray]:
        """Images between vertices: triangles, and barycentric coordinates.

        Parameters
        ----------
        images
            (S,) nearest target vertices.
        vertices
            (S,) source vertices, by default all.
        """
        here = _rows(self._embedded, vertices)
        return _on_triangles(here, self.embedded_target, self.target, images)

    def inverse(self, vertices: IntArray | None = None) -> Images:
        """Nearest points of the displaced source to target vertices, in the same embedding.

        Every target vertex has one, whether or not an image of the source is near it.

        Parameters
        ----------
        vertices
            (S,) target vertices, by default all.

        Returns
        -------
        (S,) nearest source vertices, (S,) source triangles, and (S, 3) barycentric coordinates.
        """
        here, there = self._embedded, _rows(self.embedded_target, vertices)
        if self.weights is LOCAL:
            nearest = self.nearest(vertices)
        else:
            # Begun with spectral coordinates, which tell apart what touches.
            spectral = _embedded_target(self.target, LOCAL, self.functional_map.size)
            start = _nearest_vertices(_rows(spectral, vertices), self._embed(LOCAL), self.source)
            nearest = _nearest_vertices(there, here, self.source, start)
        return nearest, *_on_triangles(there, here, self.source, nearest)

    def nearest(self, vertices: IntArray | None = None) -> IntArray:
        """Vertices of the displaced source nearest to target vertices, in the embedding.

        Parameters
        ----------
        vertices
            (S,) target vertices, by default all.
        """
        there = _rows(self.embedded_target, vertices)
        return _nearest_vertices(there, self._embedded, self.source)

    def refined(
        self, rigid: RigidDisplacement, control: Control, rounds: int = ROUNDS
    ) -> tuple["SurfaceMap", IntArray]:
        """Displace the source as rigidly as possible towards its images, and find them again.

        Parameters
        ----------
        rigid
            The source, as :attr:`rest` or drawn otherwise.
        control
            May cancel; past its deadline, fewer rounds are made.
        rounds
            Of displacement and new images.

        Returns
        -------
        The refined map, and (V,) target vertices nearest to all source vertices.

        Raises
        ------
        Cancelled
            Through `control`.
        """
        current, ahead, images = self, self, self.images()
        for _ in control.in_time(range(rounds)):
            positions = rigid.step(ahead.positions, ahead.image_positions(images))
            further = positions + _MOMENTUM * (positions - current.positions)
            current, ahead = ahead.moved(positions), ahead.moved(further)
            images = ahead.images(start=images)
        return current, current.images(start=images)

    def image_positions(self, images: IntArray) -> FloatArray:
        """(V, 3) positions of the images of all vertices, between vertices of the target.

        Parameters
        ----------
        images
            (V,) nearest target vertices.
        """
        return points_in_triangles(
            self.target.mesh.vertices, self.target, *self.on_triangles(images)
        )

    def moved(self, positions: FloatArray) -> "SurfaceMap":
        """Return the map of a further displaced source, embedded without spectral coordinates.

        Parameters
        ----------
        positions
            (V, 3) vertices of the source.
        """
        embedded = self.embedded_target
        if self.weights is not _WITHOUT_SPECTRUM:
            embedded = _embedded_target(self.target, _WITHOUT_SPECTRUM, 0)
        return replace(
            self, positions=positions, weights=_WITHOUT_SPECTRUM, embedded_target=embedded
        )

    @cached_property
    def _images(self) -> IntArray:
        return _nearest_vertices(self._embedded, self.embedded_target, self.target)

    @property
    def strain(self) -> float:
        """Mean strain of the displaced source; raises as :attr:`rest` does."""
        return self.rest.strain(self.positions)

    @cached_property
    def normals(self) -> FloatArray:
        """(V, 3) unit normals of the displaced source, on the side that they are on at rest."""
        normals = vertex_normals(self.positions, self.source.mesh.faces)
        return -normals if self.reflected else normals

    @cached_property
    def _embedded(self) -> RealArray:
        return self._embed(self.weights)

    def _embed(self, weights: Weights) -> RealArray:
        """(V, m) embedding of the displaced source."""
        functions = None
        if weights.spectrum:
            functions = self.functional_map.images(self.source.spectrum.eigenfunctions)
        return embedding(self.positions, self.normals, weights, functions)


def _embedded_target(target: SmoothSurface, weights: Weights, size: int) -> RealArray:
    """(W, m) embedding of a target with a number of spectral coordinates."""
    functions = target.spectrum.eigenfunctions[:, :size]
    return embedding(target.mesh.vertices, target.normals, weights, functions)


def points_in_triangles(
    positions: FloatArray, surface: SmoothSurface, faces: IntArray, barycentric: FloatArray
) -> FloatArray:
    """(N, 3) positions of points in triangles, from the positions of the vertices.

    Parameters
    ----------
    positions
        (V, 3) of the surface's vertices.
    surface
        V vertices.
    faces, barycentric
        (N,) triangles and (N, 3) coordinates in them.
    """
    corners = positions[surface.mesh.faces[faces]]
    found: FloatArray = np.einsum("vc,vcd->vd", barycentric, corners)
    return found


def _rows(embedded: RealArray, vertices: IntArray | None) -> RealArray:
    return embedded if vertices is None else embedded[vertices]


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
