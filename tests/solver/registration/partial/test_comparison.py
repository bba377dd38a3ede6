"""Candidates of a part that begin off the truth are registered again, and come closer."""

import time
from dataclasses import replace

import numpy as np
import pytest

from solver.arrays import FloatArray, IntArray
from solver.control import Control
from solver.functional_maps import nearest_points
from solver.mesh import triangle_mesh
from solver.registration.alignment import Pairs
from solver.registration.choice import Candidate
from solver.registration.partial.alignment import fit_to_part
from solver.registration.partial.comparison import refine_candidates
from solver.registration.partial.partiality import FINEST, OF_PART
from solver.registration.partial.refinement import RefinedPart
from solver.registration.partial.task import PartTask
from solver.shape import Shape
from synthetic import human

SIZE = 20


@pytest.fixture(scope="module")
def whole() -> Shape:
    body = human("walking", resolution=1500)
    return Shape(triangle_mesh(body.vertices, body.faces))


@pytest.fixture(scope="module")
def kept(whole: Shape) -> IntArray:
    """Vertices of the left half, and of what is next to it."""
    side = whole.mesh.vertices[:, 0]
    inside = side < np.median(side) + 0.02 * np.ptp(side)
    return np.unique(whole.mesh.faces[inside[whole.mesh.faces].all(axis=1)])


@pytest.fixture(scope="module")
def half(whole: Shape, kept: IntArray) -> Shape:
    faces = whole.mesh.faces[np.isin(whole.mesh.faces, kept).all(axis=1)]
    return Shape(triangle_mesh(whole.mesh.vertices[kept], np.searchsorted(kept, faces)))


def task_of(whole: Shape, half: Shape) -> PartTask:
    return PartTask((whole, half), OF_PART, float((whole.mesh.area / half.mesh.area) ** 0.5))


def begun(whole: Shape, half: Shape, kept: IntArray, off: FloatArray) -> Candidate:
    """The candidate whose partners lie where each vertex of the half is, and (3,) from there."""
    task = task_of(whole, half)
    ours, theirs = samples = task.sampled(FINEST)
    positions = task.whole.mesh.vertices
    back = nearest_points(positions[kept[theirs.vertices]] + off, positions[ours.vertices])
    assert task.scale is not None
    pairs = Pairs.of_part(back, len(ours))
    start = fit_to_part(*samples, pairs, task.scale, SIZE), task.scale
    return task.register(samples, start, replace(FINEST, sizes=()))


def error(found: RefinedPart, kept: IntArray) -> float:
    """Mean distance in √area of the whole from where the half is cut out of it."""
    positions = found.displaced.source.mesh.vertices
    return float(np.linalg.norm(positions[found.back[0]] - positions[kept], axis=1).mean())


def refined(
    whole: Shape, half: Shape, control: Control, *candidates: Candidate
) -> list[RefinedPart]:
    found = refine_candidates(task_of(whole, half), candidates, control)
    return [one.part for one in found]


def test_a_candidate_comes_closer_where_it_is_registered_again(
    whole: Shape, half: Shape, kept: IntArray
) -> None:
    """Displaced as rigidly as possible alone, even twice, it hardly does."""
    off = begun(whole, half, kept, np.array([0.0, 0.25, 0.0]))
    task = task_of(whole, half)
    once = RefinedPart.of(task, off, Control())
    again = refined(whole, half, Control(), off)[0]
    assert error(once.again(Control()), kept) > 0.8 * error(once, kept)
    assert error(again, kept) < 0.2 * error(once, kept)


def test_those_that_fit_best_come_first_and_past_the_deadline_only_one_is_refined(
    whole: Shape, half: Shape, kept: IntArray
) -> None:
    known, wrong = (begun(whole, half, kept, np.array([0.0, off, 0.0])) for off in (0.0, 0.8))
    found = refined(whole, half, Control(), wrong, known)
    assert error(found[0], kept) < 0.02
    assert all(error(one, kept) > 0.1 for one in found[1:])
    (first,) = refined(whole, half, Control(deadline=time.monotonic()), wrong, known)
    assert error(first, kept) > 0.3
