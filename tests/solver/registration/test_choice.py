"""Choice among candidates: those that differ, those that meet landmarks, and the truth."""

from dataclasses import replace

import numpy as np
import pytest

from solver.arrays import IntArray
from solver.control import Control
from solver.functional_maps import FunctionalMap
from solver.mesh import triangle_mesh
from solver.registration.alignment import GLOBAL, Alignment, Pairs, fit_alignment
from solver.registration.candidates import (
    NO_LANDMARKS,
    Points,
    exchanged_pairs,
    first_pairs,
    pairs_from_points,
    varied_pairs,
)
from solver.registration.choice import (
    COARSE,
    FINE,
    Candidate,
    FirstPairs,
    Task,
    choose,
    distinct,
    meeting,
    ranked,
)
from solver.registration.crossing import Crossed, cross, uncrossed
from solver.registration.fit import Fit, LocalFit
from solver.registration.surface import MIRROR, SmoothSurface, smooth_surface
from solver.shape import Shape
from synthetic import SyntheticShape, correspondence, human

STAGES = (*COARSE, *FINE)
NOTHING = Alignment(np.zeros((1, 3)), FunctionalMap(np.eye(1)), np.eye(3))


@pytest.fixture(scope="module")
def figures() -> tuple[SyntheticShape, SyntheticShape]:
    """A person in two poses, left and right alike."""
    return human("standing", resolution=1000, seed=1), human("walking", resolution=1000, seed=2)


@pytest.fixture(scope="module")
def surfaces(
    figures: tuple[SyntheticShape, SyntheticShape],
) -> tuple[SmoothSurface, SmoothSurface]:
    one, other = (
        smooth_surface(Shape(triangle_mesh(each.vertices, each.faces))) for each in figures
    )
    return one, other


def task_of(
    surfaces: tuple[SmoothSurface, SmoothSurface], landmarks: Points = NO_LANDMARKS
) -> Task:
    return Task(*surfaces, (surfaces[0].samples, surfaces[1].samples), landmarks)


def starting_at(
    surfaces: tuple[SmoothSurface, SmoothSurface], hypotheses: list[Points]
) -> FirstPairs:
    return lambda samples: [pairs_from_points(surfaces, samples, points) for points in hypotheses]


def chosen_from(
    surfaces: tuple[SmoothSurface, SmoothSurface],
    hypotheses: list[Points],
    landmarks: Points = NO_LANDMARKS,
) -> list[Candidate]:
    start = starting_at(surfaces, hypotheses)
    return choose(task_of(surfaces, landmarks), start, STAGES, Control())


def images_after(figures: tuple[SyntheticShape, SyntheticShape], change: list[float]) -> IntArray:
    """Images when positions at rest are changed in sign before."""
    source, target = figures
    moved = SyntheticShape(source.vertices, source.faces, source.rest * change)
    return correspondence(moved, target)


@pytest.mark.parametrize(
    "change", [[-1.0, 1.0, -1.0], [-1.0, 1.0, 1.0]], ids=["turned by 180°", "mirrored"]
)
def test_the_truth_fits_better_than_a_near_symmetry(
    figures: tuple[SyntheticShape, SyntheticShape],
    surfaces: tuple[SmoothSurface, SmoothSurface],
    change: list[float],
) -> None:
    """Begun at the truth, and where left and right, or front and back as well, are exchanged."""
    points = surfaces[0].samples.vertices[:60]
    truth, wrong = (images_after(figures, each)[points] for each in ([1.0] * 3, change))
    best, *others = chosen_from(surfaces, [(points, wrong), (points, truth)])
    rest = figures[1].rest
    here = images_after(figures, [1.0] * 3)[surfaces[0].samples.first(len(best.images)).vertices]
    size = np.sqrt(np.ptp(rest, axis=0).prod() ** (2.0 / 3.0))
    assert np.linalg.norm(rest[best.images] - rest[here], axis=1).mean() < 0.1 * size
    alone = chosen_from(surfaces, [(points, wrong)])
    assert best.fit.score < min(one.fit.score for one in [*alone, *others])


def candidate(images: list[int], score: float = 0.0) -> Candidate:
    measure = float(np.exp(score))
    fit = Fit({"apart": measure})
    everywhere = np.arange(len(images))
    local = LocalFit(np.ones((5, len(images))), Pairs.of_all(everywhere, everywhere))
    return Candidate(NOTHING, fit, np.array(images), local)


