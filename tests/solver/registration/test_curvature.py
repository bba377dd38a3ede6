"""Averages of the mean curvature: closed forms, and what cuts and scales change."""

import numpy as np
import pytest

from solver.arrays import IntArray
from solver.mesh import TriangleMesh, triangle_mesh
from solver.registration.curvature import CURVATURE_TIMES
from solver.registration.surface import SmoothSurface
from solver.shape import Shape
from tests.solver import shapes

RADIUS = 1.0 / np.sqrt(4.0 * np.pi)
"""Of the sphere of unit area."""


@pytest.fixture(scope="module")
def sphere() -> SmoothSurface:
    return SmoothSurface(Shape(shapes.icosphere(4)))


def half_of(mesh: TriangleMesh) -> tuple[TriangleMesh, IntArray]:
    """What lies on one side of a plane, and its vertices."""
    faces = mesh.faces[(mesh.vertices[mesh.faces, 0] > 0.0).all(axis=1)]
    kept = np.unique(faces)
    return triangle_mesh(mesh.vertices[kept], np.searchsorted(kept, faces)), kept


def test_average_curvature_of_a_sphere(sphere: SmoothSurface) -> None:
    """1 / r, and rounding errors are not taken for differences."""
    found = sphere.averages.at()
    expected = np.sqrt(CURVATURE_TIMES) / RADIUS
    np.testing.assert_allclose(found, np.broadcast_to(expected, found.shape), rtol=0.02)
    assert np.ptp(sphere.averages.standardised, axis=0).max() < 0.3


def test_average_curvature_does_not_change_where_a_sphere_is_cut() -> None:
    """1 / r up to the edge of a cap, whose share of the sphere's area is known."""
    cap = SmoothSurface(Shape(shapes.spherical_cap(1.0, 60)))
    area = 2.0 / (1.0 - np.cos(1.0))
    found = cap.averages.at(area=area)
    expected = np.sqrt(CURVATURE_TIMES) / RADIUS
    np.testing.assert_allclose(found, np.broadcast_to(expected, found.shape), rtol=0.05)


def test_curvatures_of_a_part_are_those_of_the_whole_at_its_scale() -> None:
    """Of half a blob, cut through the middle and scaled: at another scale they are not."""
    mesh = shapes.blob(4)
    whole = SmoothSurface(Shape(mesh))
    part, kept = half_of(mesh)
    half = SmoothSurface(Shape(part))
    scale = float(np.sqrt(mesh.area / part.area))
    there = whole.averages.standardised[kept]
    changes = [
        np.abs(half.averages.standardised_by(whole.averages, factor * scale) - there).mean()
        for factor in (1.0, 1.5)
    ]
    assert changes[0] < 0.15
    assert changes[1] > 3.0 * changes[0]
