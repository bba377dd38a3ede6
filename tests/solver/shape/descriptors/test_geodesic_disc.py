"""Discs cut out of triangles, against polygons clipped one by one."""

import numpy as np
import pytest

from solver.arrays import FloatArray
from solver.mesh import triangle_areas
from solver.shape.descriptors import annulus_areas, disc_weights
from tests.solver import shapes
from tests.solver.shape.descriptors.exact_distances import GreatCircles


def clipped(corners: FloatArray, level: FloatArray, radius: float) -> FloatArray:
    """(n, 2) polygon of the part of a triangle where a linear function is at most `radius`."""
    polygon = []
    for i in range(3):
        j = (i + 1) % 3
        if level[i] <= radius:
            polygon.append(corners[i])
        if (level[i] <= radius) != (level[j] <= radius):
            share = (radius - level[i]) / (level[j] - level[i])
            polygon.append((1.0 - share) * corners[i] + share * corners[j])
    return np.array(polygon).reshape(-1, 2)


def area_and_moments(polygon: FloatArray) -> FloatArray:
    """Integrals of 1, x and y over a convex polygon."""
    total = np.zeros(3)
    for k in range(1, len(polygon) - 1):
        fan = polygon[[0, k, k + 1]]
        (a, b), (c, d) = fan[1] - fan[0], fan[2] - fan[0]
        total += 0.5 * abs(a * d - b * c) * np.r_[1.0, fan.mean(axis=0)]
    return total


@pytest.mark.parametrize("seed", range(20))
def test_one_triangle(seed: int) -> None:
    random = np.random.default_rng(seed)
    corners, level = random.random((3, 2)), random.random(3)
    if seed % 4 == 0:
        level[random.integers(3)] = level[random.integers(3)]  # an edge at one distance
    if seed == 0:
        level[:] = 0.512
    solid = np.column_stack([corners, np.zeros(3)])
    face = np.array([[0, 1, 2]])
    area = triangle_areas(solid, face)
    radii = np.linspace(0.0, 1.25, 26)[1:]
    within = np.array([area_and_moments(clipped(corners, level, radius)) for radius in radii])
    annuli = annulus_areas(level[None], face, area, 1.25, 25)[0]
    np.testing.assert_allclose(np.cumsum(annuli), within[:, 0], atol=1e-12)
    for radius, (inside, x, y) in zip(radii, within, strict=True):
        weights = disc_weights(level[None], face, area, radius)[0]
        assert (weights >= 0.0).all()
        np.testing.assert_allclose(
            [weights.sum(), *(weights @ corners)], [inside, x, y], atol=1e-12
        )


def test_annuli_and_weights_agree_on_a_surface() -> None:
    sphere = shapes.uneven_sphere()
    areas = triangle_areas(sphere.vertices, sphere.faces)
    distances = GreatCircles(sphere).distances(np.array([0, 7, 1000]))
    annuli = annulus_areas(distances, sphere.faces, areas, 3.2, 16)
    np.testing.assert_allclose(annuli.sum(axis=1), sphere.area, rtol=1e-12)
    for edge in (3, 9):
        weights = disc_weights(distances, sphere.faces, areas, 0.2 * edge)
        np.testing.assert_allclose(weights.sum(axis=1), annuli[:, :edge].sum(axis=1), rtol=1e-9)


def test_what_cannot_be_reached_is_outside() -> None:
    both = shapes.two_components()
    areas = triangle_areas(both.vertices, both.faces)
    reached = both.component_of_vertex == 0
    distances = np.where(reached, 0.5, np.inf)[None]
    inside = areas[reached[both.faces[:, 0]]].sum()
    assert annulus_areas(distances, both.faces, areas, 10.0, 4).sum() == pytest.approx(inside)
    assert disc_weights(distances, both.faces, areas, 10.0).sum() == pytest.approx(inside)
