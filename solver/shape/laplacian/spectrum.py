"""Spectrum of the Laplace-Beltrami operator: Δφ_i = λ_i φ_i, section 3.3.

The stiffness matrix is the cotangent Laplacian of the tufted intrinsic Delaunay triangulation of
the mesh (Sharp and Crane, "A Laplacian for Nonmanifold Triangle Meshes", SGP 2020, by
robust_laplacian), which has nonnegative weights on any triangulation, with natural (Neumann)
conditions at boundaries; the mass matrix is lumped.
"""

import io
import zipfile
from dataclasses import dataclass, replace

import numpy as np
import robust_laplacian
import scipy.linalg
import scipy.sparse as sp

from solver.arrays import FloatArray, npz_bytes
from solver.errors import MeshError
from solver.mesh import TriangleMesh
from solver.shape.laplacian.eigensolver import smallest_eigenpairs

_DENSE_VERTICES = 400
"""Meshes of at most so many vertices are solved densely, by LAPACK."""

_LEAST_MASS = 1e-6
"""Least vertex area relative to the mean: vertices among needles have hardly any, and the condition
of M^-½ L M^-½, hence the accuracy of eigenvectors, depends on its inverse."""

_LINK_WEIGHT = 2.0 / np.sqrt(3.0)
"""Weight of a link between components: that of the two edges which connect a vertex to the next row
of equilateral triangles, whatever the width of the gap, as if the surface went on."""

_NULL_SKEWNESS = 1e-6
"""Third moment, of an eigenfunction with root mean square 1, that vanishes by symmetry."""


@dataclass(frozen=True, eq=False)
class Spectrum:
    """The k smallest eigenvalues of the Laplace-Beltrami operator and their eigenfunctions.

    Parameters
    ----------
    eigenvalues
        (k,) float64 ascending, in 1/length²; the first is 0.
    eigenfunctions
        (V, k) float64, in 1/length; orthonormal in the inner product Σ_v mass_v f_v g_v. The first
        is constant.
    mass
        (V,) float64 area of each vertex, in length²; the sum is the surface's area.
    """

    eigenvalues: FloatArray
    eigenfunctions: FloatArray
    mass: FloatArray

    @property
    def n_eigenpairs(self) -> int:
        """Number k of eigenpairs, the constant one included."""
        return len(self.eigenvalues)

    @property
    def area(self) -> float:
        """Area of the surface, in length²."""
        return float(self.mass.sum())

    def truncated(self, k: int) -> "Spectrum":
        """Return the first k eigenpairs, or all if there are fewer."""
        return replace(
            self, eigenvalues=self.eigenvalues[:k], eigenfunctions=self.eigenfunctions[:, :k]
        )

    def scaled(self, factor: float) -> "Spectrum":
        """Return the spectrum of the surface scaled by `factor`."""
        if factor == 1.0:
            return self
        return Spectrum(
            self.eigenvalues / factor**2, self.eigenfunctions / factor, self.mass * factor**2
        )

    def to_bytes(self) -> bytes:
        """Return the spectrum as the bytes of an ``.npz`` file, without loss."""
        arrays = {
            "eigenvalues": self.eigenvalues,
            "eigenfunctions": self.eigenfunctions,
            "mass": self.mass,
        }
        return npz_bytes(arrays, zipfile.ZIP_STORED)

    @classmethod
    def from_bytes(cls, data: bytes) -> "Spectrum":
        """Read what :meth:`to_bytes` wrote.

        Raises
        ------
        ValueError
            The bytes are not a stored spectrum. They may be untrusted: nothing is unpickled.
        """
        try:
            with np.load(io.BytesIO(data), allow_pickle=False) as arrays:
                spectrum = cls(arrays["eigenvalues"], arrays["eigenfunctions"], arrays["mass"])
        except MemoryError:
            raise
        except Exception as error:
            raise ValueError(f"not a stored spectrum: {error}") from error
        shape = (len(spectrum.mass), len(spectrum.eigenvalues))
        if spectrum.eigenfunctions.shape != shape or spectrum.eigenfunctions.dtype != np.float64:
            raise ValueError("not a stored spectrum: arrays of wrong shape or type")
        return spectrum


