"""Direct matches, the default: left and right differ in space, not intrinsically."""

import numpy as np
import pytest

from solver.arrays import IntArray
from solver.matching import Match, MatchOptions, match
from solver.mesh import triangle_mesh
from solver.shape import Shape
from synthetic import CLASSES, SyntheticShape, articulated, correspondence, human
from tests.solver import shapes


@pytest.fixture(scope="module")
def standing() -> SyntheticShape:
    """A symmetric person."""
    return human("standing", resolution=900, seed=1)


def shape_of(figure: SyntheticShape) -> Shape:
    return Shape(triangle_mesh(figure.vertices, figure.faces))


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
    source, target = shape_of(standing), shape_of(figure)
    truth = correspondence(standing, figure)
    found = match(source, target, MatchOptions(points=24, proof="candidates"))
    where = found.best.source
    direct, other = errors(target, found.best.target, truth[where], mirrored(figure)[truth][where])
    assert direct < 0.1 < other
    assert found.dense is None
    assert found.confidence is not None
    assert found.confidence.probability > 0.5
    assert found.levels[-1].energy == pytest.approx(found.best.energy)
    assert found.levels[-1].lower_bound <= found.best.energy


def test_the_winding_of_faces_does_not_matter(standing: SyntheticShape) -> None:
    figure = human("walking", resolution=1000, seed=2)
    source = shape_of(standing)
    target, inside_out = (
        Shape(triangle_mesh(figure.vertices, faces))
        for faces in (figure.faces, figure.faces[:, ::-1])
    )
    options = MatchOptions(points=24, proof="candidates")
    one, two = (match(source, other, options).best for other in (target, inside_out))
    np.testing.assert_array_equal(one.target, two.target)


@pytest.mark.parametrize("category", CLASSES)
def test_the_plain_answer_is_the_direct_one(category: str) -> None:
    """For each class, between two poses and two triangulations, without any option."""
    poses = list(CLASSES[category].poses)
    one, other = (
        articulated(category, pose, resolution=1000 + 200 * number, seed=number)
        for number, pose in enumerate(poses[:2])
    )
    target = shape_of(other)
    found = match(shape_of(one), target)
    where, truth = found.best.source, correspondence(one, other)
    direct, opposite = errors(
        target, found.best.target, truth[where], mirrored(other)[truth][where]
    )
    assert direct < 0.1 < opposite
    assert found.confidence is not None
    assert 0.0 <= found.confidence.probability <= 1.0


@pytest.fixture(scope="module")
def pair(standing: SyntheticShape) -> tuple[Shape, Shape]:
    return shape_of(standing), shape_of(human("walking", resolution=1100, seed=2))


@pytest.fixture(scope="module")
def plain(pair: tuple[Shape, Shape]) -> Match:
    return match(*pair, MatchOptions(points=16, proof="candidates"))


@pytest.mark.parametrize("asked", [{"dense": True}, {"refine": "gmds"}])
def test_asking_for_more_does_not_change_the_points(
    pair: tuple[Shape, Shape], plain: Match, asked: dict[str, object]
) -> None:
    found = match(*pair, MatchOptions(points=16, proof="candidates", **asked))  # type: ignore[arg-type]
    np.testing.assert_array_equal(found.best.source, plain.best.source)
    np.testing.assert_array_equal(found.best.target, plain.best.target)
    assert found.best.energy == plain.best.energy
    assert found.lower_bound == plain.lower_bound
    assert found.confidence == plain.confidence


def test_points_are_near_the_map_of_all_vertices(pair: tuple[Shape, Shape], plain: Match) -> None:
    dense = match(*pair, MatchOptions(points=16, dense=True, proof="candidates")).dense
    assert dense is not None
    assert dense.hypothesis == 0
    images = dense.target[plain.best.source]
    assert errors(pair[1], plain.best.target, images)[0] < 0.05


def test_without_orientation_nothing_is_registered(pair: tuple[Shape, Shape]) -> None:
    found = match(*pair, MatchOptions(points=16, orientation=False, proof="candidates"))
    assert found.confidence is None
    assert "registration" not in found.timings
    energies = [one.energy for one in (found.best, *found.alternatives)]
    assert energies == sorted(energies)


def test_least_greatest_distortion_is_registered_for_maps_alone(
    pair: tuple[Shape, Shape],
) -> None:
    """Its answer stays that of least distortion."""
    only = match(*pair, MatchOptions(points=6, objective="linf"))
    assert only.confidence is None
    with_map = match(*pair, MatchOptions(points=6, objective="linf", dense=True))
    assert with_map.dense is not None
    assert with_map.confidence is not None
    np.testing.assert_array_equal(with_map.best.target, only.best.target)
    assert with_map.dense.hypothesis <= len(with_map.alternatives)


def test_a_shape_reflected_in_space_is_said_to_be() -> None:
    """Landmarks say so here; the answer then is the mirror image, without a warning."""
    mesh = shapes.blob(2)
    reflected = triangle_mesh(mesh.vertices * [-1.0, 1.0, 1.0], mesh.faces)
    marks = tuple((vertex, vertex) for vertex in (0, 10, 40, 77))
    found = match(
        Shape(mesh), Shape(reflected), MatchOptions(points=16, landmarks=marks, proof="candidates")
    )
    np.testing.assert_array_equal(found.best.target, found.best.source)
    assert not any("reflected" in warning for warning in found.warnings)


def test_a_left_hand_is_matched_with_a_right_one() -> None:
    """What has no symmetry is reflected in space if need be, and the user is warned."""
    mesh = shapes.blob()
    reflected = triangle_mesh(mesh.vertices * [-1.0, 1.0, 1.0], mesh.faces)
    found = match(Shape(mesh), Shape(reflected), MatchOptions(points=16, proof="candidates"))
    np.testing.assert_array_equal(found.best.target, found.best.source)
    assert any("reflected" in warning for warning in found.warnings)
