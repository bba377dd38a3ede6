"""Candidates that are compared by their refinement, and the choice among them when in doubt."""

import time
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial import KDTree

from solver.control import Control
from solver.mesh import triangle_mesh
from solver.registration import Registration, register
from solver.registration.candidates import first_pairs, pairs_from_points
from solver.registration.choice import COARSE, FINE, SAME, Candidate, Task, choose
from solver.registration.comparison import best_compared, compare, may_be_overtaken
from solver.registration.confidence import RIVAL
from solver.registration.reduction import FEW_VERTICES, ReducedTask
from solver.shape import Shape
from synthetic import ALIEN, HUMAN_POSES, HumanProportions, human_figure, transferred
from synthetic.shapes import posed
from tests.solver.shapes import icosphere


def test_those_that_fit_best_come_first_and_differ(blob: Shape, found: list[Candidate]) -> None:
    task = Task.of(blob, blob)
    chosen = best_compared(
        compare(ReducedTask.of(blob, blob, task, FEW_VERTICES), found[::-1], Control())
    )
    scores = [one.fit.score for one in chosen]
    assert scores == sorted(scores)
    assert chosen[0].candidate is found[0]
    for number, one in enumerate(chosen):
        for other in chosen[:number]:
            assert np.linalg.norm(one.image_positions - other.image_positions, axis=1).mean() > SAME


def test_those_that_miss_the_landmarks_are_not_chosen(blob: Shape, found: list[Candidate]) -> None:
    task = Task.of(blob, blob)
    best, *others = compare(ReducedTask.entire(task), found[:3], Control())
    missing = replace(best, candidate=replace(best.candidate, missed=0.2))
    assert best_compared([missing, *others])[0].candidate in [one.candidate for one in others]
    near = replace(best, candidate=replace(best.candidate, missed=0.05))
    assert best_compared([near, *others])[0] is near


def test_past_a_deadline_one_is_refined(blob: Shape, found: list[Candidate]) -> None:
    task = Task.of(blob, blob)
    late = Control(deadline=time.monotonic())
    assert len(compare(ReducedTask.entire(task), found[:3], late)) == 1


def test_rivals_fit_nearly_as_well_as_the_best(found: list[Candidate]) -> None:
    best, *others = found[:3]
    assert may_be_overtaken([best, replace(others[0], fit=best.fit), others[1]])
    assert not may_be_overtaken([best, *others])


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


def test_the_right_candidate_is_told_where_eigenfunctions_fit_better_by_others() -> None:
    """A person with a great head, long arms and short legs: limbs bend and stretch much."""
    figures = human_figure(HumanProportions()), human_figure(ALIEN)
    bodies = [
        posed(figure, HUMAN_POSES[pose], 1500, seed)
        for seed, (figure, pose) in enumerate(zip(figures, ("rest", "standing"), strict=True))
    ]
    source, target = (Shape(triangle_mesh(one.vertices, one.faces)) for one in bodies)
    truth = np.asarray(KDTree(bodies[1].rest).query(transferred(bodies[0].rest, *figures))[1])
    task, points = Task.of(source, target), np.arange(0, len(truth), 10)
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
    few = ReducedTask.of(source, target, task, FEW_VERTICES)
    chosen, second, *_ = best_compared(compare(few, [*wrong, right], Control()))
    assert chosen.candidate is right
    assert second.fit.score > chosen.fit.score + 0.5
