"""Gaussian curvature: Gauss and Bonnet, closed forms, and what smoothing does."""

import numpy as np
import pytest

from solver.mesh import TriangleMesh, triangle_mesh
from solver.shape.descriptors import angle_defects, gaussian_curvature, inner_vertices, mixed_areas
from tests.solver import shapes

CHARACTERISTICS = {
    "icosphere": 2,
    "plane_grid": 1,
    "torus": 0,
    "tube": 0,
    "cube": 2,
    "blob": 2,
    "moebius_strip": 0,
    "three_sheets": 1,
    "tetrahedron": 2,
    "triangle": 1,
}


def one_vertex_in_common() -> TriangleMesh:
    """Two tetrahedra that share vertex 0: every edge has two faces."""
    one = shapes.tetrahedron()
    other = np.where(one.faces == 0, 0, one.faces + 3)
    vertices = np.concatenate([one.vertices, -one.vertices[1:]])
    return triangle_mesh(vertices, np.concatenate([one.faces, other]))


@pytest.mark.parametrize("name", CHARACTERISTICS)
def test_gauss_bonnet(name: str) -> None:
    """The angle defects sum to 2πχ on every mesh, whatever its borders and non-manifold edges."""
    defects = angle_defects(shapes.CONNECTED[name]())
    assert defects.sum() == pytest.approx(2.0 * np.pi * CHARACTERISTICS[name], abs=1e-9)


def test_gauss_bonnet_counts_components_and_shared_vertices() -> None:
    assert angle_defects(shapes.two_components()).sum() == pytest.approx(8.0 * np.pi, abs=1e-9)
    assert angle_defects(one_vertex_in_common()).sum() == pytest.approx(6.0 * np.pi, abs=1e-12)


def test_defects_of_a_square_and_a_tetrahedron() -> None:
    square = angle_defects(shapes.plane_grid(5, 5, 1.0)).reshape(5, 5)
    np.testing.assert_allclose(square[[0, 0, -1, -1], [0, -1, 0, -1]], 0.5 * np.pi)
    square[[0, 0, -1, -1], [0, -1, 0, -1]] = 0.0
    np.testing.assert_allclose(square, 0.0, atol=1e-12)
    np.testing.assert_allclose(angle_defects(shapes.tetrahedron()), np.pi)


def test_inner_vertices() -> None:
    square = inner_vertices(shapes.plane_grid(5, 4, 1.0)).reshape(4, 5)
    assert square[1:-1, 1:-1].all()
    assert square.sum() == 6
    assert inner_vertices(shapes.torus()).all()
    np.testing.assert_array_equal(inner_vertices(one_vertex_in_common()), [False] + 6 * [True])
    sheets = shapes.three_sheets()
    on_line = np.hypot(sheets.vertices[:, 0], sheets.vertices[:, 1]) < 1e-9
    assert not inner_vertices(sheets)[on_line].any()


def test_mixed_areas_of_single_triangles() -> None:
    def areas(x: float, y: float) -> list[float]:
        corners = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [x, y, 0.0]])
        return list(mixed_areas(triangle_mesh(corners, np.array([[0, 1, 2]]))))

    assert areas(0.5, np.sqrt(0.75)) == pytest.approx([np.sqrt(0.75) / 6] * 3)
    assert areas(0.0, 1.0) == pytest.approx([0.25, 0.125, 0.125])
    assert areas(-1.0, 1.0) == pytest.approx([0.25, 0.125, 0.125])
    # Acute: the circumcentre (0.5, 0.275) cuts off two right triangles at every corner.
    x, y = 0.6, 0.8
    centre = np.array([0.5, (x**2 - x + y**2) / (2 * y)])
    low = 0.25 * centre[1]
    left = 0.25 * np.hypot(x, y) * np.hypot(*(centre - np.array([x, y]) / 2))
    right = 0.25 * np.hypot(x - 1, y) * np.hypot(*(centre - np.array([x + 1, y]) / 2))
    assert areas(x, y) == pytest.approx([low + left, low + right, left + right])


@pytest.mark.parametrize("name", shapes.CONNECTED)
def test_mixed_areas_share_out_the_surface(name: str) -> None:
    mesh = shapes.CONNECTED[name]()
    areas = mixed_areas(mesh)
    assert (areas > 0.0).all()
    assert areas.sum() == pytest.approx(mesh.area, rel=1e-12)


