"""Dense maps of shapes whose correspondence is known."""

from dataclasses import replace

import numpy as np
import pytest

from solver.arrays import IntArray
from solver.control import Control
from solver.errors import Cancelled
from solver.functional_maps import (
    Comparison,
    approximate_nearest_points,
    drop_similar_maps,
    extend_hypotheses,
    nearest_points,
)
from solver.matching import MatchOptions, match
from solver.mesh import triangle_mesh
from solver.shape import Shape
from synthetic import ASYMMETRIC_HUMAN, SyntheticShape, correspondence, human
from tests.solver import shapes
from tests.solver.functional_maps.maps import dense_map

Points = tuple[IntArray, IntArray]


@pytest.fixture(scope="module")
def figures() -> tuple[SyntheticShape, SyntheticShape]:
    return (
        human("standing", ASYMMETRIC_HUMAN, resolution=1200, seed=1),
        human("walking", ASYMMETRIC_HUMAN, resolution=1300, seed=2),
    )


@pytest.fixture(scope="module")
def pair(figures: tuple[SyntheticShape, SyntheticShape]) -> tuple[Shape, Shape]:
    source, target = (Shape(triangle_mesh(figure.vertices, figure.faces)) for figure in figures)
    return source, target


@pytest.fixture(scope="module")
def truth(figures: tuple[SyntheticShape, SyntheticShape]) -> IntArray:
    return correspondence(*figures)


def mean_error(pair: tuple[Shape, Shape], found: IntArray, truth: IntArray) -> float:
    distances = pair[1].metric("geodesic").distances(found)
    return float(distances[np.arange(len(found)), truth].mean())


def test_a_few_points_extend_to_all(pair: tuple[Shape, Shape], truth: IntArray) -> None:
    """Another pose and triangulation: as close as vertices lie to one another."""
    few = pair[0].sampling("geodesic", 24).indices
    found = dense_map(*pair, [(few, truth[few])])
    everywhere = np.arange(pair[0].n_vertices)
    spacing = 1.0 / np.sqrt(pair[1].n_vertices)
    assert mean_error(pair, found.images(everywhere), truth) < 1.2 * spacing


def test_the_right_hypothesis_is_chosen(pair: tuple[Shape, Shape], truth: IntArray) -> None:
    """Against its mirror image, which the proportions of this figure give away, and nonsense."""
    few = pair[0].sampling("geodesic", 24).indices
    mirrored = pair[0].surface.vertices[few] * [-1.0, 1.0, 1.0]
    others = np.argmin(np.linalg.norm(mirrored[:, None] - pair[0].surface.vertices, axis=2), axis=1)
    nonsense = np.random.default_rng(0).permutation(truth[few])
    hypotheses: list[Points] = [(few, truth[others]), (few, nonsense), (few, truth[few])]
    assert dense_map(*pair, hypotheses).hypothesis == 2


def test_points_wrong_in_part_are_corrected(pair: tuple[Shape, Shape], truth: IntArray) -> None:
    """All but the first ones lead astray: the first ones and the signatures decide."""
    few = pair[0].sampling("geodesic", 32).indices
    partners = truth[few].copy()
    partners[8:] = np.random.default_rng(1).permutation(partners[8:])
    found = dense_map(*pair, [(few, partners)])
    assert mean_error(pair, found.images(few), truth[few]) < 0.04
    assert mean_error(pair, partners, truth[few]) > 0.3


def test_similar_maps_are_dropped(pair: tuple[Shape, Shape], truth: IntArray) -> None:
    few = pair[0].sampling("geodesic", 24).indices
    nonsense = np.random.default_rng(0).permutation(truth[few])
    comparison = Comparison(*pair)
    right, other = (
        extend_hypotheses(comparison, [(few, partners)], Control())
        for partners in (truth[few], nonsense)
    )
    assert len(right) == 3
    assert len(drop_similar_maps([*right, *right], 9)) == 1
    assert len(drop_similar_maps([*right, *other], 9)) > 1
    assert drop_similar_maps([*right, *other], 1) == right[:1]


def test_quality_score_falls_with_the_clarity_of_orientation(
    pair: tuple[Shape, Shape], truth: IntArray
) -> None:
    few = pair[0].sampling("geodesic", 24).indices
    found = dense_map(*pair, [(few, truth[few])])
    mixed = replace(found, orientation_score=found.orientation_score / 4.0)
    assert mixed.quality_score == pytest.approx(found.quality_score / 4.0)
    mirrored = replace(found, orientation_score=-found.orientation_score)
    assert mirrored.quality_score == found.quality_score
    assert replace(found, orientation_score=0.0).quality_score > 0.0
    assert replace(found, chord_change=0.0).quality_score == np.inf