def laplace_beltrami_spectrum(mesh: TriangleMesh, k: int = 100) -> Spectrum:
    """Compute the k smallest eigenpairs of the Laplace-Beltrami operator of a mesh.

    The generalised problem L φ = λ M φ is solved as the standard one of M^-½ L M^-½, by
    shift-invert block Lanczos, on small meshes densely. The result is deterministic. An
    eigenfunction's sign makes its third moment positive, or, where that vanishes by symmetry, its
    value of greatest magnitude; eigenfunctions of repeated eigenvalues are an arbitrary basis.

    Parameters
    ----------
    mesh
        Any mesh; components are connected by its links, so that only constants have eigenvalue 0.
    k
        Number of eigenpairs, the constant one included.

    Returns
    -------
    Spectrum
        Of min(k, V) eigenpairs.

    Raises
    ------
    MeshError
        The mesh's Laplacian is singular to working precision, or the eigensolver does not
        converge.
    ValueError
        `k` is not positive.
    """
    if k < 1:
        raise ValueError("k must be at least 1")
    size = np.sqrt(mesh.area)
    stiffness, mass = laplacian(mesh.scaled(1.0 / size))
    scale = sp.diags_array(1.0 / np.sqrt(mass))
    symmetric = sp.csc_array(scale @ stiffness @ scale)
    null_vector = np.sqrt(mass / mass.sum())
    try:
        values, vectors = _eigenpairs(symmetric, min(k, mesh.n_vertices), null_vector)
    except (ArithmeticError, RuntimeError, np.linalg.LinAlgError) as error:
        raise MeshError(f"the spectrum of the mesh cannot be computed: {error}") from error
    functions = vectors / np.sqrt(mass)[:, None]
    spectrum = Spectrum(values, functions * _signs(functions, mass), mass)
    return spectrum.scaled(float(size))


def spectrum_memory(n_vertices: int, k: int) -> int:
    """Estimate the address space in bytes that a spectrum needs.

    Two factors at a time, for which SuperLU reserves more than it uses, and the eigenvectors.
    Fitted to measurements: 2.6 GB for 200,000 vertices and 6.5 GB for 500,000 with 100 eigenpairs,
    2.9 GB for 200,000 with 300. Two fifths of it are resident.

    Parameters
    ----------
    n_vertices
        Number V of vertices.
    k
        Number of eigenpairs.
    """
    return n_vertices * (12_000 + 8 * k) if n_vertices > _DENSE_VERTICES else 0


def laplacian(mesh: TriangleMesh, linked: bool = True) -> tuple[sp.csc_array, FloatArray]:
    """Discretise the Laplace-Beltrami operator.

    Parameters
    ----------
    mesh
        Any mesh.
    linked
        Whether the mesh's links connect its components; they change no vertex' area.

    Returns
    -------
    stiffness : (V, V) sparse, symmetric, positive semi-definite; rows sum to 0. Without unit.
    mass : (V,) float64 diagonal of the lumped mass matrix, in length².

    Raises
    ------
    MeshError
        The Laplacian is not finite, as on nearly degenerate faces.
    """
    try:
        stiffness, mass = robust_laplacian.mesh_laplacian(mesh.vertices, mesh.faces)
    except RuntimeError as error:
        raise MeshError(f"the Laplacian of the mesh cannot be computed: {error}") from error
    weights: FloatArray = mass.diagonal().astype(np.float64)
    if not (np.isfinite(stiffness.data).all() and (weights > 0.0).all()):
        raise MeshError(
            "the Laplacian of the mesh is not finite: some of its faces are nearly degenerate"
        )
    weights = np.maximum(weights, _LEAST_MASS * weights.mean())
    symmetric = sp.csc_array(0.5 * (stiffness + stiffness.T))
    if linked and len(mesh.links):
        symmetric = sp.csc_array(symmetric + _LINK_WEIGHT * _graph_laplacian(mesh))
    return symmetric, weights


def _graph_laplacian(mesh: TriangleMesh) -> sp.csc_array:
    """(V, V) sparse: fᵀ L f is the sum of squared differences over the links."""
    count = len(mesh.links)
    rows = np.repeat(np.arange(count), 2)
    entries = np.tile([1.0, -1.0], count), (rows, mesh.links.ravel())
    differences = sp.csc_array(entries, shape=(count, mesh.n_vertices))
    return sp.csc_array(differences.T @ differences)


def _eigenpairs(
    matrix: sp.csc_array, k: int, null_vector: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """The k smallest eigenpairs, the first one exactly 0 and the null vector."""
    if k == 1:
        return np.zeros(1), null_vector[:, None]
    if matrix.shape[0] > max(_DENSE_VERTICES, 3 * k):
        # Weyl's law: λ_k A ≈ 4πk, and the area is 1.
        return smallest_eigenpairs(matrix, k, null_vector, 4.0 * np.pi * k)
    values, vectors = scipy.linalg.eigh(matrix.toarray(), subset_by_index=(0, k - 1))
    # Orthogonal to the exact null vector, not to the computed one.
    values[0], vectors[:, 0] = 0.0, null_vector
    vectors = np.asarray(scipy.linalg.qr(vectors, mode="economic")[0], dtype=np.float64)
    return np.maximum(values, 0.0), vectors


def _signs(functions: FloatArray, mass: FloatArray) -> FloatArray:
    """(k,) signs ±1 that eigenfunctions are multiplied by, see `laplace_beltrami_spectrum`."""
    skewness = np.sqrt(mass.sum()) * (mass @ (functions * functions * functions))
    largest = functions[np.argmax(np.abs(functions), axis=0), np.arange(functions.shape[1])]
    signs: FloatArray = np.where(
        np.where(np.abs(skewness) > _NULL_SKEWNESS, skewness, largest) < 0.0, -1.0, 1.0
    )
    return signs