@pytest.mark.parametrize("scale", [0.0, 0.05, 0.5])
def test_of_a_sphere(scale: float) -> None:
    sphere = shapes.moved(shapes.icosphere(4), seed=3, scale=2.0)
    np.testing.assert_allclose(gaussian_curvature(sphere, 2.0 * scale), 0.25, rtol=0.003)


def test_of_a_torus() -> None:
    """K = cos v / (r (R + r cos v)), for radii R = 1 and r = 0.4."""
    torus = shapes.torus(96, 48)
    cosine = (np.hypot(*torus.vertices.T[:2]) - 1.0) / 0.4
    exact = cosine / (0.4 * (1.0 + 0.4 * cosine))
    np.testing.assert_allclose(gaussian_curvature(torus, 0.0)[:, 0], exact, atol=0.02)
    np.testing.assert_allclose(gaussian_curvature(torus, 0.03)[:, 0], exact, atol=0.03)


@pytest.mark.parametrize("scale", [0.0, 0.1, 1.0])
@pytest.mark.parametrize("name", ["blob", "torus", "cube", "tetrahedron"])
def test_smoothing_keeps_the_integral(name: str, scale: float) -> None:
    """On closed surfaces it is 2πχ, for any scale."""
    mesh = shapes.CONNECTED[name]()
    total = mixed_areas(mesh) @ gaussian_curvature(mesh, scale)[:, 0]
    assert total == pytest.approx(2.0 * np.pi * CHARACTERISTICS[name], abs=1e-8)


@pytest.mark.parametrize("scale", [0.1, 0.2])
def test_the_scale_is_a_root_mean_square_distance(scale: float) -> None:
    """The curvature of a cone is all at its apex, and flows along its generators."""
    cone = shapes.cone()
    curvature = gaussian_curvature(cone, scale)[:, 0] * mixed_areas(cone)
    slant = np.linalg.norm(cone.vertices, axis=1)
    assert curvature.sum() == pytest.approx(2.0 * np.pi * 0.4, rel=0.01)
    assert curvature @ slant**2 / curvature.sum() == pytest.approx(scale**2, rel=0.02)


def test_borders_have_the_curvature_of_what_they_bound() -> None:
    """A cap of the sphere has curvature 1 up to its rim, whose turning is not counted."""
    cap = shapes.spherical_cap()
    curvature = gaussian_curvature(cap, 0.1)
    np.testing.assert_allclose(curvature, 1.0, rtol=0.01)
    np.testing.assert_allclose(gaussian_curvature(shapes.plane_grid(), 0.1), 0.0, atol=1e-9)
    # Without smoothing nothing is known of a border.
    unknown = ~inner_vertices(cap)
    np.testing.assert_array_equal(gaussian_curvature(cap, 0.0)[unknown], 0.0)
    np.testing.assert_array_equal(gaussian_curvature(shapes.triangle(), 0.1), 0.0)


def test_smoothing_makes_it_fit_for_uneven_and_noisy_meshes() -> None:
    sphere = shapes.uneven_sphere()
    wild, tame = gaussian_curvature(sphere, 0.0), gaussian_curvature(sphere, 0.3)
    assert np.abs(wild - 1.0).max() > 0.5
    np.testing.assert_allclose(tame, 1.0, atol=0.05)
    random = np.random.default_rng(1)
    rough = sphere.vertices * random.normal(1.0, 0.005, (sphere.n_vertices, 1))
    noisy = triangle_mesh(rough, sphere.faces)
    assert np.std(gaussian_curvature(noisy, 0.0)) > 5.0
    assert np.std(gaussian_curvature(noisy, 0.4)) < 0.3


@pytest.mark.parametrize("scale", [0.0, 0.2])
@pytest.mark.parametrize("name", ["blob", "plane_grid", "moebius_strip", "three_sheets"])
def test_invariances(name: str, scale: float) -> None:
    mesh = shapes.CONNECTED[name]()
    curvature = gaussian_curvature(mesh, scale)
    assert curvature.shape == (mesh.n_vertices, 1)
    moved = gaussian_curvature(shapes.moved(mesh, seed=6), scale)
    np.testing.assert_allclose(moved, curvature, rtol=1e-9, atol=1e-9)
    renumbered, where = shapes.permuted(mesh, seed=7)
    found = gaussian_curvature(renumbered, scale)[where]
    np.testing.assert_allclose(found, curvature, rtol=1e-9, atol=1e-9)
    # Table 1: it changes with scale, like 1/length².
    larger = gaussian_curvature(shapes.moved(mesh, seed=6, scale=5.0), 5.0 * scale)
    np.testing.assert_allclose(25.0 * larger, curvature, rtol=1e-6, atol=1e-9)
