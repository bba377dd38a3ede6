"""Matches with a prototype that preserve orientation, by registered surfaces of its examples."""

from collections.abc import Callable
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from solver.arrays import FloatArray, IntArray
from solver.control import Control
from solver.errors import MeshError
from solver.matching import Match, MatchOptions
from solver.mesh import triangle_mesh
from solver.prototype import (
    KEPT_VERTICES,
    MOST_FACES,
    MOST_SURFACES,
    MOST_VERTICES,
    ExampleSurface,
    Prototype,
    PrototypeOptions,
    connected_examples,
    example_surfaces,
    learn_prototype,
    match_prototype,
    matched_examples,
    nearest_surfaces,
    prototype_from_bytes,
    prototype_to_bytes,
)
from solver.prototype.learning import is_cycle_consistent
from solver.prototype.matching import map_points
from solver.shape import Shape
from solver.shape.laplacian import Spectrum
from synthetic import CLASSES, SyntheticShape, articulated, correspondence
from tests.solver import shapes

_OPTIONS = PrototypeOptions(points=10, components=1)


def figure(category: str, pose: str, seed: int = 0) -> SyntheticShape:
    return articulated(category, pose, resolution=500 + 50 * seed, seed=seed)


def shape_of(known: SyntheticShape) -> Shape:
    return Shape(triangle_mesh(known.vertices, known.faces))


@cache
def examples(category: str) -> tuple[Shape, ...]:
    """Poses of one figure, triangulated alike, the first of them standing."""
    return tuple(shape_of(figure(category, pose)) for pose in CLASSES[category].poses)


@cache
def prototype(category: str) -> Prototype:
    return learn_prototype(connected_examples(examples(category), _OPTIONS).examples, _OPTIONS)


@cache
def target(category: str, pose: str) -> Shape:
    """Triangulated on its own."""
    return shape_of(figure(category, pose, seed=3))


@cache
def matched(category: str, pose: str) -> Match:
    return match_prototype(prototype(category), target(category, pose))


def mirrored(known: SyntheticShape) -> IntArray:
    """(V,) vertex on the other side of the body of each vertex."""
    apart = np.linalg.norm((known.rest * [-1.0, 1.0, 1.0])[:, None] - known.rest, axis=2)
    nearest: IntArray = np.argmin(apart, axis=1)
    return nearest


def farthest(category: str, pose: str, answer: Match) -> tuple[float, float]:
    """Greatest error of a point, direct and against the mirrored truth."""
    known, other = figure(category, "standing"), figure(category, pose, seed=3)
    truth = correspondence(known, other)
    distances = target(category, pose).metric("geodesic").distances(answer.best.target)
    places = prototype(category).vertices[answer.best.source]
    rows = np.arange(len(places))
    direct, reflected = (
        float(distances[rows, images[places]].max()) for images in (truth, mirrored(other)[truth])
    )
    return direct, reflected


@pytest.mark.parametrize(
    ("category", "pose"),
    [("human", "walking"), ("horse", "galloping")],
)
def test_matches_preserve_orientation_and_do_not_cross_legs(category: str, pose: str) -> None:
    answer = matched(category, pose)
    direct, reflected = farthest(category, pose, answer)
    assert direct < 0.5 < reflected
    assert answer.levels[0].lower_bound <= answer.best.energy + 1e-9
    assert sorted(answer.best.source.tolist()) == list(range(10))
    assert not any("distinguished" in warning for warning in answer.warnings)


def test_matched_examples_do_not_cross_legs() -> None:
    """And points are sampled as the options say."""
    horses = examples("horse")[:3]
    options = PrototypeOptions(points=10, components=1, sampling=("geodesic",))
    found = matched_examples(horses, options)
    own = horses[0].sampling("geodesic", 10).indices
    assert found.kept == tuple(range(len(horses)))
    np.testing.assert_array_equal(found.examples[0].vertices, own)
    for example in found.examples:
        distances = example.shape.metric("geodesic").distances(example.vertices)
        assert distances[np.arange(10), own].max() < 0.5


def test_two_matched_examples_are_oriented() -> None:
    """Nothing overrules a match of two that is wrong."""
    first, other = examples("horse")[0], target("horse", "galloping")
    found = matched_examples([first, other], _OPTIONS)
    assert found.kept == (0, 1)
    assert found.warnings == ()
    assert all(example.oriented for example in found.examples)
    own, theirs = (example.vertices for example in found.examples)
    truth = correspondence(figure("horse", "standing"), figure("horse", "galloping", seed=3))
    distances = other.metric("geodesic").distances(theirs)
    assert distances[np.arange(10), truth[own]].max() < 0.5 * other.size