def test_similar_candidates_are_left_out() -> None:
    positions = np.array([[0.0, 0, 0], [0.01, 0, 0], [1.0, 0, 0]])
    first, alike, other = candidate([0, 2], -2.0), candidate([1, 2], -1.0), candidate([2, 0])
    assert ranked([other, alike, first], positions) == [first, other]
    assert ranked([alike, other], positions) == [alike, other]
    assert ranked([other, alike, first], positions, 1) == [first]
    assert ranked([], positions) == []


def test_the_best_candidate_comes_first_and_all_differ(
    surfaces: tuple[SmoothSurface, SmoothSurface],
) -> None:
    found = choose(
        task_of(surfaces), lambda samples: first_pairs(surfaces, samples, []), STAGES, Control()
    )
    scores = [one.fit.score for one in found]
    assert scores == sorted(scores)
    assert ranked(found, surfaces[1].mesh.vertices) == found


def test_candidates_that_miss_the_landmarks_come_last(
    figures: tuple[SyntheticShape, SyntheticShape],
    surfaces: tuple[SmoothSurface, SmoothSurface],
) -> None:
    """Landmarks on the other side of the body: the truth fits better, and is not meant."""
    rest = figures[0].rest
    landmarks = np.array([rest[:, 0].argmax(), rest[:, 0].argmin()])
    points = surfaces[0].samples.vertices[:60]
    truth = images_after(figures, [1.0] * 3)
    exchanged = images_after(figures, [-1.0, 1.0, -1.0])
    hypotheses = [(points, truth[points]), (points, exchanged[points])]
    meant = landmarks, exchanged[landmarks]
    best, *others = chosen_from(surfaces, hypotheses, meant)
    assert best.missed < min(one.missed for one in others)
    assert best.fit.score > min(one.fit.score for one in others)


def test_first_pairs_of_known_points_are_near_the_truth(
    figures: tuple[SyntheticShape, SyntheticShape],
    surfaces: tuple[SmoothSurface, SmoothSurface],
) -> None:
    truth = images_after(figures, [1.0] * 3)
    samples = surfaces[0].samples.first(200), surfaces[1].samples.first(500)
    points = samples[0].vertices[:16]
    pairs = pairs_from_points(surfaces, samples, (points, truth[points]))
    positions = surfaces[1].mesh.vertices
    found = positions[samples[1].vertices[pairs.images]]
    errors = np.linalg.norm(found - positions[truth[samples[0].vertices]], axis=1)
    assert np.median(errors) < 0.15


def test_candidates_are_those_of_hypotheses_and_signs_and_a_rotation(
    surfaces: tuple[SmoothSurface, SmoothSurface],
) -> None:
    samples = surfaces[0].samples.first(50), surfaces[1].samples.first(60)
    points = np.arange(5), np.arange(5)
    few = np.arange(2), np.arange(2)
    for hypotheses, expected in (([points, few], 1 + 64 + 1), ([], 64 + 1)):
        found = list(first_pairs(surfaces, samples, hypotheses))
        assert len(found) == expected
        assert all(len(one.images) == 50 and len(one.back) == 60 for one in found)
    alignment = fit_alignment(*samples, found[0], 12)
    varied = list(varied_pairs(samples, [alignment, alignment]))
    assert len(varied) == 2 * 64
    own = alignment.pairs(*samples, GLOBAL)
    np.testing.assert_array_equal(varied[0].images, own.images)


def test_exchanged_eigenfunctions_are_matched_with_one_another(
    surfaces: tuple[SmoothSurface, SmoothSurface],
) -> None:
    """Those of a surface and of one whose fourth and fifth come in the other order."""
    samples = surfaces[0].samples.first(50)
    order = np.arange(samples.size)
    order[[4, 5]] = 5, 4
    exchanged = replace(
        samples,
        eigenfunctions=samples.eigenfunctions[:, order],
        coefficients=samples.coefficients[order],
        tangents=samples.tangents[:, :, order],
    )
    found = list(exchanged_pairs((samples, exchanged)))
    assert len(found) == 5 * 64
    itself = [one for one in found if (one.images == np.arange(50)).all()]
    assert len(itself) == 1
    *signs, rotated = first_pairs(surfaces, (samples, exchanged), ())
    assert not any((one.images == np.arange(50)).all() for one in signs)
    assert (rotated.images == np.arange(50)).all()


