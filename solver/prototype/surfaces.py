"""Surfaces of a prototype's examples: which way its points lie around one another.

The distributions of section 5 know every distance by itself. That the left fore leg is on the side
of the left hind leg, and that left is not right, is said by a surface alone. So a prototype keeps
those of some examples, with few vertices, and as different from one another as it can.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.control import Control
from solver.errors import MeshError
from solver.functional_maps import EIGENPAIRS
from solver.mesh import TriangleMesh, simplified, triangle_mesh
from solver.shape import Shape
from solver.shape.laplacian import Spectrum, laplace_beltrami_spectrum

MOST_SURFACES = 24
KEPT_VERTICES = 1000
"""Of a surface that is kept, at most: what a map takes of it is hardly more exact with more."""

MOST_VERTICES = 1500
"""Of a surface in an archive: so many were kept of old."""

MOST_FACES = 3 * MOST_VERTICES
"""Likewise: closed manifolds without hundreds of handles have some two to a vertex."""

EIGENVALUES = 19
"""By which shapes are compared as wholes."""

_LEAST_VERTICES = 100
"""Of fewer, no map between surfaces can be made."""


@dataclass(frozen=True, eq=False)
class ExampleSurface:
    """The surface of an example, simplified, and where the prototype's points are on it.

    Parameters
    ----------
    vertices, faces
        (V, 3) and (F, 3) of a sound connected mesh, in the example's own unit, as exact as single
        precision, which is why the prototype's points on the example have the mean 0.
    points
        (N,) the vertices that are, or are nearest to, the prototype's points.
    eigenvalues
        (19,) the first of the Laplace-Beltrami operator of the example on unit area, without 0.
    """

    vertices: FloatArray
    faces: IntArray
    points: IntArray
    eigenvalues: FloatArray

    def mesh(self) -> TriangleMesh:
        """Return the surface as a mesh.

        Raises
        ------
        MeshError
            It is not sound, not connected, or too small.
        """
        mesh = triangle_mesh(self.vertices, self.faces)
        same = mesh.n_vertices == len(self.vertices) and np.array_equal(mesh.faces, self.faces)
        if not same or mesh.components != 1:
            raise MeshError("the surface is not sound")
        if mesh.n_vertices < _LEAST_VERTICES:
            raise MeshError(f"the surface has fewer than {_LEAST_VERTICES} vertices")
        return mesh

    def shape(self, like: Shape, spectrum: "SurfaceSpectra") -> Shape:
        """Return the surface as a shape, whose structures are computed as those of another are.

        It is the same for all that are alike in this, so that what is computed of it is so once.

        Parameters
        ----------
        like
            The other.
        spectrum
            Takes the spectrum from where it is kept, or computes it.

        Raises
        ------
        MeshError
            The surface is not sound, not connected, or too small.
        """
        alike = like.normalise, like.eigenpairs, like.geodesic_method
        if alike not in self._shapes:
            mesh, most = self.mesh(), max(like.eigenpairs, EIGENPAIRS)

            def compute() -> Spectrum:
                return laplace_beltrami_spectrum(mesh.scaled(1.0 / np.sqrt(mesh.area)), most)

            self._shapes[alike] = Shape(
                mesh,
                spectrum(self, compute),
                normalise=like.normalise,
                eigenpairs=like.eigenpairs,
                geodesic_method=like.geodesic_method,
            )
        return self._shapes[alike]

    @cached_property
    def _shapes(self) -> dict[tuple[bool, int, str], Shape]:
        return {}


SurfaceSpectra = Callable[[ExampleSurface, Callable[[], Spectrum]], Spectrum]
"""Returns what the second computes of the first, on unit area, or has it from an earlier match."""


def computed(_surface: ExampleSurface, compute: Callable[[], Spectrum]) -> Spectrum:
    """Spectra of surfaces that nobody keeps."""
    return compute()


def example_surfaces(
    shapes: Sequence[Shape], points: Sequence[IntArray], control: Control | None = None
) -> tuple[ExampleSurface, ...]:
    """Keep the surfaces of some examples.

    Parameters
    ----------
    shapes
        M examples, the reference first.
    points
        Of each, the (N,) vertices that correspond to the prototype's points.
    control
        May cancel.

    Returns
    -------
    At most 24: the reference's, and then always that which is most different, by its eigenvalues,
    from those kept; without those of which no sound surface of few vertices can be made.

    Raises
    ------
    Cancelled
        Through `control`.
    """
    control = control or Control()
    described = [first_eigenvalues(shape) for shape in shapes]
    logarithms = np.array([np.log(values) for values in described if len(values) == EIGENVALUES])
    places = [i for i, values in enumerate(described) if len(values) == EIGENVALUES]
    kept: list[ExampleSurface] = []
    apart = np.full(len(places), np.inf)
    while len(kept) < MOST_SURFACES and (apart > 0.0).any():
        control.check()
        place = int(np.argmax(apart))
        apart = np.minimum(apart, np.linalg.norm(logarithms - logarithms[place], axis=1))
        apart[place] = 0.0
        example = places[place]
        surface = surface_of(shapes[example], points[example])
        if surface is not None:
            kept.append(surface)
    return tuple(kept)


def nearest_surfaces(
    surfaces: Sequence[ExampleSurface], target: Shape, count: int
) -> list[ExampleSurface]:
    """Return the surfaces whose eigenvalues are nearest to a shape's, the nearest first."""
    values = first_eigenvalues(target)
    if len(values) < EIGENVALUES:
        return []
    logarithms = np.log(values)
    apart = [float(np.linalg.norm(np.log(one.eigenvalues) - logarithms)) for one in surfaces]
    return [surfaces[place] for place in np.argsort(apart, kind="stable")[:count]]


def first_eigenvalues(shape: Shape) -> FloatArray:
    """(19,) eigenvalues of a shape on unit area, without 0; fewer of a shape that is too small."""
    spectrum = shape.spectrum(EIGENVALUES + 1).scaled(1.0 / shape.size)
    values = spectrum.eigenvalues[1:]
    return values[values > 0.0]


def surface_of(shape: Shape, points: IntArray) -> ExampleSurface | None:
    """Simplify a shape's surface, or return ``None`` if no sound one of few vertices comes of it.

    Parameters
    ----------
    shape
        A shape with 19 eigenvalues.
    points
        (N,) vertices of it.
    """
    mesh = simplified(shape.mesh, KEPT_VERTICES)
    if mesh.n_vertices > MOST_VERTICES or mesh.n_faces > MOST_FACES:
        return None
    places = mesh.vertices_of(shape.mesh.vertex_ids[points])
    centred = mesh.vertices - shape.mesh.vertices[points].mean(axis=0)
    vertices = centred.astype(np.float32).astype(np.float64)
    surface = ExampleSurface(vertices, mesh.faces, places, first_eigenvalues(shape))
    try:
        surface.mesh()
    except MeshError:
        return None
    return surface
