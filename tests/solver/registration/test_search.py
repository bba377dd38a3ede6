"""Search: when it ends, and what it returns."""

from functools import partial
from typing import NoReturn

import numpy as np
import pytest

from solver.control import Control
from solver.errors import MeshError
from solver.mesh import triangle_mesh
from solver.registration.candidates import NO_LANDMARKS
from solver.registration.choice import SAME, Task
from solver.registration.confidence import RIVAL
from solver.registration.reduction import ReducedTask
from solver.registration.search import search
from solver.registration.surface import smooth_surface
from solver.shape import Shape
from tests.solver.shapes import icosphere


def task_of(source: Shape, target: Shape) -> Task:
    ours, theirs = smooth_surface(source), smooth_surface(target)
    return Task(ours, theirs, (ours.samples, theirs.samples), NO_LANDMARKS)


@pytest.fixture(scope="module")
def ellipsoids() -> tuple[Shape, Shape]:
    """One lies on the other in four ways."""
    sphere = icosphere(3)
    one, other = (
        Shape(triangle_mesh(sphere.vertices * axes, sphere.faces))
        for axes in ([1.0, 0.7, 1.8], [1.1, 0.7, 1.7])
    )
    return one, other


def cannot_be_reduced() -> NoReturn:
    raise MeshError("nothing can be displaced")


def test_beyond_doubt_nothing_is_refined(blob: Shape) -> None:
    asked: list[None] = []

    def few() -> ReducedTask:
        asked.append(None)
        return ReducedTask.entire(task_of(blob, blob))

    found = search(task_of(blob, blob), few, (), Control())
    assert found.confidence.probability > 0.99
    assert not asked
    np.testing.assert_array_equal(
        found.candidates[0].images,
        smooth_surface(blob).samples.first(len(found.candidates[0].images)).vertices,
    )


def test_in_doubt_those_that_differ_are_compared(ellipsoids: tuple[Shape, Shape]) -> None:
    task = task_of(*ellipsoids)
    found = search(task, partial(ReducedTask.entire, task), (), Control())
    assert found.confidence.reasons == (RIVAL,)
    assert len(found.candidates) >= 4
    best, *others = (task.positions[one.images[:200]] for one in found.candidates)
    for one in others:
        assert np.linalg.norm(one - best, axis=1).mean() > SAME


def test_what_cannot_be_refined_is_mapped_by_eigenfunctions(
    ellipsoids: tuple[Shape, Shape],
) -> None:
    found = search(task_of(*ellipsoids), cannot_be_reduced, (), Control())
    scores = [one.fit.score for one in found.candidates]
    assert scores == sorted(scores)
    assert "refined_score" not in found.confidence.measures
