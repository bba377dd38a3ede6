"""Refined candidates: their fit, and the choice among them when in doubt."""

import time
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from solver.control import Control
from solver.mesh import triangle_mesh
from solver.registration import Registration, register
from solver.registration.candidates import NO_LANDMARKS, first_pairs
from solver.registration.choice import COARSE, FINE, Candidate, Task, choose
from solver.registration.confidence import RIVAL
from solver.registration.reduction import ReducedTask
from solver.registration.refinement import RefinedFit, choose_refined, refine_candidate, rivals_of
from solver.registration.surface import smooth_surface
from solver.shape import Shape
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
    refined = refine_candidate(ReducedTask.entire(task), right, Control())
    np.testing.assert_array_equal(refined.images, np.arange(blob.n_vertices))
    assert max(refined.fit.apart, refined.fit.strained) < 1e-3
    assert refined.fit.turned < 0.02
    assert wrong
    for one in wrong:
        other = refine_candidate(ReducedTask.entire(task), one, Control()).fit
        assert other.strained > 10.0 * refined.fit.strained
        assert other.score > refined.fit.score + 3.0


def test_the_score_is_the_sum_of_the_logarithms() -> None:
    fit = RefinedFit(0.01, 0.1, 0.5)
    assert fit.score == pytest.approx(np.log(0.01 * 0.1 * 0.5))
    assert np.isfinite(RefinedFit(0.0, 0.0, 0.0).score)


def test_those_that_fit_best_come_first_and_differ(blob: Shape) -> None:
    task = task_of(blob, blob)
    found = candidates(task)
    chosen = choose_refined(ReducedTask.entire(task), [*found[2::-1], found[0]], Control())
    scores = [one.score for one in chosen.fits]
    assert scores == sorted(scores)
    assert chosen.best.fit.score == scores[0]
    assert chosen.best.candidate is chosen.candidates[0] is found[0]
    assert len(chosen.candidates) == len(scores) <= 3
    np.testing.assert_array_equal(chosen.best.images, np.arange(blob.n_vertices))


def test_past_a_deadline_one_is_refined(blob: Shape) -> None:
    task = task_of(blob, blob)
    late = Control(deadline=time.monotonic())
    assert len(choose_refined(ReducedTask.entire(task), candidates(task)[:3], late).fits) == 1


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
    refined = symmetric.refined
    assert refined is not None
    assert symmetric.candidates[0] is refined.candidate
    assert symmetric.confidence.measures["refined_score"] == refined.fit.score
    # Either of two ways is as good, and nobody can tell.
    assert symmetric.confidence.probability == pytest.approx(0.5, abs=0.01)
    assert symmetric.confidence.reasons == (RIVAL,)
    alone = register(blob, blob, [], Control())
    assert alone is not None
    assert alone.refined is None


def test_the_refined_answer_is_the_dense_map(symmetric: Registration) -> None:
    assert symmetric.refined is not None
    np.testing.assert_array_equal(symmetric.dense(Control()).target, symmetric.refined.images)


def test_rivals_meet_the_landmarks_as_well_as_the_best(blob: Shape) -> None:
    best, *others = (replace(one, missed=0.01) for one in candidates(task_of(blob, blob))[:3])
    near = [
        replace(one, fit=best.fit, missed=missed)
        for one, missed in zip(others, (0.1, 0.2), strict=True)
    ]
    assert rivals_of([best, *near]) == [best, near[0]]
    assert rivals_of([best, *others]) == [best]
