"""Views of shapes from chosen sides."""

from typing import get_args

import numpy as np
import pytest

from broker.contracts import View as Side
from tests.solver import shapes
from worker.pictures import source_view

FRONT = source_view(shapes.blob(2).vertices)
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
