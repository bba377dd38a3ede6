"""Pull-backs of values: what is reproduced exactly, and what is lost there and back."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from solver.errors import TransferError
from solver.transfer import PullBack
from tests.solver import shapes
from tests.solver.transfer.maps import FINE, MESH, both_ways, random_pull_back

SEEDS = st.integers(0, 2**31 - 1)


@given(SEEDS, st.floats(-1e6, 1e6))
def test_constants_stay_constant(seed: int, constant: float) -> None:
    along = random_pull_back(seed)
    np.testing.assert_allclose(
        along.means(np.full(30, constant)), constant, rtol=1e-12, atol=1e-300
    )


@given(SEEDS)
def test_means_stay_between_the_values(seed: int) -> None:
    along = random_pull_back(seed)
    values = np.random.default_rng(seed).standard_normal(30)
    found, three = along.means(values), values[along.corners]
    assert (found <= three.max(axis=1) + 1e-12).all()
    assert (found >= three.min(axis=1) - 1e-12).all()


@given(SEEDS)
def test_a_majority_equals_the_sum_of_coordinates_by_label(seed: int) -> None:
    along = random_pull_back(seed)
    labels = np.random.default_rng(seed).integers(-2, 3, size=30)
    found = along.majority(labels)
    for label, corners, weights in zip(found, along.corners, along.barycentric, strict=True):
        shares = {one: weights[labels[corners] == one].sum() for one in labels[corners]}
        assert shares[label] == pytest.approx(max(shares.values()))


def test_linear_functions_are_reproduced_on_the_same_surface() -> None:
    """The vertices of a finer triangulation of a plane are points of the coarser one."""
    plane = shapes.plane_grid()
    random = np.random.default_rng(3)
    faces = random.integers(0, plane.n_faces, size=100)
    weights = random.dirichlet(np.ones(3), size=100)
    corners = plane.faces[faces]
    places = np.einsum("kc,kcd->kd", weights, plane.vertices[corners])
    along = PullBack(np.arange(100), plane.vertex_ids[corners], weights, 100)
    slope = random.standard_normal((3, 2))
    np.testing.assert_allclose(
        along.means(plane.vertices @ slope + 7.0), places @ slope + 7.0, atol=1e-12
    )


def test_values_of_a_permuted_copy_are_permuted() -> None:
    other, where = shapes.permuted(MESH, seed=5)
    there, back = both_ways(MESH, other)
    values = np.random.default_rng(0).standard_normal((MESH.n_vertices, 2))
    np.testing.assert_allclose(there.means(values)[where], values, atol=1e-6)
    np.testing.assert_allclose(back.means(there.means(values)), values, atol=1e-6)
    labels = np.arange(MESH.n_vertices)
    np.testing.assert_array_equal(there.majority(labels)[where], labels)


def test_a_smooth_function_and_a_segmentation_lose_little_there_and_back() -> None:
    there, back = both_ways(MESH, FINE)
    smooth = np.sin(2.0 * MESH.vertices[:, 0]) + MESH.vertices[:, 1]
    returned = back.means(there.means(smooth))
    assert np.abs(returned - smooth).mean() < 0.02 * np.ptp(smooth)
    labels = (MESH.vertices[:, 2] > 0.1).astype(np.int64) + 2 * (MESH.vertices[:, 0] > 0.0)
    carried = there.majority(labels)
    assert set(carried) <= set(labels)
    assert (back.majority(carried) == labels).mean() > 0.95


def test_vertices_without_an_image_have_no_value() -> None:
    """Those that no face uses, and those of a part without a partner, the last ones included."""
    corners = np.array([[0, 1, 2], [2, 1, 0]])
    along = PullBack(np.array([1, 3]), corners, np.full((2, 3), 1 / 3), 6)
    found = along.spread(along.means(np.array([0.0, 3.0, 6.0])), np.nan)
    np.testing.assert_array_equal(found, [np.nan, 3.0, np.nan, 3.0, np.nan, np.nan])


def test_every_vertex_needs_a_value() -> None:
    along = random_pull_back(0)
    with pytest.raises(TransferError, match="29 rows of values, and the surface has a vertex 29"):
        along.means(np.zeros(29))
    with pytest.raises(TransferError, match="29 rows"):
        along.majority(np.zeros(29))
