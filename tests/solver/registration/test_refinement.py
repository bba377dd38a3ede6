"""Refined candidates: their fit, and the choice among them when in doubt."""

import time
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial import KDTree
from scipy.spatial.transform import Rotation

from solver.arrays import BoolArray, FloatArray, IntArray
from solver.control import Control
from solver.mesh import triangle_mesh
from solver.registration import Registration, register
from solver.registration.candidates import NO_LANDMARKS, first_pairs, pairs_from_points
from solver.registration.choice import COARSE, FINE, SAME, Candidate, Task, choose
from solver.registration.confidence import RIVAL
from solver.registration.reduction import FEW, ReducedTask
from solver.registration.refinement import (
    RefinedCandidate,
    RefinedFit,
    best_compared,
    compare,
    has_rivals,
    mend,
    refine_candidate,
)
from solver.registration.surface import smooth_surface
from solver.registration.surface_map import SurfaceMap, at_rest
from solver.shape import Shape
from synthetic import ALIEN, HUMAN_POSES, HumanProportions, human, human_figure, transferred
from synthetic.shapes import posed
from tests.solver.shapes import icosphere


def task_of(source: Shape, target: Shape) -> Task:
    ours, theirs = smooth_surface(source), smooth_surface(target)
    return Task(ours, theirs, (ours.samples, theirs.samples), NO_LANDMARKS)


def candidates(task: Task) -> list[Candidate]:
    return choose(
        task,
        lambda samples: first_pairs((task.source, task.target), samples, ()),
        (*COARSE, *FINE),
        Control(),
    )


def test_a_copy_fits_exactly_and_others_do_not(blob: Shape) -> None:
    turn = Rotation.from_rotvec([1.0, -2.0, 0.4]).as_matrix()
    copy = Shape(triangle_mesh(3.0 * blob.mesh.vertices @ turn, blob.mesh.faces))
    task = task_of(blob, copy)
    right, *wrong = candidates(task)
    refined = refine_candidate(task, right, Control())
    np.testing.assert_array_equal(refined.images, np.arange(blob.n_vertices))
    assert max(refined.fit.apart, refined.fit.strained) < 1e-3
    assert refined.fit.turned < 0.02
    assert wrong
    for one in wrong:
        other = refine_candidate(task, one, Control()).fit
        assert other.strained > 10.0 * refined.fit.strained
        assert other.score > refined.fit.score + 3.0


def test_the_score_is_the_sum_of_the_logarithms() -> None:
    fit = RefinedFit(0.01, 0.1, 0.5)
    assert fit.score == pytest.approx(np.log(0.01 * 0.1 * 0.5))
    assert np.isfinite(RefinedFit(0.0, 0.0, 0.0).score)


def test_those_that_fit_best_come_first_and_differ(blob: Shape) -> None:
    task = task_of(blob, blob)
    found = candidates(task)
    chosen = best_compared(compare(ReducedTask.of(blob, blob, task, FEW), found[::-1], Control()))
    scores = [one.fit.score for one in chosen]
    assert scores == sorted(scores)
    assert chosen[0].candidate is found[0]
    for number, one in enumerate(chosen):
        for other in chosen[:number]:
            assert np.linalg.norm(one.places - other.places, axis=1).mean() > SAME


def test_those_that_miss_the_landmarks_are_not_chosen(blob: Shape) -> None:
    task = task_of(blob, blob)
    best, *others = compare(ReducedTask.entire(task), candidates(task)[:3], Control())
    missing = replace(best, candidate=replace(best.candidate, missed=0.2))
    assert best_compared([missing, *others])[0].candidate in [one.candidate for one in others]
    near = replace(best, candidate=replace(best.candidate, missed=0.05))
    assert best_compared([near, *others])[0] is near


@pytest.fixture(scope="module")
def standing() -> Registration:
    """A body registered to itself."""
    figure = human(resolution=1500)
    shape = Shape(triangle_mesh(figure.vertices, figure.faces))
    found = register(shape, shape, [], Control())
    assert found is not None
    np.testing.assert_array_equal(
        found.images(np.arange(shape.n_vertices)), np.arange(shape.n_vertices)
    )
    return found


def exchanged(standing: Registration) -> tuple[tuple[BoolArray, BoolArray], FloatArray]:
    """Vertices of both feet, and by how much all vertices move if they are exchanged."""
    places = smooth_surface(standing.source).mesh.vertices
    foot = places[:, 1] < places[:, 1].min() + 0.18
    feet = foot & (places[:, 0] > 0.0), foot & (places[:, 0] < 0.0)
    apart = places[feet[0]].mean(axis=0) - places[feet[1]].mean(axis=0)
    return feet, -np.subtract(*feet, dtype=float)[:, None] * apart