def test_an_unreached_one_of_few_examples_is_left_out() -> None:
    stranger, horse = Shape(shapes.blob(2)), examples("horse")[0]
    found = matched_examples([stranger, horse], _OPTIONS, reference=1)
    assert found.kept == (1,)
    (warning,) = found.warnings
    assert warning == f"shapes.0: left out, for {found.left_out[0]}"
    assert "cycle-consistent" in warning
    tiny = matched_examples([horse, Shape(shapes.icosphere(1))], _OPTIONS)
    assert tiny.kept == (0,)


def test_examples_without_surfaces_are_matched() -> None:
    """Of so few vertices no map is made, so none says that they do not correspond."""
    one, other = Shape(shapes.blob(1)), Shape(shapes.blob(1))
    found = matched_examples([one, other], _OPTIONS)
    assert found.kept == (0, 1)
    assert [example.oriented for example in found.examples] == [True, False]


def test_correct_points_are_cycle_consistent_and_mirrored_ones_are_not() -> None:
    start, end = examples("horse")[0], target("horse", "galloping")
    goal = figure("horse", "galloping", seed=3)
    own = prototype("horse").vertices
    truth = correspondence(figure("horse", "standing"), goal)
    right, wrong = truth[own], mirrored(goal)[truth][own]
    assert is_cycle_consistent((start, own), (end, right), Control())
    assert is_cycle_consistent((start, own), (end, wrong), Control()) is False
    assert (
        is_cycle_consistent((start, own), (Shape(shapes.icosphere(1)), own % 42), Control()) is None
    )


def test_only_oriented_examples_keep_surfaces() -> None:
    known = connected_examples(examples("cat")[:3], _OPTIONS).examples
    one, two, three = known
    learned = learn_prototype([one, replace(two, oriented=False), three], _OPTIONS)
    assert learned.examples == 3
    assert len(learned.surfaces) == 2
    assert not np.array_equal(learned.surfaces[0].eigenvalues, learned.surfaces[1].eigenvalues)


def test_the_answer_is_the_most_likely_hypothesis_that_agrees_with_the_surface() -> None:
    """Unless the most likely hypotheses are wrong, the answer is one of them."""
    plain = MatchOptions(points=10, orientation=False)
    usual = match_prototype(prototype("human"), target("human", "walking"), plain)
    oriented = matched("human", "walking")
    assert oriented.best.energy >= usual.best.energy
    offered = [one.energy for one in (usual.best, *usual.alternatives)]
    assert min(abs(oriented.best.energy - one) for one in offered) < 1e-9


def test_a_shape_unlike_all_examples_is_matched_as_without_surfaces() -> None:
    stranger = Shape(shapes.blob(2))
    learned = replace(prototype("human"), surfaces=prototype("human").surfaces[:1])
    few = MatchOptions(points=8, coarse_points=7, alternatives=2)
    answer = match_prototype(learned, stranger, few)
    without = match_prototype(learned, stranger, replace(few, orientation=False))
    assert answer.best.energy == pytest.approx(without.best.energy)
    np.testing.assert_array_equal(answer.best.target, without.best.target)
    assert any("distinguished" in warning for warning in answer.warnings)


def test_points_of_one_surface_are_mapped_directly() -> None:
    """Without hypotheses of the prototype, and to another triangulation."""
    known = figure("horse", "standing")
    surface = prototype("horse").surfaces[0]
    goal = target("horse", "galloping")
    found = map_points([surface], goal, [], Control())
    assert found is not None
    truth = correspondence(known, figure("horse", "galloping", seed=3))
    expected = truth[prototype("horse").vertices]
    distances = goal.metric("geodesic").distances(found.vertices)
    assert distances[np.arange(len(expected)), expected].max() < 0.5
    assert found.confidence.is_likely
    assert found.surface is surface


def test_cached_spectra_of_surfaces_change_no_answer() -> None:
    """They are asked for once, of the surfaces that are tried."""
    archive, goal = prototype_to_bytes(prototype("horse")), target("horse", "galloping")
    usual = matched("horse", "galloping")
    kept: dict[bytes, Spectrum] = {}
    asked: list[ExampleSurface] = []

    def spectrum(surface: ExampleSurface, compute: Callable[[], Spectrum]) -> Spectrum:
        asked.append(surface)
        name = surface.vertices.tobytes()
        if name not in kept:
            kept[name] = compute()
        return kept[name]

    for times in 1, 2:
        learned = prototype_from_bytes(archive)
        asked.clear()
        for _ in range(times):
            answer = match_prototype(learned, goal, surface_spectra=spectrum)
            assert answer.best.energy == pytest.approx(usual.best.energy)
            np.testing.assert_array_equal(answer.best.target, usual.best.target)
        assert asked == nearest_surfaces(learned.surfaces, goal, len(asked))
        assert len(asked) == len(kept) > 0


