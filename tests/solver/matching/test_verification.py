"""Verification of hypotheses by samples that were not matched."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from solver.arrays import FloatArray, IntArray
from solver.control import Control
from solver.labelling import UNMATCHED, Method, Solution
from solver.matching import (
    Hypothesis,
    Level,
    MatchOptions,
    SolvedLevel,
    VerificationSamples,
    build_level,
    match,
    verify,
)
from solver.mesh import triangle_mesh
from solver.shape import (
    Shape,
    embedded_varadhan_distances,
    heat_kernel_embedding,
    varadhan_distances,
)
from solver.shape.choices import CommuteTime, Geodesic
from synthetic import articulated, correspondence
from tests.solver import shapes

N = 10
CROSSED = np.array([1, 0, *range(2, N)])


@pytest.fixture(scope="module")
def blob() -> Shape:
    return Shape(shapes.blob())


def level_of(shape: Shape, weight: float = 0.0, occlusion_cost: float | None = None) -> Level:
    """A shape against itself."""
    options = MatchOptions(points=N, first_order_weight=weight, occlusion_cost=occlusion_cost)
    return build_level(shape, shape, 0, (N, N), options.settled(1.0))


def hypotheses(level: Level, several: Sequence[IntArray]) -> list[Hypothesis]:
    """Correspondences as hypotheses of a search."""
    problem = level.problem(level.all_candidates())
    found = []
    for rank, partners in enumerate(several, start=1):
        solution = Solution(partners, problem.energy(partners), 0.0, 0, Method.LOCAL_SEARCH)
        found.append(Hypothesis((SolvedLevel(problem, solution, rank, 0.0),)))
    return found


def embedded(shape: Shape, samples: VerificationSamples) -> FloatArray:
    """Heat embedding of the first samples of a shape."""
    vertices = shape.sampling(CommuteTime(), N).indices
    return heat_kernel_embedding(shape.spectrum(), vertices, samples.time)


def test_lengths_between_two_sets_are_those_of_the_formula(blob: Shape) -> None:
    points = np.arange(20) * 7
    images = heat_kernel_embedding(blob.spectrum(), points, 0.02)
    np.testing.assert_allclose(np.linalg.norm(images, axis=1), 1.0)
    found = embedded_varadhan_distances(images[:8], images[8:], 0.02)
    expected = varadhan_distances(blob.spectrum(), points, 0.02)[:8, 8:]
    np.testing.assert_allclose(found, expected, atol=1e-9)


def test_only_the_identity_has_no_distortion(blob: Shape) -> None:
    samples = VerificationSamples.of(blob, blob)
    points = embedded(blob, samples)
    assert samples.distortion(points, points) == pytest.approx(0.0, abs=1e-9)
    for first in range(N - 1):
        crossed = np.arange(N)
        crossed[[first, first + 1]] = first + 1, first
        assert samples.distortion(points, points[crossed]) > 0.01


def test_the_distortion_is_that_of_the_best_images(blob: Shape) -> None:
    """The definition, sample by sample."""
    other = Shape(shapes.moved(shapes.blob(2), seed=1))
    samples = VerificationSamples.of(blob, other)
    source, target = embedded(blob, samples), embedded(other, samples)
    to_source = embedded_varadhan_distances(samples.source, source, samples.time)
    to_target = embedded_varadhan_distances(samples.target, target, samples.time)
    places = range(len(samples.target))

    def best(ours: FloatArray, theirs: FloatArray) -> list[int]:
        return [min(places, key=lambda y: ((row - theirs[y]) ** 2).sum()) for row in ours]

    first = best(to_source, to_target)
    second = best(
        np.hstack([to_source, samples.source_distances]),
        np.hstack([to_target, samples.target_distances[:, first]]),
    )
    changes = (
        to_source - to_target[second],
        samples.source_distances - samples.target_distances[np.ix_(second, second)],
    )
    expected = sum((change**2).mean() for change in changes) / (samples.source_distances**2).mean()
    assert samples.distortion(source, target) == pytest.approx(expected)


def test_the_unit_of_length_does_not_matter() -> None:
    meshes = shapes.blob(2), shapes.moved(shapes.blob(3), seed=2)
    found = []
    for factor in (1.0, 30.0):
        one, other = (Shape(shapes.moved(m, seed=3, scale=factor), normalise=False) for m in meshes)
        samples = VerificationSamples.of(one, other)
        found.append(samples.distortion(embedded(one, samples), embedded(other, samples)))
    assert found[1] == pytest.approx(found[0], rel=1e-3)


def test_hypotheses_are_ordered_by_the_distortion_of_their_samples(blob: Shape) -> None:
    level = level_of(blob)
    several = hypotheses(level, [CROSSED, np.roll(np.arange(N), 1), np.arange(N), CROSSED[::-1]])
    samples = VerificationSamples.of(blob, blob)
    points = embedded(blob, samples)
    found = verify(several, level, blob, blob, Control())
    said = [samples.distortion(points, points[one.partners]) for one in found]
    assert (np.diff(said) >= -1e-12).all()
    np.testing.assert_array_equal(found[0].partners, np.arange(N))
    assert sorted(one.levels[0].rank for one in found) == [1, 2, 3, 4]
    assert verify(several[:1], level, blob, blob, Control()) == several[:1]


def test_first_order_terms_count(blob: Shape) -> None:
    """Colours may tell what no distance can."""
    level = level_of(blob, weight=1e6)
    marks = np.eye(N)
    colored = replace(
        level,
        source=replace(level.source, descriptors=marks),
        target=replace(level.target, descriptors=marks[CROSSED]),
    )
    several = hypotheses(colored, [np.arange(N), CROSSED])
    assert verify(several, colored, blob, blob, Control()) == several[::-1]


def test_unmatched_points_pay_the_occlusion_cost(blob: Shape) -> None:
    partial = np.array([UNMATCHED, UNMATCHED, *range(2, N)])
    for cost, first in ((1e-6, partial), (1e6, CROSSED)):
        level = level_of(blob, occlusion_cost=cost)
        found = verify(hypotheses(level, [CROSSED, partial]), level, blob, blob, Control())
        np.testing.assert_array_equal(found[0].partners, first)


def test_crossed_legs_are_rejected() -> None:
    """The left legs with the right ones, in front only, have less energy than what is right."""
    standing = articulated("dog", "standing", 1000, 0)
    sitting = articulated("dog", "sitting", 1000, 2)
    source, target = (Shape(triangle_mesh(one.vertices, one.faces)) for one in (standing, sitting))
    truth = correspondence(standing, sitting)
    across = np.linalg.norm((standing.rest * [-1.0, 1.0, 1.0])[:, None] - standing.rest, axis=2)
    truths = truth, truth[np.argmin(across, axis=1)]
    found = match(source, target, MatchOptions(points=12))

    def error(targets: IntArray) -> float:
        distances = target.metric(Geodesic()).distances(targets)
        rows = np.arange(12)
        return float(min(distances[rows, one[found.best.source]].max() for one in truths))

    assert error(found.best.target) < 0.25
    cheapest = min(found.alternatives, key=lambda one: one.energy)
    assert cheapest.energy < found.best.energy
    assert error(cheapest.target) > 0.5
    assert found.certified
    assert found.lower_bound <= found.best.energy
    assert found.levels[-1].rank > 1
