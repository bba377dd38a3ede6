"""The Laplace-Beltrami spectrum: closed forms, invariances, and the shape of the answer."""

import io
import pickle
from collections.abc import Callable

import numpy as np
import pytest

from solver.arrays import FloatArray
from solver.mesh import TriangleMesh, triangle_mesh
from solver.shape.descriptors import angle_defects
from solver.shape.laplacian import Spectrum, laplace_beltrami_spectrum, laplacian
from tests.solver import shapes


def sphere_eigenvalues(count: int) -> FloatArray:
    """l(l+1), each 2l+1 times."""
    degrees = np.repeat(np.arange(count), 2 * np.arange(count) + 1)[:count]
    return (degrees * (degrees + 1)).astype(np.float64)


def rectangle_eigenvalues(width: float, count: int) -> FloatArray:
    """π²(m²/w² + n²): natural conditions on the boundary of a w x 1 rectangle."""
    m, n = np.meshgrid(np.arange(count), np.arange(count))
    values: FloatArray = np.sort((np.pi**2 * ((m / width) ** 2 + n**2)).ravel())
    return values[:count]


def tetrahedron_eigenvalues(edge: float, count: int) -> FloatArray:
    """Even functions on the flat torus that covers a regular tetrahedron's surface twice.

    The torus is the plane modulo the hexagonal lattice of side twice the edge, so the eigenvalues
    are (4π²/3)(m² + mn + n²)/edge², one for each pair ±(m, n).
    """
    m, n = np.meshgrid(np.arange(-count, count + 1), np.arange(-count, count + 1))
    norms = np.sort((m * m + m * n + n * n).ravel())
    values: FloatArray = (4.0 * np.pi**2 / 3.0 / edge**2) * np.r_[0.0, norms[1::2]]
    return values[:count]


def flat_torus_lattice() -> FloatArray:
    """(2, 2) rows: the translations of the plane that the flat torus unrolls by.

    One goes round a polygon. The other goes up one band and, mirrored, up the other: in a band,
    A_0 lies at the origin, A_1 at (a, 0), and B_s where its distances from them put it.
    """
    below, above = shapes.flat_torus_corners()
    side = np.linalg.norm(below[1] - below[0])
    across = []
    for shift in shapes.FLAT_TORUS_SHIFTS:
        near, far = (np.linalg.norm(above[shift] - below[i]) for i in (0, 1))
        along = (side**2 + near**2 - far**2) / (2.0 * side) - shift * side
        across.append((along, np.sqrt(near**2 - (along + shift * side) ** 2)))
    (x, y), (u, v) = across
    return np.array([[shapes.FLAT_TORUS_SIDES * side, 0.0], [x - u, y + v]])


def flat_torus_eigenvalues(count: int) -> FloatArray:
    """4π²|ξ|² for ξ in the dual lattice, each twice, for cosine and sine."""
    dual = np.linalg.inv(flat_torus_lattice()).T
    m, n = (axis.ravel() for axis in np.meshgrid(np.arange(-count, count + 1), np.arange(-9, 10)))
    values: FloatArray = 4.0 * np.pi**2 * ((np.stack([m, n], axis=1) @ dual) ** 2).sum(axis=1)
    return np.sort(values)[:count]


@pytest.mark.parametrize(
    ("mesh", "expected", "tolerance"),
    [
        (shapes.icosphere(4), sphere_eigenvalues(36), 0.02),
        (shapes.flat_torus(4), flat_torus_eigenvalues(40), 0.02),
        (shapes.plane_grid(61, 41, 1.5), rectangle_eigenvalues(1.5, 30), 0.02),
        (shapes.fine_tetrahedron(5), tetrahedron_eigenvalues(np.sqrt(2.0), 28), 0.02),
        (shapes.tube(8, 400), (np.pi * np.arange(8.0)) ** 2, 0.002),
    ],
    ids=["sphere", "torus", "rectangle", "tetrahedron", "string"],
)
def test_closed_forms(mesh: TriangleMesh, expected: FloatArray, tolerance: float) -> None:
    spectrum = laplace_beltrami_spectrum(mesh, len(expected))
    np.testing.assert_allclose(spectrum.eigenvalues, expected, rtol=tolerance, atol=1e-9)


@pytest.mark.parametrize(
    ("make", "exact"),
    [(shapes.icosphere, sphere_eigenvalues(16)), (shapes.flat_torus, flat_torus_eigenvalues(15))],
    ids=["sphere", "torus"],
)
def test_second_order_convergence(make: Callable[[int], TriangleMesh], exact: FloatArray) -> None:
    errors = [
        np.abs(
            laplace_beltrami_spectrum(make(n), len(exact)).eigenvalues[1:] / exact[1:] - 1.0
        ).max()
        for n in (2, 3, 4)
    ]
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.15)
    assert errors[1] / errors[2] == pytest.approx(4.0, rel=0.15)