def test_nothing_to_begin_with_gives_nothing(
    surfaces: tuple[SmoothSurface, SmoothSurface],
) -> None:
    assert chosen_from(surfaces, []) == []


def test_candidates_right_on_one_half_each_are_crossed_to_one_that_is_right(
    figures: tuple[SyntheticShape, SyntheticShape],
    surfaces: tuple[SmoothSurface, SmoothSurface],
) -> None:
    """One exchanges the arms, the other one the legs."""
    points = surfaces[0].samples.vertices[:60]
    truth, mirrored = (images_after(figures, [sign, 1.0, 1.0])[points] for sign in (1.0, -1.0))
    upper = figures[0].rest[points, 1] > np.median(figures[0].rest[:, 1])
    arms, legs = np.where(upper, mirrored, truth), np.where(upper, truth, mirrored)
    task = task_of(surfaces)
    halves = choose(
        task, starting_at(surfaces, [(points, arms), (points, legs)]), COARSE, Control()
    )
    crossed = cross(task, halves, set(), Control())
    rest = figures[1].rest
    samples = surfaces[0].samples.first(len(crossed[0].images)).vertices
    here = rest[images_after(figures, [1.0] * 3)[samples]]
    size = np.sqrt(np.ptp(rest, axis=0).prod() ** (2.0 / 3.0))
    before, after = (
        min(float(np.linalg.norm(rest[one.images] - here, axis=1).mean()) for one in found) / size
        for found in (halves, crossed[:1])
    )
    assert after < 0.1 < before
    assert crossed[0].fit.score < halves[0].fit.score


def test_one_candidate_alone_is_not_crossed(
    surfaces: tuple[SmoothSurface, SmoothSurface],
) -> None:
    points = surfaces[0].samples.vertices[:60]
    task = task_of(surfaces)
    alone = choose(task, starting_at(surfaces, [(points, points)]), COARSE, Control())
    assert cross(task, alone, set(), Control()) == alone


def test_no_two_candidates_are_crossed_twice(
    surfaces: tuple[SmoothSurface, SmoothSurface],
) -> None:
    points = surfaces[0].samples.vertices[:60]
    begun = starting_at(surfaces, [(points, points)])
    a, b, c, d = (choose(task_of(surfaces), begun, COARSE, Control())[0] for _ in range(4))
    crossed: Crossed = set()
    assert list(uncrossed([a, b, c], crossed)) == [(0, 1), (0, 2), (1, 2)]
    assert list(uncrossed([c, b, d, a], crossed)) == [(0, 2), (1, 2), (2, 3)]
    assert list(uncrossed([a, b, c, d], crossed)) == []


def test_alignments_that_are_right_miss_no_landmarks(surface: SmoothSurface) -> None:
    k = surface.samples.size
    own = Alignment(surface.coefficients, FunctionalMap(np.eye(k)), np.eye(3))
    vertices = np.arange(0, 600, 60)
    task = task_of((surface, surface), (vertices, vertices))
    assert task.missed(own) < 0.02
    assert task.missed(NOTHING) > 0.1
    assert task_of((surface, surface)).missed(NOTHING) == 0.0
    assert own.pairs(surface.samples, surface.samples, GLOBAL).images[3] == 3
    # Bent back, a surface goes to the mirror image of the source that is reflected.
    mirrored = replace(own, coefficients=own.coefficients * MIRROR)
    assert task.reflected().swapped().missed(mirrored) < 0.02
    assert task.reflected().swapped().missed(own) > 0.1


def test_landmarks_are_met_as_well_as_by_any() -> None:
    assert meeting([0.05, 0.0, 0.1, 0.2]) == [True, True, True, False]
    assert meeting([0.35, 0.3, 0.5]) == [True, True, False]
    assert meeting([]) == []


def test_maps_that_are_near_an_earlier_one_are_left_out() -> None:
    """By less than 0.05 of √area on average, wherever the others are."""
    here = np.random.default_rng(0).normal(size=(50, 3))
    far, along = here[::-1], np.array([1.0, 0.0, 0.0])
    maps = [here, here + 0.04 * along, far, here + 0.08 * along, far - 0.03 * along]
    assert distinct(maps) == [0, 2, 3]
