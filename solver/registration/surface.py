"""A surface of unit area, smoothed to its first eigenfunctions, with normals and curvatures.

The positions of a surface are three functions on it; their projections to the first k
eigenfunctions are a smooth surface, the smoother the smaller k is (Vallet and Lévy, "Spectral
geometry processing with manifold harmonics", CGF 27(2), 2008). Its tangents are linear in the
coefficients, so that normals need no triangles once the eigenfunctions are differentiated.
"""

from dataclasses import dataclass, field, replace
from functools import cached_property
from weakref import WeakKeyDictionary

import numpy as np
import scipy.sparse as sp

from solver.arrays import BoolArray, FloatArray, IntArray, RealArray
from solver.kernel import kernel
from solver.mesh import TriangleMesh, face_normals, vertex_normals
from solver.registration.curvature import CURVATURE_TIMES, AverageCurvatures
from solver.registration.rigidity import RigidDisplacement
from solver.shape import Shape, euclidean_farthest_points
from solver.shape.laplacian import laplacian

EIGENPAIRS = 100
"""Eigenpairs of a registration. Features of the surface smaller than √(π / 100) = 0.18 √area, a
wavelength by Weyl's law, are not smooth functions of them."""

MIRROR = np.array([-1.0, 1.0, 1.0])
"""Reflection in the plane x = 0."""

_LENGTH = 0.02
"""ℓ of :class:`.RigidDisplacement`. With 0.03, errors are up to 5 % more; with 0.015, some maps are
much worse."""

_WIDTH = 0.03
"""h of :class:`.RigidDisplacement`. With single rings instead, errors are a tenth more."""

_SAMPLES = 1500
"""Samples spread over a surface, which candidates are registered by; each stage takes the first."""

_SPREAD = 100
"""Samples, the first, between which distances are compared."""


FirstForm = tuple[FloatArray, FloatArray, FloatArray]
"""(S,) entries E, F and G of the first fundamental form at S points."""