def test_feet_that_are_exchanged_are_torn_off_and_return(standing: Registration) -> None:
    """As rigidly as possible alone, they stay on the wrong legs."""
    surface = smooth_surface(standing.source)
    right = SurfaceMap.of(surface, surface, standing.candidate.alignment, reflected=False)
    feet, moved = exchanged(standing)
    rigid = at_rest(surface)
    displaced, images = right.moved(right.positions + moved).refined(rigid, Control())
    for one, other in (feet, feet[::-1]):
        assert np.isin(images[one], np.flatnonzero(other)).mean() > 0.5
    held = RefinedCandidate(displaced, images, rigid.strain(displaced.positions))
    np.testing.assert_array_equal(mend(held, Control()).images, np.arange(len(images)))
    assert mend(held, Control(deadline=time.monotonic())) is held


def test_sparse_images_are_refined_where_eigenfunctions_exchange_feet(
    standing: Registration,
) -> None:
    surface, known = smooth_surface(standing.source), standing.candidate
    feet, moved = exchanged(standing)
    foot = np.flatnonzero(np.logical_or(*feet))
    functions = surface.spectrum.eigenfunctions[:, : known.alignment.size]
    further = functions.T @ (surface.spectrum.mass[:, None] * moved) @ known.alignment.turn
    wrong = replace(known.alignment, coefficients=known.alignment.coefficients + further)

    def errors(images: IntArray) -> FloatArray:
        places = surface.mesh.vertices
        found: FloatArray = np.linalg.norm(places[images] - places[foot], axis=1)
        return found

    torn = SurfaceMap.of(surface, surface, wrong, reflected=False)
    assert errors(torn.images(foot)).mean() > 0.2
    found = replace(standing, candidate=replace(known, alignment=wrong))
    assert errors(found.images(foot)).mean() < 0.05


def test_past_a_deadline_one_is_refined(blob: Shape) -> None:
    task = task_of(blob, blob)
    late = Control(deadline=time.monotonic())
    assert len(compare(ReducedTask.entire(task), candidates(task)[:3], late)) == 1


@pytest.fixture(scope="module")
def symmetric() -> Registration:
    """An ellipsoid lies on another one in four ways, by rotations about its axes."""
    sphere = icosphere(3)
    one, other = (
        Shape(triangle_mesh(sphere.vertices * axes, sphere.faces))
        for axes in ([1.0, 0.7, 1.8], [1.1, 0.7, 1.7])
    )
    found = register(one, other, [], Control())
    assert found is not None
    return found


def test_rivals_are_refined_and_the_best_is_the_answer(
    symmetric: Registration, blob: Shape
) -> None:
    assert "refined_score" in symmetric.confidence.measures
    # Four ways are nearly as good, and nobody can tell.
    assert symmetric.confidence.probability < 0.3
    assert symmetric.confidence.reasons == (RIVAL,)
    alone = register(blob, blob, [], Control())
    assert alone is not None
    assert "refined_score" not in alone.confidence.measures


def test_rivals_meet_the_landmarks_as_well_as_the_best(blob: Shape) -> None:
    best, *others = (replace(one, missed=0.01) for one in candidates(task_of(blob, blob))[:3])
    near = [
        replace(one, fit=best.fit, missed=missed)
        for one, missed in zip(others, (0.1, 0.2), strict=True)
    ]
    assert has_rivals([best, *near])
    assert not has_rivals([best, near[1]])
    assert not has_rivals([best, *others])


def test_the_right_candidate_is_told_where_eigenfunctions_fit_better_by_others() -> None:
    """A person with a great head, long arms and short legs: limbs bend and stretch much."""
    figures = human_figure(HumanProportions()), human_figure(ALIEN)
    bodies = [
        posed(figure, HUMAN_POSES[pose], 1500, seed)
        for seed, (figure, pose) in enumerate(zip(figures, ("rest", "standing"), strict=True))
    ]
    source, target = (Shape(triangle_mesh(one.vertices, one.faces)) for one in bodies)
    truth = np.asarray(KDTree(bodies[1].rest).query(transferred(bodies[0].rest, *figures))[1])
    task, points = task_of(source, target), np.arange(0, len(truth), 10)
    surfaces = task.source, task.target
    stages = (*COARSE, replace(FINE[0], kept=16))
    right = choose(
        task,
        lambda samples: [pairs_from_points(surfaces, samples, (points, truth[points]))],
        stages,
        Control(),
    )[0]
    wrong = choose(task, lambda samples: first_pairs(surfaces, samples, ()), stages, Control())
    assert sum(one.fit.score < right.fit.score for one in wrong) >= 3
    few = ReducedTask.of(source, target, task, FEW)
    chosen, second, *_ = best_compared(compare(few, [*wrong, right], Control()))
    assert chosen.candidate is right
    assert second.fit.score > chosen.fit.score + 0.5
