"""Selection of the map that extends a match: of a hypothesis, or of its mirror image."""

import numpy as np
import pytest

from solver.arrays import IntArray
from solver.control import Control
from solver.functional_maps import (
    Comparison,
    compose_maps,
    dense_correspondence,
    find_reflection,
    select_map,
)
from solver.mesh import TriangleMesh, triangle_mesh
from solver.shape import Shape
from synthetic import SyntheticShape, correspondence, human
from tests.solver import shapes
from tests.solver.matching.test_orientation import errors, mirrored

Hypothesis = tuple[IntArray, IntArray]


@pytest.fixture(scope="module")
def figures() -> tuple[SyntheticShape, SyntheticShape]:
    """A symmetric person in two poses, each triangulated on its own."""
    return human("standing", resolution=800, seed=1), human("walking", resolution=900, seed=2)


@pytest.fixture(scope="module")
def pair(figures: tuple[SyntheticShape, SyntheticShape]) -> tuple[Shape, Shape]:
    source, target = (Shape(triangle_mesh(one.vertices, one.faces)) for one in figures)
    return source, target


@pytest.fixture(scope="module")
def right(figures: tuple[SyntheticShape, SyntheticShape], pair: tuple[Shape, Shape]) -> Hypothesis:
    few = pair[0].sampling("geodesic", 16).indices
    return few, correspondence(*figures)[few]


@pytest.fixture(scope="module")
def wrong(figures: tuple[SyntheticShape, SyntheticShape], right: Hypothesis) -> Hypothesis:
    """The mirror image of what is right."""
    return right[0], mirrored(figures[1])[right[1]]


def test_the_orientation_preserving_hypothesis_is_selected(
    pair: tuple[Shape, Shape], right: Hypothesis, wrong: Hypothesis
) -> None:
    for hypotheses, expected in (([right, wrong], 0), ([wrong, right], 1)):
        found = select_map(*pair, hypotheses, Control())
        assert found is not None
        assert found.hypothesis == expected
        assert found.preserves_orientation


def test_hypotheses_of_too_few_points_are_skipped_and_keep_their_numbers(
    pair: tuple[Shape, Shape], right: Hypothesis, wrong: Hypothesis
) -> None:
    little = right[0][:2], right[1][:2]
    found = select_map(*pair, [wrong, little, right], Control())
    assert found is not None
    assert found.hypothesis == 2
    assert select_map(*pair, [little, right], Control()) is None


def test_a_mirror_image_alone_is_reflected(
    figures: tuple[SyntheticShape, SyntheticShape],
    pair: tuple[Shape, Shape],
    right: Hypothesis,
    wrong: Hypothesis,
) -> None:
    found = select_map(*pair, [wrong], Control())
    assert found is not None
    assert found.hypothesis == 1
    images = found.images(right[0])
    assert errors(pair[1], images, right[1])[0] < 0.1 < errors(pair[1], images, wrong[1])[0]


def test_without_further_maps_nothing_is_reflected(
    pair: tuple[Shape, Shape], right: Hypothesis, wrong: Hypothesis
) -> None:
    found = select_map(*pair, [wrong], Control(), further=False)
    assert found is not None
    assert found.hypothesis == 0
    assert found.reverses_orientation
    assert errors(pair[1], found.images(wrong[0]), wrong[1])[0] < 0.1


def test_all_vertices_have_an_image(pair: tuple[Shape, Shape], right: Hypothesis) -> None:
    found = select_map(*pair, [right], Control())
    assert found is not None
    everywhere = np.arange(pair[0].n_vertices)
    dense = dense_correspondence(found)
    np.testing.assert_array_equal(dense.source, everywhere)
    np.testing.assert_array_equal(dense.target, found.images(everywhere))


def test_reflecting_twice_changes_little(pair: tuple[Shape, Shape]) -> None:
    found = find_reflection(pair[0], Control())
    assert found is not None
    everywhere = np.arange(pair[0].n_vertices)
    twice = found.images(found.images(everywhere))
    assert errors(pair[0], twice, everywhere)[0] < 1.5 / np.sqrt(pair[0].n_vertices)


@pytest.mark.parametrize("mesh", [shapes.tetrahedron(), shapes.icosphere(1)], ids=["4", "42"])
def test_the_reflection_of_a_symmetric_mesh_is_one_in_space(mesh: TriangleMesh) -> None:
    """An orthogonal matrix of determinant -1; with four vertices, one of few eigenfunctions."""
    found = find_reflection(Shape(mesh), Control())
    assert found is not None
    images = found.images(np.arange(mesh.n_vertices))
    places = mesh.vertices - mesh.vertices.mean(axis=0)
    matrix = np.linalg.lstsq(places, places[images])[0]
    np.testing.assert_allclose(places @ matrix, places[images], atol=1e-6)
    np.testing.assert_allclose(matrix @ matrix.T, np.eye(3), atol=1e-6)
    assert np.linalg.det(matrix) < 0.0


def test_a_target_of_a_dozen_vertices_has_a_map() -> None:
    """It has fewer eigenfunctions than other maps begin with."""
    source, target = Shape(shapes.blob(3)), Shape(shapes.icosphere(0))
    points = source.sampling("geodesic", 8).indices, target.sampling("geodesic", 8).indices
    found = select_map(source, target, [points], Control())
    assert found is not None
    assert found.functional_map.size <= target.n_vertices
    images = found.images(np.arange(source.n_vertices))
    assert set(images.tolist()) <= set(range(target.n_vertices))


def test_a_reflection_composed_with_itself_leaves_everything_in_place(
    pair: tuple[Shape, Shape],
) -> None:
    """Whatever number of eigenfunctions they are composed in."""
    comparison = Comparison(pair[0], pair[0])
    mirror = find_reflection(pair[0], Control())
    assert mirror is not None
    everywhere = np.arange(pair[0].n_vertices)
    several = list(compose_maps(comparison, mirror, mirror, Control(), hypothesis=5))
    assert {one.hypothesis for one in several} == {5}
    for one in several:
        assert one.preserves_orientation
        assert errors(pair[0], one.images(everywhere), everywhere)[0] < 0.05
    assert not list(compose_maps(comparison, mirror, mirror, Control(deadline=0.0)))