@dataclass(frozen=True, eq=False)
class Samples:
    """Eigenfunctions and their derivatives at some points of a surface.

    Parameters
    ----------
    vertices
        (S,) vertices.
    positions
        (S, 3) positions, not smoothed.
    eigenvalues, coefficients
        (K,) eigenvalues, and (K, 3) coefficients of the surface's positions.
    eigenfunctions
        (S, K) values.
    tangents
        (2, S, K) derivatives in two orthogonal directions of the tangent plane.
    curvatures
        (S, m) mean curvature after diffusion for m times, without unit.
    reflection
        Whether the surface is reflected, so that cross products of tangents point inwards.
    """

    vertices: IntArray
    positions: FloatArray
    eigenvalues: FloatArray
    coefficients: FloatArray
    eigenfunctions: FloatArray
    tangents: FloatArray
    curvatures: FloatArray
    reflection: bool = False
    # Computed so far. Samples that replace these begin with none.
    embedded: dict[tuple[float, ...], RealArray] = field(
        default_factory=dict, init=False, repr=False
    )
    """Embeddings, see :meth:`.Alignment.embed_target`."""
    _smoothed: dict[int, tuple[FloatArray, FloatArray]] = field(
        default_factory=dict, init=False, repr=False
    )
    _first_forms: dict[int, FirstForm] = field(default_factory=dict, init=False, repr=False)
    _first: dict[int, "Samples"] = field(default_factory=dict, init=False, repr=False)

    def __len__(self) -> int:
        return len(self.vertices)

    @property
    def size(self) -> int:
        """Number K of eigenfunctions."""
        return len(self.eigenvalues)

    def first(self, count: int) -> "Samples":
        """Return the first samples, which are those of a shorter sampling; the same each time."""
        if count not in self._first:
            self._first[count] = replace(
                self,
                vertices=self.vertices[:count],
                positions=self.positions[:count],
                eigenfunctions=self.eigenfunctions[:count],
                tangents=self.tangents[:, :count],
                curvatures=self.curvatures[:count],
            )
        return self._first[count]

    def surface(self, coefficients: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Positions and normals of a smooth surface.

        Parameters
        ----------
        coefficients
            (k, 3) coefficients of its positions in the first k eigenfunctions.

        Returns
        -------
        (S, 3) positions and (S, 3) unit normals.
        """
        k = len(coefficients)
        first, second = self.derivatives(coefficients)
        normals = _unit_normals(first, second, -1.0 if self.reflection else 1.0)
        return self.eigenfunctions[:, :k] @ coefficients, normals

    def derivatives(self, coefficients: FloatArray) -> FloatArray:
        """(2, S, 3) derivatives of a smooth surface's positions in both directions."""
        derivatives: FloatArray = self.tangents[:, :, : len(coefficients)] @ coefficients
        return derivatives

    def smoothed(self, k: int) -> tuple[FloatArray, FloatArray]:
        """Positions and normals of this surface, smoothed to k eigenfunctions."""
        if k not in self._smoothed:
            self._smoothed[k] = self.surface(self.coefficients[:k])
        return self._smoothed[k]

    def first_form(self, coefficients: FloatArray) -> FirstForm:
        """First fundamental form of a smooth surface, of (k, 3) coefficients as in `surface`."""
        u, v = self.derivatives(coefficients)
        return (u * u).sum(axis=1), (u * v).sum(axis=1), (v * v).sum(axis=1)

    def smoothed_first_form(self, k: int) -> FirstForm:
        """First fundamental form of this surface, smoothed to k eigenfunctions."""
        if k not in self._first_forms:
            self._first_forms[k] = self.first_form(self.coefficients[:k])
        return self._first_forms[k]

    @cached_property
    def commute_times(self) -> RealArray:
        """(n, n) commute-time distances of the first samples, with mean 1."""
        return commute_times(self, np.arange(min(_SPREAD, len(self))))

    @cached_property
    def deviations(self) -> FloatArray:
        """(m,) mean deviations of the curvatures from their medians."""
        middle = np.median(self.curvatures, axis=0)
        deviations: FloatArray = np.abs(self.curvatures - middle).mean(axis=0)
        return deviations

    def reflected(self) -> "Samples":
        """Return the same samples of the surface reflected in the plane x = 0."""
        return replace(
            self,
            positions=self.positions * MIRROR,
            coefficients=self.coefficients * MIRROR,
            reflection=not self.reflection,
        )


@kernel
def _unit_normals(first: FloatArray, second: FloatArray, side: float) -> FloatArray:
    """(S, 3) unit vectors along the cross products of (S, 3) tangents, times `side`."""
    normals = np.empty_like(first)
    for i in range(len(first)):
        (a, b, c), (p, q, r) = first[i], second[i]
        x, y, z = b * r - c * q, c * p - a * r, a * q - b * p
        scale = side / max(np.sqrt(x * x + y * y + z * z), 1e-12)
        normals[i, 0], normals[i, 1], normals[i, 2] = scale * x, scale * y, scale * z
    return normals


def commute_times(samples: Samples, chosen: IntArray) -> RealArray:
    """(n, n) commute-time distances of n chosen samples, equation (4), with mean 1."""
    weights = 1.0 / np.sqrt(np.maximum(samples.eigenvalues[1:], 1e-12))
    points = (samples.eigenfunctions[chosen, 1:] * weights).astype(np.float32)
    squares = np.einsum("ij,ij->i", points, points)
    distances = np.sqrt(np.maximum(squares[:, None] + squares - 2.0 * points @ points.T, 0.0))
    relative: RealArray = distances / max(float(distances.mean()), 1e-12)
    return relative


class SmoothSurface:
    """A shape scaled to unit area, with its spectrum and what is derived of both.

    Normals follow the winding of the triangles: outwards where the surface is closed or nearly so,
    as repair has wound it (:mod:`solver.mesh.repair.winding`), and as in the file where it is open.
    A volume would not tell the sides of a sheet apart: its sign changes as the sheet bends.

    Parameters
    ----------
    shape
        The shape.

    Attributes
    ----------
    mesh
        Of unit area, its bounding box centred.
    spectrum
        Of the mesh.
    coefficients
        (K, 3) coefficients of the positions.
    normals
        (V, 3) unit normals.
    """

    def __init__(self, shape: Shape) -> None:
        self.spectrum = shape.unit_spectrum(EIGENPAIRS)
        self.mesh: TriangleMesh = shape.surface.scaled(1.0 / shape.size)
        positions = self.mesh.vertices
        weighted = self.spectrum.mass[:, None] * positions
        self.coefficients: FloatArray = self.spectrum.eigenfunctions.T @ weighted
        self.normals: FloatArray = vertex_normals(positions, self.mesh.faces)

    @cached_property
    def laplacian(self) -> tuple[sp.csc_array, FloatArray]:
        """Stiffness matrix and vertex areas of the mesh."""
        return laplacian(self.mesh)

    @cached_property
    def at_rest(self) -> RigidDisplacement:
        """The surface at rest, prepared for displacements.

        Raises
        ------
        MeshError
            The Laplacian cannot be factored.
        """
        return RigidDisplacement.of(self.mesh, self.laplacian, _LENGTH, _WIDTH)

    @cached_property
    def reflected_at_rest(self) -> RigidDisplacement:
        """The same, reflected in the plane x = 0."""
        return self.at_rest.resting_at(self.mesh.vertices * MIRROR)

    def share_of_area(self, vertices: BoolArray) -> float:
        """Share of the area that chosen ones of the V vertices have."""
        mass = self.spectrum.mass
        return float(mass[vertices].sum() / mass.sum())

    @cached_property
    def samples(self) -> Samples:
        """Samples spread over the surface, the farthest first."""
        return self.at(self._spread)

    @cached_property
    def _spread(self) -> IntArray:
        count = min(_SAMPLES, self.mesh.n_vertices)
        return euclidean_farthest_points(self.mesh.vertices, count)

    @cached_property
    def averages(self) -> AverageCurvatures:
        """Averages of the mean curvature."""
        return AverageCurvatures.of(self.mesh, self.spectrum, self._spread)

    def at(self, vertices: IntArray) -> Samples:
        """Return chosen vertices as samples."""
        values, spectrum = self.spectrum.eigenfunctions, self.spectrum
        frames = _tangent_frames(self.normals[vertices])
        derivatives = _gradients(self.mesh, vertices) @ values
        tangents = np.einsum("ads,sdk->ask", frames, derivatives.reshape(len(vertices), 3, -1))
        samples = Samples(
            vertices,
            self.mesh.vertices[vertices],
            spectrum.eigenvalues,
            self.coefficients,
            values[vertices],
            np.ascontiguousarray(tangents),
            np.empty((len(vertices), 0)),
        )
        return replace(samples, curvatures=_mean_curvatures(samples))


_SURFACES: "WeakKeyDictionary[Shape, SmoothSurface]" = WeakKeyDictionary()


def smooth_surface(shape: Shape) -> SmoothSurface:
    """Return the smooth surface of a shape, computed once for each shape."""
    known = _SURFACES.get(shape)
    if known is None:
        known = _SURFACES[shape] = SmoothSurface(shape)
    return known


def _tangent_frames(normals: FloatArray) -> FloatArray:
    """(2, 3, S) two unit vectors at right angles to each normal, and to each other."""
    axes = np.eye(3)[np.argmin(np.abs(normals), axis=1)]
    along = np.cross(normals, axes)
    along /= np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-12)
    return np.stack([along.T, np.cross(normals, along).T])


