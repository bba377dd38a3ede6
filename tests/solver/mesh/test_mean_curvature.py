"""Measures of mean curvature: polyhedra and smooth surfaces whose integrals are known."""

from dataclasses import replace

import numpy as np
import pytest

from solver.mesh import mean_curvature_measures
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
    """Nearly so at each vertex: area and integral are of the same edges."""
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


def test_edges_of_a_boundary_have_neither_curvature_nor_area() -> None:
    """On an open tube: 1 / (2 r) at every vertex that has an inner edge, at its ends as well."""
    mesh = shapes.tube(around=64, along=40, radius=0.5)
    assert mesh.on_boundary.any()
    integrals, areas = mean_curvature_measures(mesh)
    assert areas.sum() < mesh.area
    # A sheared edge along the tube is not as curved as one straight along it: means of rings.
    heights = np.round(mesh.vertices[:, np.ptp(mesh.vertices, axis=0).argmax()], 6)
    rings = np.unique(heights, return_inverse=True)[1]
    means = np.bincount(rings, integrals) / np.bincount(rings, areas)
    np.testing.assert_allclose(means[1:-1], 1.0, rtol=0.02)
    assert (means[[0, -1]] > 0.5).all()


def test_where_the_winding_does_not_agree_there_is_no_curvature() -> None:
    """A Möbius strip has no inside: along some edges both triangles are wound the same way."""
    mesh = shapes.moebius_strip()
    integrals, areas = mean_curvature_measures(mesh)
    assert np.isfinite(integrals).all()
    assert areas.sum() < mesh.area
