"""Surfaces of a prototype's examples, which are registered to targets.

The distributions of section 5 hold each distance separately. Only a surface shows that the left
fore leg is on the side of the left hind leg, and that left differs from right. So a prototype keeps
surfaces of some examples, simplified, and as different from one another as possible.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.control import Control
from solver.errors import MeshError
from solver.mesh import TriangleMesh, simplified, triangle_mesh
from solver.registration import EIGENPAIRS
from solver.shape import Shape
from solver.shape.laplacian import Spectrum, laplace_beltrami_spectrum

MOST_SURFACES = 24
"""Greatest number of surfaces of a prototype, chosen on generated shapes."""

KEPT_VERTICES = 1000
"""Greatest number of vertices of a surface; registrations hardly gain from more."""

MOST_VERTICES = 1500
"""Greatest number of vertices of a surface in an archive: that of older versions."""

MOST_FACES = 3 * MOST_VERTICES
"""Greatest number of faces in an archive; closed manifolds of low genus have two per vertex."""

EIGENVALUES = 19
"""Number of eigenvalues that describe a shape as a whole, ShapeDNA (Reuter et al. 2006)."""

_MIN_VERTICES = 100
"""Least number of vertices of a surface that is registered."""


@dataclass(frozen=True, eq=False)
class ExampleSurface:
    """The simplified surface of an example, with the prototype's points on it.

    Parameters
    ----------
    vertices, faces
        (V, 3) and (F, 3) of a sound connected mesh, in the example's own unit and in single
        precision, for which the mean of the prototype's points is moved to the origin.
    points
        (N,) vertices at, or nearest to, the prototype's points.
    eigenvalues
        (19,) first nonzero Laplace-Beltrami eigenvalues of the example on unit area.
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
        if mesh.n_vertices < _MIN_VERTICES:
            raise MeshError(f"the surface has fewer than {_MIN_VERTICES} vertices")
        return mesh

    def shape(self, like: Shape, spectra: "SurfaceSpectra") -> Shape:
        """Return the surface as a shape with the settings of another.

        It is cached by these settings, so that its structures are computed once.

        Parameters
        ----------
        like
            The other shape.
        spectra
            Computes the spectrum, or takes it from a cache.

        Raises
        ------
        MeshError
            The surface is not sound, not connected, or too small.
        """
        settings = like.normalise, like.eigenpairs, like.geodesic_method
        if settings not in self._shapes:
            mesh, most = self.mesh(), max(like.eigenpairs, EIGENPAIRS)

            def compute() -> Spectrum:
                return laplace_beltrami_spectrum(mesh.scaled(1.0 / np.sqrt(mesh.area)), most)

            self._shapes[settings] = Shape(
                mesh,
                spectra(self, compute),
                normalise=like.normalise,
                eigenpairs=like.eigenpairs,
                geodesic_method=like.geodesic_method,
            )
        return self._shapes[settings]

    @cached_property
    def _shapes(self) -> dict[tuple[bool, int, str], Shape]:
        return {}


SurfaceSpectra = Callable[[ExampleSurface, Callable[[], Spectrum]], Spectrum]
"""Returns the spectrum of a surface on unit area: the result of a function, or a cached one."""


def compute_spectrum(_surface: ExampleSurface, compute: Callable[[], Spectrum]) -> Spectrum:
    """Compute the spectrum of a surface, without a cache."""
    return compute()


def example_surfaces(
    shapes: Sequence[Shape], points: Sequence[IntArray], control: Control
) -> tuple[ExampleSurface, ...]:
    """Select surfaces of examples farthest first by their eigenvalues, the reference first.

    Parameters
    ----------
    shapes
        M examples, the reference first.
    points
        (N,) vertices of each example that correspond to the prototype's points.
    control
        May cancel.

    Returns
    -------
    At most 24 surfaces; examples that cannot be simplified to a sound surface are skipped.

    Raises
    ------
    Cancelled
        Through `control`.
    """
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
    """(19,) nonzero eigenvalues of a shape on unit area; fewer if it has too few vertices."""
    values = shape.unit_spectrum(EIGENVALUES + 1).eigenvalues[1:]
    return values[values > 0.0]


def surface_of(shape: Shape, points: IntArray) -> ExampleSurface | None:
    """Simplify a shape's surface; ``None`` if the result is unsound or still too large.

    It is unsound if single precision does not reach its coordinates.

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
    with np.errstate(over="ignore"):  # infinite coordinates are refused as those of no sound mesh
        vertices = centred.astype(np.float32).astype(np.float64)
    surface = ExampleSurface(vertices, mesh.faces, places, first_eigenvalues(shape))
    try:
        surface.mesh()
    except MeshError:
        return None
    return surface
