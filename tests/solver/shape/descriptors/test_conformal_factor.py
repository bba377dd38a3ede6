"""Conformal factors: surfaces whose uniformisation is known, borders, components."""

import numpy as np
import pytest

from solver.mesh import TriangleMesh, triangle_mesh
from solver.shape.descriptors import angle_defects, conformal_factor, mixed_areas
from solver.shape.laplacian import laplacian
from tests.solver import shapes


def spheroid(length: float) -> TriangleMesh:
    return triangle_mesh(
        shapes.icosphere(5).vertices * np.array([1.0, 1.0, length]), shapes.icosphere(5).faces
    )


def test_a_sphere_is_even_already() -> None:
    np.testing.assert_allclose(conformal_factor(shapes.icosphere(4)), 0.0, atol=1e-4)
    np.testing.assert_allclose(conformal_factor(shapes.uneven_sphere()), 0.0, atol=0.02)


def test_a_torus_of_revolution_becomes_flat() -> None:
    """(R + r cos v)² (du² + dw²) with dw = r dv / (R + r cos v): φ = -log(R + r cos v)."""
    torus = shapes.torus(96, 48)
    exact = -np.log(np.hypot(*torus.vertices.T[:2]))
    areas = mixed_areas(torus)
    exact -= areas @ exact / areas.sum()
    np.testing.assert_allclose(conformal_factor(torus)[:, 0], exact, atol=5e-4)


@pytest.mark.parametrize("length", [0.6, 2.0])
def test_of_a_spheroid(length: float) -> None:
    """Through a parallel flows the surplus of curvature on one side: 2π r φ' = ∫ (K - K_T)."""
    mesh = spheroid(length)
    angle = np.linspace(0.0, np.pi, 20001)
    speed = np.hypot(np.cos(angle), length * np.sin(angle))  # ds / dangle of the meridian
    step = angle[1] - angle[0]
    area = (
        np.r_[
            0.0, np.cumsum(0.5 * (np.sin(angle) * speed)[1:] + 0.5 * (np.sin(angle) * speed)[:-1])
        ]
        * step
    )
    curvature = 1.0 - np.cos(angle) / speed  # of the cap, over 2π; dr/ds = cos / speed
    surplus = curvature - 2.0 * area / area[-1]
    with np.errstate(invalid="ignore", divide="ignore"):
        slope = surplus / np.sin(angle) * speed
    slope[[0, -1]] = 0.0
    exact = np.r_[0.0, np.cumsum(0.5 * (slope[1:] + slope[:-1]))] * step
    found = conformal_factor(mesh)[:, 0]
    expected = np.interp(np.arccos(mesh.vertices[:, 2] / length), angle, exact)
    areas = mixed_areas(mesh)
    expected -= areas @ expected / areas.sum()
    assert np.ptp(expected) > 0.2
    np.testing.assert_allclose(found, expected, atol=0.01 * np.ptp(expected))


def test_it_is_small_at_tips() -> None:
    blob = shapes.blob()
    radius = np.linalg.norm(blob.vertices, axis=1)
    assert np.corrcoef(conformal_factor(blob)[:, 0], radius)[0, 1] < -0.85


def test_lengths_changed_by_it_make_the_curvature_even() -> None:
    """Edges times e^((φ_i + φ_j)/2); here of a bumpy torus, which becomes flat."""
    torus = shapes.torus(96, 48)
    bumps = 1.0 + 0.05 * np.sin(3.0 * np.arctan2(torus.vertices[:, 1], torus.vertices[:, 0]))
    mesh = triangle_mesh(torus.vertices * bumps[:, None], torus.faces)
    factor = np.exp(conformal_factor(mesh)[:, 0])
    before = np.abs(angle_defects(mesh)).sum()
    corners = mesh.vertices[mesh.faces]
    sides = np.linalg.norm(corners[:, [2, 0, 1]] - corners[:, [1, 2, 0]], axis=2)
    sides *= np.sqrt(factor[mesh.faces[:, [2, 0, 1]]] * factor[mesh.faces[:, [1, 2, 0]]])
    a, b, c = sides.T
    cosines = np.stack([b**2 + c**2 - a**2, c**2 + a**2 - b**2, a**2 + b**2 - c**2], axis=1)
    cosines /= 2.0 * np.stack([b * c, c * a, a * b], axis=1)
    angles = np.bincount(mesh.faces.ravel(), weights=np.arccos(cosines).ravel())
    assert np.abs(2.0 * np.pi - angles).sum() < 0.01 * before


def test_it_solves_the_equation() -> None:
    mesh = shapes.blob()
    factor, areas = conformal_factor(mesh)[:, 0], mixed_areas(mesh)
    stiffness, _ = laplacian(mesh)
    even = 4.0 * np.pi * areas / areas.sum()
    np.testing.assert_allclose(stiffness @ factor, even - angle_defects(mesh), atol=1e-9)
    assert abs(areas @ factor) < 1e-9


def test_borders() -> None:
    """What is even stays, whatever its border; a cone's curvature spreads from its apex."""
    for even in (shapes.plane_grid(), shapes.tube(), shapes.triangle(), shapes.disc()):
        np.testing.assert_allclose(conformal_factor(even), 0.0, atol=1e-9)
    np.testing.assert_allclose(conformal_factor(shapes.spherical_cap()), 0.0, atol=2e-3)
    cone = shapes.cone()
    factor = conformal_factor(cone)[:, 0]
    slant = np.linalg.norm(cone.vertices, axis=1)
    # ∇²φ = K - K_T: 2π share s φ'(s) = 2π (1 - share) (1 - s²)
    exact = (1.0 - 0.6) / 0.6 * (np.log(np.maximum(slant, 1e-9)) - 0.5 * slant**2)
    far = slant > 0.1
    offset = np.mean(exact[far] - factor[far])
    np.testing.assert_allclose(factor[far] + offset, exact[far], atol=0.02)


def test_components_are_treated_each_by_itself() -> None:
    both = shapes.two_components()
    sphere, cube = shapes.icosphere(2), shapes.cube(3)
    apart = np.concatenate([conformal_factor(sphere), conformal_factor(cube)])
    np.testing.assert_allclose(conformal_factor(both), apart, atol=1e-9)


@pytest.mark.parametrize("name", ["blob", "cube", "moebius_strip", "three_sheets"])
def test_invariances(name: str) -> None:
    """Scale too: the constant is fixed by the mean, not by the size."""
    mesh = shapes.CONNECTED[name]()
    factor = conformal_factor(mesh)
    assert factor.shape == (mesh.n_vertices, 1)
    for scale in (1.0, 1e-3, 50.0):
        moved = conformal_factor(shapes.moved(mesh, seed=6, scale=scale))
        np.testing.assert_allclose(moved, factor, rtol=1e-9, atol=1e-9)
    renumbered, where = shapes.permuted(mesh, seed=7)
    np.testing.assert_allclose(conformal_factor(renumbered)[where], factor, rtol=1e-9, atol=1e-9)
