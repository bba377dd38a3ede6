"""Colours that are transferred by a dense correspondence."""

import itertools
import re

import numpy as np
import pytest
from isomatch._results import match_panels
from matplotlib.colors import rgb_to_hsv

from broker.contracts import InverseCorrespondence
from service.page import STATIC
from solver.mesh import triangle_mesh
from synthetic import Pose, human
from tests.solver import shapes
from worker.pictures import coloring, colors_by_place
from worker.pictures.coloring import (
    UNMAPPED,
    point_colors,
    surface_colors,
    transferred_colors,
)

MESH = shapes.blob(2)
LEVELS = {"UNMAPPED": 255.0 * UNMAPPED, "LIGHT": 255.0 * coloring.LIGHT, "PALE": coloring.PALE}
GREY = [UNMAPPED] * 3
COLORS = colors_by_place(MESH.vertices)


def at_vertices(target: list[int], source: list[int]) -> InverseCorrespondence:
    return InverseCorrespondence(
        target=tuple(target),
        source=tuple(source),
        faces=tuple((one, one, one) for one in source),
        barycentric=((1.0, 0.0, 0.0),) * len(source),
    )


def test_hands_feet_and_head_have_different_hues() -> None:
    """Of a tall body with raised arms; matched points are at its ends and all over it."""
    raised = Pose(
        (
            ("left_collar", (0.0, 0.0, 22.0)),
            ("left_shoulder", (0.0, 0.0, 72.0)),
            ("right_collar", (0.0, 0.0, -22.0)),
            ("right_shoulder", (0.0, 0.0, -72.0)),
        )
    )
    body = human(raised, resolution=400)
    x, y = body.rest[:, 0], body.rest[:, 1]
    hands, feet = [np.argmin(x), np.argmax(x)], [np.argmin(y + x), np.argmin(y - x)]
    ends = np.array([*hands, *feet, np.argmax(y)])
    assert np.ptp(body.vertices[:, 1]) > 1.8 * np.ptp(body.vertices[:, 0])
    hues = 360.0 * rgb_to_hsv(point_colors(body.vertices))[ends, 0]
    for one, other in itertools.combinations(hues, 2):
        assert 30.0 < abs(one - other) < 330.0
    left, right = hues[:2]
    assert 60.0 < abs(left - right) < 300.0


def test_colours_of_points_do_not_depend_on_the_size_of_a_shape() -> None:
    colors = point_colors(MESH.vertices)
    stretched = MESH.vertices * [0.01, 3.0, 1.0] - [5.0, 0.0, 1.0]
    np.testing.assert_allclose(point_colors(stretched), colors, atol=1e-9)


@pytest.mark.parametrize("count", [0, 1, 4])
def test_points_on_a_line_have_colours(count: int) -> None:
    """Rounding errors across the line are no direction."""
    places = np.zeros((count, 3))
    places[:, 1] = np.arange(count)
    noise = 1e-12 * np.random.default_rng(1).normal(size=(count, 3))
    assert np.isfinite(point_colors(places)).all()
    np.testing.assert_allclose(point_colors(places + noise), point_colors(places), atol=1e-3)


def test_places_have_colours_of_their_own_that_are_pale() -> None:
    """From the same least to full in each direction; moving and scaling changes none."""
    assert len(np.unique(COLORS, axis=0)) == MESH.n_vertices
    np.testing.assert_allclose(COLORS.max(axis=0), 1.0)
    assert COLORS.min(axis=0) == pytest.approx([COLORS.min()] * 3)
    assert 0.2 < COLORS.min() < 0.5
    np.testing.assert_allclose(colors_by_place(3.0 * MESH.vertices - 7.0), COLORS)


def test_a_flat_shape_has_colours_too() -> None:
    colors = colors_by_place(shapes.plane_grid().vertices)
    assert ((colors > 0.0) & (colors <= 1.0)).all()
    assert np.ptp(colors[:, 2]) == 0.0


def test_a_permutation_permutes_colours() -> None:
    other, where = shapes.permuted(MESH, seed=3)
    found = at_vertices(where.tolist(), list(range(MESH.n_vertices)))
    np.testing.assert_allclose(transferred_colors(COLORS, MESH, other, found)[where], COLORS)


def test_points_between_vertices_have_mixed_colours_and_vertices_without_a_point_are_grey() -> None:
    places = np.array([[0.0, 0, 0], [1.0, 0.1, 0], [2.0, 0, 0], [3.0, 0.1, 0]])
    path = triangle_mesh(places, np.array([[0, 1, 2], [1, 2, 3]]))
    colors = np.array([[0.2, 0.4, 0.6], [0.4, 0.6, 0.8], [1.0, 0.0, 0.5], [0.0, 0.0, 0.0]])
    found = InverseCorrespondence(
        target=(0, 2),
        source=(0, 2),
        faces=((0, 1, 2), (1, 2, 3)),
        barycentric=((0.5, 0.5, 0.0), (0.0, 1.0, 0.0)),
    )
    shown = transferred_colors(colors, path, path, found)
    np.testing.assert_allclose(shown, [[0.3, 0.5, 0.7], GREY, [1.0, 0.0, 0.5], GREY])


def test_a_surface_has_paler_colours_of_the_points_on_it() -> None:
    points = MESH.vertices[::5]
    at_points = surface_colors(MESH.vertices, points)[::5]
    vivid, pale = rgb_to_hsv(point_colors(points)), rgb_to_hsv(at_points)
    np.testing.assert_allclose(pale[:, 0], vivid[:, 0], atol=1e-9)
    assert (pale[:, 1] < 0.6 * vivid[:, 1]).all()


def test_nothing_without_a_partner_looks_mapped() -> None:
    """Neither on a surface, nor on the white paper."""
    colors = surface_colors(MESH.vertices, MESH.vertices)
    assert np.abs(colors - UNMAPPED).max(axis=1).min() > 0.05
    assert UNMAPPED < 0.85


def test_greys_are_those_of_the_page_and_of_the_client() -> None:
    script = (STATIC / "colors.js").read_text()
    levels = {name: float(re.findall(rf"const {name} = ([\d.]+);", script)[0]) for name in LEVELS}
    assert levels == LEVELS
    assert pytest.approx(UNMAPPED, abs=0.02) == match_panels.UNMAPPED