def test_scale_changes_nothing(figures: tuple[SyntheticShape, SyntheticShape]) -> None:
    source, target = figures
    few = np.arange(0, len(source.vertices), 60)
    truth = correspondence(source, target)[few]
    images = []
    for factor in (1.0, 1e3):
        pair = (
            Shape(triangle_mesh(source.vertices, source.faces), normalise=False),
            Shape(triangle_mesh(target.vertices * factor, target.faces), normalise=False),
        )
        images.append(dense_map(*pair, [(few, truth)]).images(few))
    np.testing.assert_array_equal(images[0], images[1])


def test_small_meshes_are_mapped_too() -> None:
    """With fewer eigenpairs and vertices than are asked for."""
    sphere = Shape(shapes.blob(1))
    points = np.arange(sphere.n_vertices)
    found = dense_map(sphere, sphere, [(points, points)])
    np.testing.assert_array_equal(found.images(points), points)


def test_an_extension_can_be_cancelled(pair: tuple[Shape, Shape], truth: IntArray) -> None:
    with pytest.raises(Cancelled):
        dense_map(*pair, [(np.arange(9), truth[:9])], Control(is_cancelled=lambda: True))


def test_an_extension_needs_a_hypothesis_of_three_points(pair: tuple[Shape, Shape]) -> None:
    with pytest.raises(ValueError, match="three points"):
        extend_hypotheses(Comparison(*pair), [], Control())


def test_a_match_is_extended_to_all_vertices(pair: tuple[Shape, Shape], truth: IntArray) -> None:
    found = match(*pair, MatchOptions(points=24, dense=True))
    assert found.dense is not None
    np.testing.assert_array_equal(found.dense.source, np.arange(pair[0].n_vertices))
    assert mean_error(pair, found.dense.target, truth) < 1.5 / np.sqrt(pair[1].n_vertices)
    assert 0 <= found.dense.hypothesis <= len(found.alternatives)


def test_a_dense_map_names_the_users_vertices() -> None:
    """Those that repair has merged too, and none that belong to no face."""
    mesh = shapes.blob(2)
    other, where = shapes.permuted(mesh, seed=8)
    seam, lonely = mesh.n_vertices, mesh.n_vertices + 1
    vertices = np.concatenate([mesh.vertices, mesh.vertices[:1], [[9.0, 9.0, 9.0]]])
    faces = mesh.faces.copy()
    row, corner = np.argwhere(faces == 0)[0]
    faces[row, corner] = seam
    seamed = Shape(triangle_mesh(vertices, faces))
    found = match(seamed, Shape(other), MatchOptions(points=16, dense=True)).dense
    assert found is not None
    assert found.source.tolist() == list(range(lonely))
    np.testing.assert_array_equal(found.target, [*where, where[0]])


def test_too_few_points_for_a_dense_map() -> None:
    shape = Shape(shapes.blob(2))
    found = match(
        shape,
        Shape(shapes.icosphere(2)),
        MatchOptions(
            points=3, coarse_points=3, occlusion_cost=1e-9, dense=True, metric=("geodesic",)
        ),
    )
    assert len(found.best.source) < 3
    assert found.dense is None
    assert any("too few points" in warning for warning in found.warnings)


def test_in_single_precision_nearest_points_are_as_near() -> None:
    functions = Shape(shapes.blob(4)).spectrum(40).eigenfunctions
    images, points = functions[::2], functions[1::2]
    single = nearest_points(images.astype(np.float32), points.astype(np.float32))
    squares = ((images[:, None] - points[None]) ** 2).sum(axis=2)
    found = [
        squares[np.arange(len(images)), one] for one in (nearest_points(images, points), single)
    ]
    np.testing.assert_allclose(found[0], squares.min(axis=1))
    np.testing.assert_allclose(found[1], found[0], atol=1e-4)


def test_approximate_nearest_points_are_nearly_the_nearest() -> None:
    """Of a surface embedded in many dimensions, by its first eigenfunctions."""
    functions = Shape(shapes.blob(4)).spectrum(40).eigenfunctions
    images, points = functions[::2], functions[1::2]
    exact, quick = nearest_points(images, points), approximate_nearest_points(images, points, 60)
    off = [np.linalg.norm(images - points[found], axis=1) for found in (exact, quick)]
    assert (off[0] <= off[1]).all()
    assert np.mean(exact == quick) > 0.9
    assert off[1].mean() < 1.05 * off[0].mean()
    np.testing.assert_array_equal(
        approximate_nearest_points(points, points, 60), np.arange(len(points))
    )