def test_multiplicities_on_the_sphere() -> None:
    """Each l(l+1) occurs 2l + 1 times: the gaps between are where they should be."""
    values = laplace_beltrami_spectrum(shapes.icosphere(4), 81).eigenvalues
    places = np.flatnonzero(np.diff(values) > 1.0) + 1
    np.testing.assert_array_equal(places, np.arange(1, 9) ** 2)


def test_the_flat_torus_is_flat() -> None:
    mesh = shapes.flat_torus(1)
    np.testing.assert_allclose(angle_defects(mesh), 0.0, atol=1e-12)
    assert mesh.closed
    assert abs(np.linalg.det(flat_torus_lattice())) == pytest.approx(mesh.area, rel=1e-12)


@pytest.mark.parametrize("name", shapes.CONNECTED)
def test_eigenpairs_satisfy_their_definition(name: str) -> None:
    mesh = shapes.CONNECTED[name]()
    spectrum = laplace_beltrami_spectrum(mesh, 50)
    k = min(50, mesh.n_vertices)
    values, functions, mass = spectrum.eigenvalues, spectrum.eigenfunctions, spectrum.mass
    assert (spectrum.n_eigenpairs, functions.shape) == (k, (mesh.n_vertices, k))
    assert {values.dtype, functions.dtype, mass.dtype} == {np.dtype(np.float64)}
    assert values[0] == 0.0
    assert (np.diff(values) >= 0.0).all()
    assert values[min(1, k - 1)] > 0.0
    np.testing.assert_allclose(functions[:, 0], 1.0 / np.sqrt(mesh.area), rtol=1e-9)
    assert spectrum.area == pytest.approx(mesh.area, rel=1e-9)
    assert (mass > 0.0).all()
    np.testing.assert_allclose(functions.T @ (functions * mass[:, None]), np.eye(k), atol=1e-9)
    stiffness, _ = laplacian(mesh)
    residuals = stiffness @ functions - functions * values * mass[:, None]
    assert np.abs(residuals).max() < 1e-6 * np.abs(stiffness @ functions).max()


def test_stiffness_is_a_laplacian() -> None:
    for make in shapes.CONNECTED.values():
        stiffness, _ = laplacian(make())
        assert abs(stiffness - stiffness.T).max() == 0.0
        np.testing.assert_allclose(stiffness.sum(axis=0), 0.0, atol=1e-9)
        off_diagonal = stiffness.toarray() - np.diag(stiffness.diagonal())
        assert off_diagonal.max() < 1e-9  # intrinsic Delaunay: no negative weights


def heat_diagonal(spectrum: Spectrum) -> FloatArray:
    """A function of the spectrum that no choice of basis or sign changes, without unit."""
    times = spectrum.area * np.geomspace(0.01, 1.0, 5)
    decay = np.exp(-np.outer(spectrum.eigenvalues, times))
    return spectrum.area * (spectrum.eigenfunctions**2 @ decay)


