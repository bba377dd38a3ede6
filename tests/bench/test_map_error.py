"""Errors of images on a surface, against distances known in closed form."""

from dataclasses import replace

import numpy as np
import pytest

from bench.collection import KnownShape
from bench.map_error import WITHIN, error_figures, image_error, known_points
from bench.surface_error import better_errors, truths_of
from solver.gmds import SurfacePoints
from solver.mesh import triangle_mesh
from solver.shape import Shape

OCTAHEDRON = triangle_mesh(
    np.array([[1.0, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]]),
    np.array(
        [[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]]
    ),
)
EDGE = np.sqrt(2.0) / np.sqrt(8 * np.sqrt(3.0) / 2)
"""Length of an edge over √area."""


def known(truth: list[int], symmetric_truth: list[int] | None = None) -> KnownShape:
    symmetric = None if symmetric_truth is None else np.array(symmetric_truth)
    return KnownShape("one", "one", Shape(OCTAHEDRON), np.array(truth), symmetric)


def test_true_images_have_no_error() -> None:
    target, truth = known([0, 2, 4]), np.array([0, 2, 4])
    corners = np.tile([0, 2, 4], (3, 1))
    error = image_error(target, corners, np.eye(3), truth, [truth])
    assert error.direct == error.at_vertices == error.better == 0.0
    assert error.within == (1.0,) * len(WITHIN)
    assert error.right
    assert not error.mirrored


def test_images_between_vertices_are_measured_where_they_are() -> None:
    corners = np.tile([0, 2, 4], (2, 1))
    barycentric = np.array([[0.5, 0.5, 0.0], [1 / 3, 1 / 3, 1 / 3]])
    truth = np.array([0, 0])
    error = image_error(known([0, 0]), corners, barycentric, np.array([2, 0]), [truth])
    # Half an edge; the centroid of an equilateral triangle; at vertices, an edge and nothing.
    assert error.direct == pytest.approx(EDGE * (1 / 2 + 1 / np.sqrt(3.0)) / 2)
    assert error.at_vertices == pytest.approx(EDGE / 2)


def test_an_answer_at_the_mirror_image_is_mirrored() -> None:
    corners, images = np.array([[0, 2, 4]]), np.array([0])
    error = image_error(
        known([1], [0]), corners, np.array([[1.0, 0, 0]]), images, [np.array([1]), images]
    )
    assert error.better == 0.0
    assert error.direct >= EDGE
    assert error.mirrored
    assert not error.right


def test_points_that_a_shape_lacks_are_left_out() -> None:
    source, target = known([0, -1, 2, 3]), known([5, 4, -1, 2], [4, 5, 1, 3])
    vertices, (direct, mirrored) = known_points(source, target)
    assert vertices.tolist() == [0, 3]
    assert direct.tolist() == [5, 2]
    assert mirrored.tolist() == [4, 3]


def test_vertices_whose_partner_is_lacking_are_left_out() -> None:
    source, target = known([-1, 0, 2, 5]), known([5, 4, -1, 2], [4, 1, 0, 3])
    kept, (direct, mirrored) = truths_of(source, target, np.array([0, 2, 5]))
    assert kept.tolist() == [True, False, True]
    assert direct.tolist() == [4, 2]
    assert mirrored.tolist() == [1, 3]
    points = SurfacePoints.at_vertices(OCTAHEDRON, np.array([4, 2, 2]))
    shown, errors = better_errors(source, target, np.array([0, 2, 5]), points)
    assert shown.tolist() == kept.tolist()
    assert errors.tolist() == [0.0, 0.0]


def test_figures_average_over_pairs() -> None:
    corners, images, truth = np.array([[0, 2, 4]]), np.array([0]), np.array([0])
    right = image_error(known([0]), corners, np.array([[1.0, 0, 0]]), images, [truth])
    wrong = replace(right, direct=0.3, better=0.05, within=(0.0, 0.5, 1.0))
    figures = error_figures([right, wrong, wrong])
    assert figures["pairs"] == 3
    assert figures["direct"] == pytest.approx(0.2)
    assert figures["median_direct"] == 0.3
    assert figures["direct_over_0_1"] == pytest.approx(2 / 3)
    assert figures["share_over_0_1"] == 0.0
    assert figures["mirrored"] == pytest.approx(2 / 3)
    assert figures["within_0_10"] == pytest.approx(2 / 3)