def _gradients(mesh: TriangleMesh, vertices: IntArray) -> sp.csr_array:
    """(3 S, V) operator: mean of a function's gradients on the triangles round a vertex, by area.

    The gradient of a hat function on a triangle is the opposite edge, turned by a right angle, over
    twice the area.
    """
    row = np.full(mesh.n_vertices, -1, dtype=np.int64)
    row[vertices] = np.arange(len(vertices))
    corners = mesh.vertices[mesh.faces]
    doubled = face_normals(mesh.vertices, mesh.faces)
    area = np.maximum(np.linalg.norm(doubled, axis=1), 1e-300)
    unit = doubled / area[:, None]
    # Each gradient times twice the area; the mean divides by the sum of these areas.
    hats = [np.cross(unit, corners[:, (c + 2) % 3] - corners[:, (c + 1) % 3]) for c in range(3)]
    around = np.zeros(len(vertices))
    rows, columns, values = [], [], []
    for corner in range(3):
        faces = np.flatnonzero(row[mesh.faces[:, corner]] >= 0)
        place = row[mesh.faces[faces, corner]]
        around += np.bincount(place, area[faces], minlength=len(vertices))
        for other in range(3):
            for axis in range(3):
                rows.append(3 * place + axis)
                columns.append(mesh.faces[faces, other])
                values.append(hats[other][faces, axis])
    entries = np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))
    operator = sp.csr_array(entries, shape=(3 * len(vertices), mesh.n_vertices))
    weights = np.repeat(1.0 / np.maximum(around, 1e-300), 3)
    return sp.csr_array(sp.diags_array(weights) @ operator)


def _mean_curvatures(samples: Samples) -> FloatArray:
    """(S, m) mean curvatures times √t, of the surface after diffusion for times t.

    ΔX = 2 H n for the positions X of a surface, here with the sign of Δ in section 3.3: H is
    positive where the surface is convex.
    """
    found = []
    for time in CURVATURE_TIMES:
        coefficients = np.exp(-time * samples.eigenvalues)[:, None] * samples.coefficients
        laplacian = samples.eigenfunctions @ (samples.eigenvalues[:, None] * coefficients)
        _, normals = samples.surface(coefficients)
        found.append(0.5 * np.sqrt(time) * (laplacian * normals).sum(axis=1))
    return np.stack(found, axis=1)