@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
def test_scale_and_rigid_motion(scale: float) -> None:
    mesh = shapes.blob()
    spectrum = laplace_beltrami_spectrum(mesh)
    other = laplace_beltrami_spectrum(shapes.moved(mesh, seed=5, scale=scale))
    np.testing.assert_allclose(
        other.eigenvalues, spectrum.eigenvalues / scale**2, rtol=1e-9, atol=1e-12 / scale**2
    )
    np.testing.assert_allclose(other.mass, spectrum.mass * scale**2, rtol=1e-9)
    np.testing.assert_allclose(heat_diagonal(other), heat_diagonal(spectrum), rtol=1e-8)
    scaled = spectrum.scaled(scale)
    np.testing.assert_allclose(scaled.eigenvalues, other.eigenvalues, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(heat_diagonal(scaled), heat_diagonal(spectrum), rtol=1e-12)


def test_far_from_the_origin() -> None:
    mesh = shapes.blob()
    shift = np.array([2.0**20, -(2.0**20), 2.0**20])
    there = laplace_beltrami_spectrum(triangle_mesh(mesh.vertices + shift, mesh.faces))
    here = laplace_beltrami_spectrum(mesh)
    np.testing.assert_allclose(there.eigenvalues, here.eigenvalues, rtol=1e-6, atol=1e-9)


def test_vertex_numbering_does_not_matter() -> None:
    mesh = shapes.blob()
    renumbered, where = shapes.permuted(mesh, seed=6)
    spectrum, other = laplace_beltrami_spectrum(mesh), laplace_beltrami_spectrum(renumbered)
    np.testing.assert_allclose(other.eigenvalues, spectrum.eigenvalues, rtol=1e-9, atol=1e-9)
    # Without symmetry eigenvalues are simple, and functions are the same up to sign, which
    # the convention settles.
    np.testing.assert_allclose(
        other.eigenfunctions[where][:, :30], spectrum.eigenfunctions[:, :30], atol=1e-6
    )


def test_bending_does_not_matter() -> None:
    """A sheet rolled up: the same surface to itself, up to the faces that cut the bends short."""
    flat = shapes.plane_grid(61, 41, 1.5)
    x, y, _ = flat.vertices.T
    rolled = triangle_mesh(np.stack([np.cos(x), y, np.sin(x)], axis=1), flat.faces)
    np.testing.assert_allclose(
        laplace_beltrami_spectrum(rolled, 40).eigenvalues,
        laplace_beltrami_spectrum(flat, 40).eigenvalues,
        rtol=1e-3,
        atol=1e-9,
    )


def test_the_same_mesh_gives_the_same_bytes() -> None:
    mesh = shapes.blob()
    again = triangle_mesh(mesh.vertices.copy(), mesh.faces.copy())
    first, second = laplace_beltrami_spectrum(mesh), laplace_beltrami_spectrum(again)
    assert first.to_bytes() == second.to_bytes()


def test_signs_make_third_moments_positive() -> None:
    spectrum = laplace_beltrami_spectrum(shapes.blob(), 40)
    assert (spectrum.mass @ spectrum.eigenfunctions**3 > 0.0).all()
    # Where symmetry makes the moment vanish, the largest value is positive.
    odd = laplace_beltrami_spectrum(shapes.plane_grid(30, 20), 2).eigenfunctions[:, 1]
    assert odd[np.argmax(np.abs(odd))] > 0.0


def test_truncation_keeps_the_first() -> None:
    spectrum = laplace_beltrami_spectrum(shapes.cube(), 60)
    np.testing.assert_array_equal(spectrum.truncated(7).eigenvalues, spectrum.eigenvalues[:7])
    assert spectrum.truncated(7).eigenfunctions.shape == (218, 7)
    assert spectrum.truncated(100).n_eigenpairs == 60


def test_bytes_and_back() -> None:
    spectrum = laplace_beltrami_spectrum(shapes.cube(), 20)
    back = Spectrum.from_bytes(spectrum.to_bytes())
    np.testing.assert_array_equal(back.eigenvalues, spectrum.eigenvalues)
    np.testing.assert_array_equal(back.eigenfunctions, spectrum.eigenfunctions)
    np.testing.assert_array_equal(back.mass, spectrum.mass)


def _npz(**arrays: np.ndarray) -> bytes:
    stream = io.BytesIO()
    np.savez(stream, allow_pickle=True, **arrays)
    return stream.getvalue()


@pytest.mark.parametrize(
    "data",
    [
        b"",
        b"PK\x03\x04 not really",
        pickle.dumps([1, 2, 3]),
        laplace_beltrami_spectrum(shapes.cube(), 20).to_bytes()[:-100],
        _npz(eigenvalues=np.zeros(2)),
        _npz(eigenvalues=np.zeros(2), eigenfunctions=np.zeros((5, 3)), mass=np.ones(5)),
        _npz(eigenvalues=np.zeros(2), eigenfunctions=np.zeros((5, 2), "f4"), mass=np.ones(5)),
        _npz(eigenvalues=np.array([{}]), eigenfunctions=np.zeros((5, 1)), mass=np.ones(5)),
    ],
)
def test_other_bytes_are_refused(data: bytes) -> None:
    with pytest.raises(ValueError, match="not a stored spectrum"):
        Spectrum.from_bytes(data)


def test_one_eigenpair_is_the_constant() -> None:
    spectrum = laplace_beltrami_spectrum(shapes.icosphere(3), 1)
    assert spectrum.eigenvalues.tolist() == [0.0]
    np.testing.assert_allclose(
        spectrum.eigenfunctions, 1.0 / np.sqrt(shapes.icosphere(3).area), rtol=1e-12
    )


def test_refusals() -> None:
    with pytest.raises(ValueError, match="at least 1"):
        laplace_beltrami_spectrum(shapes.cube(), 0)


def test_slivers_do_no_harm() -> None:
    """Needles among the faces: cotangents of 10⁶ before intrinsic Delaunay flips."""
    mesh = shapes.plane_grid(21, 21, 1.0)
    vertices = mesh.vertices.copy()
    inner = (vertices[:, :2] > 0.01).all(axis=1) & (vertices[:, :2] < 0.99).all(axis=1)
    row = inner & (np.abs(vertices[:, 1] - 0.5) < 0.01)
    vertices[row, 1] -= 0.05 - 1e-6  # down onto the next row, almost
    spectrum = laplace_beltrami_spectrum(triangle_mesh(vertices, mesh.faces), 10)
    np.testing.assert_allclose(
        spectrum.eigenvalues, rectangle_eigenvalues(1.0, 10), rtol=0.05, atol=1e-9
    )
