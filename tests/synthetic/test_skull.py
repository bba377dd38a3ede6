"""Skull-like surfaces: closed, hollow, with a known correspondence of individuals."""

import numpy as np
import pytest
from scipy.spatial import KDTree

from solver.mesh import triangle_mesh
from synthetic import Skull, skull

SPACING = 0.45


@pytest.fixture(scope="module")
def individual() -> Skull:
    return skull(1, 0.8, SPACING)


def test_it_is_one_closed_surface_with_openings(individual: Skull) -> None:
    mesh = triangle_mesh(individual.vertices, individual.faces)
    assert mesh.components == 1
    assert mesh.closed
    assert mesh.genus >= 5.0


def test_places_on_the_template_are_displaced_to_the_vertices(individual: Skull) -> None:
    moved = individual.displacement(individual.rest)
    np.testing.assert_allclose(moved, individual.vertices, atol=1e-4)
    apart = np.linalg.norm(individual.rest - individual.vertices, axis=1)
    assert 0.4 < np.sqrt((apart**2).mean()) < 1.6


def test_corresponding_places_of_two_individuals_are_on_their_surfaces(individual: Skull) -> None:
    other = skull(2, 0.8, SPACING)
    places = other.displacement(individual.rest)
    # Walls differ by their noise, pores and teeth by being there or not.
    assert np.median(KDTree(other.vertices).query(places)[0]) < SPACING


def test_the_template_is_symmetric_and_individuals_hardly_less() -> None:
    same = skull(3, 0.0, SPACING)
    np.testing.assert_array_equal(same.rest, same.vertices)
    mirrored = same.vertices * (1.0, -1.0, 1.0)
    assert np.median(KDTree(same.vertices).query(mirrored)[0]) < SPACING


def test_a_seed_gives_one_individual(individual: Skull) -> None:
    np.testing.assert_array_equal(skull(1, 0.8, SPACING).vertices, individual.vertices)
    assert len(skull(2, 0.8, SPACING).vertices) != len(individual.vertices)