def test_an_archive_without_surfaces_is_matched_without_orientation() -> None:
    old = prototype_from_bytes(prototype_to_bytes(replace(prototype("cat"), surfaces=())))
    assert old.surfaces == ()
    goal = target("cat", "turning")
    plain = match_prototype(old, goal, MatchOptions(orientation=False))
    np.testing.assert_array_equal(match_prototype(old, goal).best.target, plain.best.target)


def test_an_archive_holds_the_surfaces() -> None:
    learned = prototype("cat")
    again = prototype_from_bytes(prototype_to_bytes(learned))
    assert len(learned.surfaces) == len(again.surfaces) == len(examples("cat"))
    for one, other in zip(learned.surfaces, again.surfaces, strict=True):
        for name in ("vertices", "faces", "points", "eigenvalues"):
            np.testing.assert_array_equal(getattr(one, name), getattr(other, name))


def test_surfaces_are_simplified_around_the_points() -> None:
    known = articulated("dog", "standing", resolution=1700)
    shape = shape_of(known)
    points = shape.sampling("geodesic", 12).indices
    (surface,) = example_surfaces([shape], [points], Control())
    mesh = surface.mesh()
    assert mesh.n_vertices == KEPT_VERTICES < shape.n_vertices
    places = shape.mesh.vertices[points]
    apart = surface.vertices[surface.points] + places.mean(axis=0) - places
    assert np.abs(apart).max() < 0.05 * np.sqrt(shape.mesh.area)
    assert mesh.area == pytest.approx(shape.mesh.area, rel=0.05)


def test_a_surface_too_large_for_an_archive_is_not_kept() -> None:
    """One of 1331 vertices in a lattice, whose squares are all there."""
    numbers = np.arange(11**3).reshape(11, 11, 11)
    squares = [
        np.stack([layer[:-1, :-1], layer[1:, :-1], layer[1:, 1:], layer[:-1, 1:]], axis=-1)
        for layers in (numbers, numbers.transpose(1, 2, 0), numbers.transpose(2, 0, 1))
        for layer in layers
    ]
    corners = np.concatenate(squares).reshape(-1, 4)
    faces = np.concatenate([corners[:, [0, 1, 2]], corners[:, [0, 2, 3]]])
    places = np.stack(np.unravel_index(numbers.reshape(-1), numbers.shape), axis=1)
    shape = Shape(triangle_mesh(places * [1.0, 1.1, 1.3], faces))
    assert shape.n_vertices < MOST_VERTICES
    assert shape.mesh.n_faces > MOST_FACES
    points = shape.sampling("geodesic", 10).indices
    assert example_surfaces([shape], [points], Control()) == ()


def balls(count: int) -> list[Shape]:
    """Spheres, stretched more and more."""
    mesh = shapes.icosphere(2)
    stretches = np.linspace(1.0, 2.0, count)
    return [
        Shape(triangle_mesh(mesh.vertices * [1.0, 1.0 + stretch, stretch], mesh.faces))
        for stretch in stretches
    ]


def test_the_most_different_surfaces_are_kept_whatever_their_order() -> None:
    points: IntArray = np.arange(5)
    several = balls(MOST_SURFACES + 3)
    kept = example_surfaces(several, [points] * len(several), Control())
    assert len(kept) == MOST_SURFACES
    turned = [several[0], *several[:0:-1]]
    again = example_surfaces(turned, [points] * len(several), Control())
    np.testing.assert_array_equal(_described(kept), _described(again))
    # The second is the most different from the first: the one stretched most.
    np.testing.assert_allclose(kept[1].eigenvalues, several[-1].spectrum(20).eigenvalues[1:])
    assert nearest_surfaces(kept, several[-1], 2)[0] is kept[1]


def _described(surfaces: tuple[ExampleSurface, ...]) -> FloatArray:
    return np.array([one.eigenvalues for one in surfaces])


def test_unsound_surfaces_are_refused() -> None:
    surface = prototype("cat").surfaces[0]
    for faces in (surface.faces[:3], np.repeat(surface.faces, 2, axis=0)):
        with pytest.raises(MeshError, match="not sound"):
            replace(surface, faces=faces).mesh()
    small = shapes.icosphere(1)
    with pytest.raises(MeshError, match="fewer than"):
        ExampleSurface(small.vertices, small.faces, np.arange(3), np.ones(19)).mesh()


def test_an_oriented_answer_is_certified_only_if_it_is_the_optimum() -> None:
    """Of a single level the certificate is of the answer, not of what is more likely."""
    for pose in "standing", "galloping":
        found = matched("horse", pose)
        (level,) = found.levels
        assert level.energy == found.best.energy
        assert level.lower_bound <= found.best.energy
        most_likely = min([found.best, *found.alternatives], key=lambda one: one.energy)
        assert found.certified == (most_likely is found.best) == (level.rank == 1)
