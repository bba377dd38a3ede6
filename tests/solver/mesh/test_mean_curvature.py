"""Measures of mean curvature: polyhedra and smooth surfaces whose integrals are known."""

from dataclasses import replace

import numpy as np
import pytest

from solver.mesh import mean_curvature_measures, triangle_areas, triangle_mesh
from tests.solver import shapes


@pytest.mark.parametrize("cells", [1, 6])
def test_the_integral_over_a_cube_is_that_of_its_twelve_edges(cells: int) -> None:
    """Half of length times angle, whatever the triangles: flat edges have no curvature."""
    mesh = shapes.cube(cells)
    side = np.ptp(mesh.vertices[:, 0])
    integrals, areas = mean_curvature_measures(mesh)
    assert integrals.sum() == pytest.approx(12 * side * (np.pi / 2) / 2)
    assert areas.sum() == pytest.approx(mesh.area)


def test_the_integral_over_a_tetrahedron() -> None:
    mesh = shapes.tetrahedron()
    lengths = np.linalg.norm(np.diff(mesh.vertices[mesh.edges], axis=1)[:, 0], axis=1)
    assert np.ptp(lengths) < 1e-12
    integrals, _ = mean_curvature_measures(mesh)
    np.testing.assert_allclose(integrals, 3 * lengths[0] * (np.pi - np.arccos(1 / 3)) / 4)


def test_the_mean_over_a_sphere_is_one_over_its_radius() -> None:
    """Nearly so at each vertex: area and integral are of the same triangles."""
    mesh = shapes.icosphere(4).scaled(3.0)
    integrals, areas = mean_curvature_measures(mesh)
    np.testing.assert_allclose(integrals / areas, 1 / 3, rtol=0.2)
    assert np.median(integrals / areas) == pytest.approx(1 / 3, rel=0.005)
    assert integrals.sum() == pytest.approx(4 * np.pi * 3, rel=0.002)


def test_inside_out_the_curvature_is_negative() -> None:
    mesh = shapes.blob()
    flipped = replace(mesh, faces=mesh.faces[:, ::-1])
    ours, theirs = (mean_curvature_measures(one) for one in (mesh, flipped))
    np.testing.assert_allclose(theirs[0], -ours[0], atol=1e-14)
    np.testing.assert_allclose(theirs[1], ours[1])


@pytest.mark.parametrize("lengthwise", [False, True])
def test_a_cut_changes_no_mean(lengthwise: bool) -> None:
    """On a tube of radius r, 1 / (2 r) wherever there is area: next to cuts along and across."""
    mesh = shapes.tube(around=64, along=40, radius=0.5)
    kept = (mesh.vertices[mesh.faces, 0] > 0.0).all(axis=1) if lengthwise else slice(None)
    part = triangle_mesh(mesh.vertices, mesh.faces[kept])
    integrals, areas = mean_curvature_measures(part)
    assert 0.8 * part.area < areas.sum() < part.area
    # A vertex on the boundary has triangles to one side alone, which may lack the curved edge.
    inner = ~part.on_boundary & (areas > 0.9 * areas.max())
    np.testing.assert_allclose(integrals[inner] / areas[inner], 1.0, rtol=0.01)
    assert integrals.sum() / areas.sum() == pytest.approx(1.0, rel=0.01)


def test_triangles_of_another_winding_count_no_more_nor_do_those_next_to_them() -> None:
    mesh = shapes.icosphere(2)
    faces = mesh.faces.copy()
    faces[7] = faces[7, ::-1]
    ours, theirs = (mean_curvature_measures(one) for one in (mesh, replace(mesh, faces=faces)))
    near = np.isin(mesh.faces, mesh.faces[7]).sum(axis=1) >= 2
    assert near.sum() == 4
    assert ours[1].sum() - theirs[1].sum() == pytest.approx(
        triangle_areas(mesh.vertices, mesh.faces[near]).sum()
    )
    far = np.setdiff1d(np.arange(mesh.n_vertices), mesh.faces[near])
    for one, other in zip(ours, theirs, strict=True):
        np.testing.assert_allclose(other[far], one[far])


def test_non_manifold_edges_have_no_curvature() -> None:
    """Three half planes that meet in a line are flat."""
    mesh = shapes.three_sheets()
    integrals, areas = mean_curvature_measures(mesh)
    np.testing.assert_allclose(integrals, 0.0, atol=1e-8)
    assert 0.0 < areas.sum() < mesh.area
