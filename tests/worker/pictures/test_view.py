"""Views of shapes from chosen sides."""

from typing import get_args

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from broker.contracts import View as Side
from synthetic import articulated
from tests.solver import shapes
from worker.pictures import View, source_view, target_view

FRONT = source_view(shapes.blob(2).vertices, shapes.blob(2).faces)
SIDES: tuple[Side, ...] = get_args(Side)


@pytest.mark.parametrize("side", SIDES)
def test_views_are_rotations(side: Side) -> None:
    axes = FRONT.seen_from(side).axes
    np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(axes) == pytest.approx(np.linalg.det(FRONT.axes))


@pytest.mark.parametrize(
    ("side", "towards"),
    [
        ("front", (0, 0, 1)),
        ("back", (0, 0, -1)),
        ("left", (-1, 0, 0)),
        ("right", (1, 0, 0)),
        ("top", (0, 1, 0)),
        ("bottom", (0, -1, 0)),
    ],
)
def test_the_side_faces_the_reader(side: Side, towards: tuple[int, int, int]) -> None:
    seen = FRONT.seen_from(side).axes @ FRONT.axes.T @ np.array(towards)
    np.testing.assert_allclose(seen, [0.0, 0.0, 1.0], atol=1e-12)


@pytest.mark.parametrize("side", ["left", "right", "back"])
def test_sideways_views_keep_what_is_up(side: Side) -> None:
    np.testing.assert_allclose(FRONT.seen_from(side).axes[1], FRONT.axes[1])


@pytest.mark.parametrize("axis", [(0.0, 1.0, 0.0), (0.6, 0.0, 0.8)])
def test_a_rotated_target_is_seen_from_the_same_side(axis: tuple[float, float, float]) -> None:
    """Rotated about the vertical, or lying, and far away: its file has another axis up."""
    points = shapes.blob(2).vertices
    turned = points @ Rotation.from_rotvec(2.0 * np.array(axis)).as_matrix().T + [0.3, 0.3, 9.0]
    seen = target_view(FRONT, points, turned).of(turned - turned.mean(axis=0))
    np.testing.assert_allclose(seen, FRONT.of(points - points.mean(axis=0)), atol=1e-7)


def test_a_bent_target_stands_upright() -> None:
    points = shapes.blob(2).vertices
    bent = points @ Rotation.from_rotvec([0.2, 0.0, 0.0]).as_matrix().T
    bent += 0.3 * np.random.default_rng(1).standard_normal(bent.shape)
    np.testing.assert_allclose(target_view(FRONT, points, bent).axes[1], FRONT.axes[1])


@pytest.mark.parametrize("size", [1.0, 1e-9, 1e40])
@pytest.mark.parametrize(("up", "lengths"), [(1, [1, 3, 2]), (2, [2, 1, 3]), (2, [1, 2, 3])])
def test_shapes_stand_and_are_seen_from_their_broad_side(
    up: int, lengths: list[float], size: float
) -> None:
    """A table: a plate on four legs."""
    corners = np.array([[x, y] for x in (-1.0, 1.0) for y in (-1.0, 1.0)])
    legs = np.column_stack([corners, np.zeros(4)])
    plate = np.column_stack([0.3 * corners, np.ones(4)])
    points = np.vstack([legs, plate])
    if up == 1:
        points = points[:, [1, 2, 0]]
    points = size * points * lengths
    axes = source_view(points, np.array([[0, 1, 4], [2, 3, 7]])).axes
    np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(axes) == pytest.approx(1.0)
    np.testing.assert_array_equal(axes[1], np.eye(3)[up])
    # The thinner of the two horizontal directions points to the viewer.
    thin = min({0, 1, 2} - {up}, key=lambda axis: np.ptp(points[:, axis]))
    assert np.argmax(np.abs(axes[2])) == thin


def test_rows_of_records_have_six_decimals() -> None:
    axes = [[1.0 / 3.0, 0.0, 0.0], [0.0, -0.0, 1.0], [-1e-9, 0.5, 0.0]]
    rows = View(np.array(axes)).rows()
    assert repr(rows) == "((0.333333, 0.0, 0.0), (0.0, 0.0, 1.0), (0.0, 0.5, 0.0))"


@pytest.mark.parametrize(("category", "pose"), [("human", "standing"), ("dog", "walking")])
@pytest.mark.parametrize("axis", [1, 2])
def test_bodies_stand_on_their_feet(category: str, pose: str, axis: int) -> None:
    """Whichever of y and z is vertical in their file, and whether it points up or down."""
    body = articulated(category, pose)
    vertices = body.vertices - body.vertices.mean(axis=0)
    if axis == 2:
        vertices = vertices[:, [0, 2, 1]] * [1.0, -1.0, 1.0]
    for turn in (1.0, -1.0):
        up = source_view(vertices * [1.0, turn, turn], body.faces).axes[1]
        np.testing.assert_array_equal(up, turn * np.eye(3)[axis])


@pytest.mark.parametrize(("category", "pose"), [("human", "reaching"), ("cat", "sitting")])
def test_in_doubt_the_axis_points_up(category: str, pose: str) -> None:
    body = articulated(category, pose)
    vertices = body.vertices - body.vertices.mean(axis=0)
    np.testing.assert_array_equal(source_view(vertices, body.faces).axes[1], [0.0, 1.0, 0.0])
