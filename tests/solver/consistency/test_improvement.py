"""Maps of a collection improved by one another: four poses of a figure, whose truth is known."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial import KDTree

from solver.arrays import IntArray
from solver.consistency import Consistency, images_of, improve
from solver.mesh import triangle_mesh
from solver.registration import DenseCorrespondence
from solver.shape import Shape
from synthetic import CLASSES, articulated, correspondence
from tests.solver.shapes import icosphere

Pair = tuple[int, int]


@pytest.fixture(scope="module")
def figures() -> tuple[list[Shape], dict[Pair, IntArray], IntArray]:
    """Shapes, the true maps between them, and the map of shape 0 that exchanges its sides."""
    poses = CLASSES["human"].poses
    made = [articulated("human", pose, 600, seed) for seed, pose in enumerate(poses)]
    shapes = [Shape(triangle_mesh(one.vertices, one.faces)) for one in made]
    images = {
        (i, j): correspondence(made[i], made[j])
        for i in range(len(made))
        for j in range(len(made))
        if i != j
    }
    mirrored: IntArray = np.asarray(
        KDTree(made[0].rest).query(made[0].rest * np.array([-1.0, 1.0, 1.0]))[1]
    )
    return shapes, images, mirrored


def error(shapes: list[Shape], images: IntArray, truth: IntArray, place: int) -> float:
    """Mean distance in space over √area."""
    positions = shapes[place].mesh.vertices
    apart = np.linalg.norm(positions[images] - positions[truth], axis=1)
    return float(apart.mean() / shapes[place].size)


def improved(
    shapes: list[Shape], images: dict[Pair, IntArray], doubted: dict[Pair, float]
) -> Consistency:
    pairs = [pair for pair in images if pair[0] < pair[1]]
    return improve(shapes, images, dict.fromkeys(pairs, 0.95) | doubted)


def test_a_map_that_exchanges_the_sides_is_put_right(
    figures: tuple[list[Shape], dict[Pair, IntArray], IntArray],
) -> None:
    shapes, truth, mirrored = figures
    wrong = dict(truth)
    wrong[0, 1] = truth[0, 1][mirrored]
    wrong[1, 0] = mirrored[truth[1, 0]]
    assert error(shapes, wrong[0, 1], truth[0, 1], 1) > 0.1
    found = improved(shapes, wrong, {(0, 1): 0.2})
    assert set(found.improved) == {(0, 1)}
    assert found.improved[0, 1].path in {(0, 2, 1), (0, 3, 1)}
    assert found.improved[0, 1].score < found.improved[0, 1].direct_score
    assert error(shapes, found.maps.images[0, 1], truth[0, 1], 1) < 0.05
    assert error(shapes, found.maps.images[1, 0], truth[1, 0], 0) < 0.05
    before, after = found.before.of_pair((0, 1)), found.after.of_pair((0, 1))
    assert before is not None
    assert after is not None
    assert before > 0.1 > after
    assert found.doubtful_shapes() == ()
    for pair, images in truth.items():
        if pair not in ((0, 1), (1, 0)):
            assert found.maps.images[pair] is images


def uneven(seed: int) -> Shape:
    """An ellipsoid with waves that are different from shape to shape."""
    sphere = icosphere(3)
    waves = np.cos(3.0 * sphere.vertices @ np.random.default_rng(seed).normal(size=(3, 4)))
    heights = 1.0 + 1.5 * waves.mean(axis=1)
    return Shape(triangle_mesh(sphere.vertices * heights[:, None] * [1.0, 1.4, 2.0], sphere.faces))


def test_a_map_is_not_in_doubt_where_those_of_its_path_are_sure() -> None:
    """By their surfaces alone the shapes hardly fit one another."""
    shapes, sphere = [uneven(seed) for seed in range(3)], icosphere(3).vertices
    same = np.arange(len(sphere))
    turned: IntArray = np.asarray(KDTree(sphere).query(sphere * [-1.0, -1.0, 1.0])[1])
    pairs = [(0, 1), (1, 0), (0, 2), (2, 0), (1, 2), (2, 1)]
    maps = dict.fromkeys(pairs, same) | {(0, 1): turned, (1, 0): np.argsort(turned)}
    confidence = improved(shapes, maps, {(0, 1): 0.2}).improved[0, 1].confidence
    assert confidence.probability == pytest.approx(0.95**2)
    assert confidence.reasons == ()


def test_maps_that_are_sure_stay_as_they_are(
    figures: tuple[list[Shape], dict[Pair, IntArray], IntArray],
) -> None:
    shapes, truth, _ = figures
    found = improved(shapes, truth, {})
    assert found.improved == {}
    assert found.maps.images is truth
    assert found.before.triples == found.after.triples
    assert found.doubtful_pairs() == ()


def test_what_does_not_fit_is_named(
    figures: tuple[list[Shape], dict[Pair, IntArray], IntArray],
) -> None:
    shapes, truth, mirrored = figures
    wrong = dict(truth)
    for place in (1, 2, 3):
        # Shape 0 seems to be another: its maps contradict one another, and are all as probable.
        order = np.roll(np.arange(len(mirrored)), 150 * place)
        wrong[0, place] = truth[0, place][order]
        wrong[place, 0] = np.argsort(order)[truth[place, 0]]
    found = improved(shapes, wrong, {})
    assert found.improved == {}
    assert 0 in found.doubtful_shapes()
    assert found.doubtful_pairs()[:3] == ((0, 1), (0, 2), (0, 3))


def test_a_map_that_leaves_vertices_out_is_refused() -> None:
    """As maps of parts do: a composition would lead nowhere."""
    shape = Shape(icosphere(1))
    count = shape.n_vertices
    faces, corners = np.zeros((count, 3), dtype=np.int64), np.full((count, 3), 1.0 / 3.0)
    order = np.roll(np.arange(count), 7)
    back = DenseCorrespondence(np.arange(count), np.argsort(order), faces, corners)
    whole = DenseCorrespondence(np.arange(count), order, faces, corners, inverse=back)
    for known, expected in zip(images_of(whole, shape, shape), (order, back.target), strict=True):
        np.testing.assert_array_equal(known, expected)
    part = replace(whole, source=np.arange(3, count), target=order[3:])
    for one in (part, replace(whole, inverse=part)):
        with pytest.raises(ValueError, match=f"leaves out 3 of {count} vertices"):
            images_of(one, shape, shape)
