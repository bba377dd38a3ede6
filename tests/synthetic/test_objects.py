"""Objects that are not bodies: surfaces of one component, whose individuals correspond."""

import numpy as np
import pytest

from synthetic import OBJECTS, individuals

_GENUS = {"vertebra": 1, "mug": 1}
_SHEETS = "face", "leaf"


@pytest.mark.parametrize("kind", OBJECTS)
def test_it_is_one_surface_of_the_topology_of_the_thing(kind: str) -> None:
    (made,) = individuals(kind, 0, (1500,))
    assert made.mesh.components == 1
    assert made.mesh.n_vertices <= 1500
    assert made.mesh.closed == (kind not in _SHEETS)
    if made.mesh.closed and kind != "hand":  # whose fingers may touch
        assert made.mesh.genus == _GENUS.get(kind, 0)


@pytest.mark.parametrize("kind", ["femur", "stone"])
def test_places_correspond(kind: str) -> None:
    one, other = individuals(kind, 3, (3000, 1500))
    assert len(one.places) == len(other.places)
    points = [made.mesh.vertices[made.places] for made in (one, other)]
    left, right = (each - each.mean(axis=0) for each in points)
    u, sizes, v = np.linalg.svd(left.T @ right)
    assert np.linalg.det(u @ v) == pytest.approx(1.0)
    # Of points that do not correspond it would be little, of a rigid copy 1.
    assert sizes.sum() > 0.97 * np.linalg.norm(left) * np.linalg.norm(right)


def test_forms_that_are_drawn_differ_by_seed_and_individuals_always() -> None:
    (stone,), (other,) = individuals("stone", 0, (800,)), individuals("stone", 1, (800,))
    assert len(stone.places) != len(other.places)
    one, two = individuals("tooth", 0, (800, 800))
    assert not np.allclose(one.mesh.vertices, two.mesh.vertices)
    (again,) = individuals("tooth", 0, (800,))
    np.testing.assert_array_equal(again.mesh.vertices, one.mesh.vertices)
