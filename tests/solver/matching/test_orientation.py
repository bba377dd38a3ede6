"""Orientation-preserving matches: left and right differ by orientation, not intrinsically."""

import numpy as np
import pytest

from solver.arrays import FloatArray, IntArray
from solver.control import Control
from solver.functional_maps import Comparison, find_reflection
from solver.matching import MatchOptions, match
from solver.mesh import signed_areas, triangle_mesh
from solver.shape import Shape
from synthetic import SyntheticShape, correspondence, human
from tests.solver import shapes


@pytest.fixture(scope="module")
def standing() -> SyntheticShape:
    """A symmetric person."""
    return human("standing", resolution=900, seed=1)


def mirrored(figure: SyntheticShape) -> IntArray:
    """The vertex on the other side of the body of each vertex."""
    apart = np.linalg.norm((figure.rest * [-1.0, 1.0, 1.0])[:, None] - figure.rest, axis=2)
    nearest: IntArray = np.argmin(apart, axis=1)
    return nearest


def errors(shape: Shape, found: IntArray, *truths: IntArray) -> list[float]:
    distances = shape.metric("geodesic").distances(found)
    return [float(distances[np.arange(len(found)), truth].mean()) for truth in truths]


@pytest.mark.parametrize(("pose", "seed"), [("walking", 2), ("sitting", 3)])
def test_a_person_is_not_matched_with_her_mirror_image(
    standing: SyntheticShape, pose: str, seed: int
) -> None:
    figure = human(pose, resolution=1000, seed=seed)
    source, target = (Shape(triangle_mesh(one.vertices, one.faces)) for one in (standing, figure))
    truth = correspondence(standing, figure)
    found = match(source, target, MatchOptions(points=24, orientation=True))
    where = found.best.source
    direct, other = errors(target, found.best.target, truth[where], mirrored(figure)[truth][where])
    assert direct < 0.1 < other
    assert found.dense is None
    assert found.levels[-1].energy == pytest.approx(found.best.energy)
    assert found.levels[-1].lower_bound <= found.best.energy


def test_the_winding_of_faces_does_not_matter(standing: SyntheticShape) -> None:
    figure = human("walking", resolution=1000, seed=2)
    source = Shape(triangle_mesh(standing.vertices, standing.faces))
    target, inside_out = (
        Shape(triangle_mesh(figure.vertices, faces))
        for faces in (figure.faces, figure.faces[:, ::-1])
    )
    options = MatchOptions(points=24, orientation=True)
    one, two = (match(source, other, options).best for other in (target, inside_out))
    np.testing.assert_array_equal(one.target, two.target)


def test_a_left_hand_is_matched_with_a_right_one() -> None:
    """What has no symmetry is turned inside out if need be: that preserves far more."""
    mesh = shapes.blob(3)
    reflected = triangle_mesh(mesh.vertices * [-1.0, 1.0, 1.0], mesh.faces)
    options = MatchOptions(points=16, orientation=True)
    found = match(Shape(mesh), Shape(reflected), options).best
    np.testing.assert_array_equal(found.target, found.source)


def test_the_reflection_of_a_person_who_walks(standing: SyntheticShape) -> None:
    figure = human("walking", resolution=1000, seed=2)
    shape = Shape(triangle_mesh(figure.vertices, figure.faces))
    found = find_reflection(shape, Control())
    assert found is not None
    assert found.reverses_orientation
    images = found.images(np.arange(shape.n_vertices))
    assert errors(shape, images, mirrored(figure))[0] < 0.05


def test_orientation_scores_of_known_maps() -> None:
    shape = Shape(shapes.icosphere(3))
    comparison = Comparison(shape, shape)
    places, targets = comparison.source.positions, comparison.target.positions

    def nearest(images: FloatArray) -> IntArray:
        apart = np.linalg.norm(images[:, None] - targets[None], axis=2)
        found: IntArray = np.argmin(apart, axis=1)
        return found

    turned = places[:, [1, 2, 0]]
    assert comparison.orientation_score(nearest(places)) > 0.95
    assert comparison.orientation_score(nearest(turned)) > 0.8
    assert comparison.orientation_score(nearest(places * [1.0, 1.0, -1.0])) < -0.8
    assert comparison.orientation_score(nearest(-places)) < -0.8
    anywhere = np.random.default_rng(0).permutation(len(places))
    assert abs(comparison.orientation_score(anywhere)) < 0.2
    assert comparison.orientation_score(np.zeros(len(places), dtype=np.int64)) == 0.0


def test_signed_areas_are_those_of_the_cross_product() -> None:
    rng = np.random.default_rng(4)
    positions, normals = rng.standard_normal((2, 30, 3))
    a, b, c = rng.integers(30, size=(3, 50))
    across = np.cross(positions[b] - positions[a], positions[c] - positions[a])
    expected = (across * normals[a]).sum(axis=1)
    np.testing.assert_allclose(signed_areas(positions, normals, a, b, c), expected, atol=1e-12)


def test_a_shape_has_the_same_samples_compared_with_itself_or_another() -> None:
    shape, other = (Shape(shapes.blob(3)) for _ in range(2))
    itself, apart = Comparison(shape, shape).source, Comparison(shape, other).source
    for here, there in (
        (itself.positions, apart.positions),
        (itself.normals, apart.normals),
        (itself.embedded, apart.embedded),
        (itself.sampled_signatures, apart.sampled_signatures),
    ):
        np.testing.assert_array_equal(here, there)
