"""Candidates of a part that are right on one half each."""

from dataclasses import replace

import numpy as np
import pytest

from solver.arrays import FloatArray
from solver.control import Control
from solver.functional_maps import FunctionalMap
from solver.mesh import triangle_mesh
from solver.registration.alignment import Alignment
from solver.registration.candidates import NO_LANDMARKS
from solver.registration.fit import worse_by
from solver.registration.partial.choice import (
    PartCandidate,
    PartStage,
    PartTask,
    choose_parts,
    register_part_candidate,
)
from solver.registration.partial.crossing import cross_parts
from solver.registration.partial.fit import fit_at_part
from solver.registration.surface import smooth_surface
from solver.shape import Shape
from synthetic import human

STAGE = PartStage(200, 400, (), 24)
SIZE = 20


@pytest.fixture(scope="module")
def whole() -> Shape:
    body = human("walking", resolution=1000, seed=1)
    return Shape(triangle_mesh(body.vertices, body.faces))


@pytest.fixture(scope="module")
def task(whole: Shape) -> PartTask:
    """The body, and all of it but a hand."""
    side = whole.mesh.vertices[:, 0]
    faces = whole.mesh.faces[(side[whole.mesh.faces] < np.quantile(side, 0.95)).all(axis=1)]
    vertices = np.unique(faces)
    part = triangle_mesh(whole.mesh.vertices[vertices], np.searchsorted(vertices, faces))
    surfaces = smooth_surface(whole), smooth_surface(Shape(part))
    return PartTask(*surfaces, entire=True, rescaled=False, landmarks=NO_LANDMARKS)


def displaced(task: PartTask, where: FloatArray) -> PartCandidate:
    """The candidate that moves a region aside, given as (V,) weights, and nothing else."""
    whole, part = task.whole, task.part
    functions = whole.spectrum.eigenfunctions[:, :SIZE]
    scale = float(np.ptp(part.mesh.vertices[:, 1]) / np.ptp(whole.mesh.vertices[:, 1]))
    # What is cut off moves the middle, from which both surfaces are measured.
    top = [one.mesh.vertices[one.mesh.vertices[:, 1].argmax()] for one in (whole, part)]
    moved = scale * (whole.mesh.vertices - top[0]) + top[1] + 0.4 * where[:, None]
    coefficients = functions.T @ (whole.spectrum.mass[:, None] * moved)
    unknown = FunctionalMap(np.empty((0, SIZE)))
    start = Alignment(coefficients, unknown, scale * np.eye(3)), scale
    return register_part_candidate(task, task.samples(STAGE), start, ())


@pytest.fixture(scope="module")
def level(task: PartTask) -> FloatArray:
    height = task.whole.mesh.vertices[:, 1]
    return np.asarray((height - height.min()) / np.ptp(height))


def test_candidates_right_on_one_half_each_are_crossed_to_one_that_is_right(
    task: PartTask, level: FloatArray
) -> None:
    truth = displaced(task, np.zeros(len(level)))
    halves = [displaced(task, np.asarray(where, float)) for where in (level > 0.8, level < 0.2)]
    crossed = cross_parts(task, halves, STAGE, Control())[0]
    positions = task.whole.samples.positions

    def error(one: PartCandidate) -> float:
        away = positions[one.partners] - positions[truth.partners]
        return float(np.linalg.norm(away, axis=1).mean())

    assert error(crossed) < 0.5 * min(map(error, halves))
    assert crossed.fit.score < min(one.fit.score for one in halves)


def test_the_fit_is_worse_where_the_whole_is_moved(task: PartTask, level: FloatArray) -> None:
    moved, still = (displaced(task, np.asarray(level > edge, float)) for edge in (0.8, 2.0))
    samples = task.samples(STAGE)
    here, there = (fit_at_part(*samples, one.alignment, one.scale)[0] for one in (moved, still))
    height = samples[1].positions[:, 1]
    high = height > np.quantile(height, 0.85)
    worse = worse_by(here, there)
    assert worse[high].min() > 0.0
    assert worse[high].mean() > 2.0 * abs(worse[~high].mean())


def test_one_candidate_alone_is_not_crossed(task: PartTask, level: FloatArray) -> None:
    alone = [displaced(task, np.zeros(len(level)))]
    assert cross_parts(task, alone, STAGE, Control()) == alone


def test_a_candidate_of_two_populations_is_registered_once(
    task: PartTask, level: FloatArray
) -> None:
    """And populations do not compete: each keeps its best."""
    places = (np.zeros(len(level)), level > 0.8, level < 0.2)
    still, high, low = (displaced(task, np.asarray(one, float)).start for one in places)
    stages = [replace(STAGE, kept=2), replace(STAGE, kept=1)]
    one, other = choose_parts(task, [[high, still], [low, still, high]], stages, Control())
    assert one == other
    (alone,), _ = choose_parts(task, [[low], [still]], stages, Control())
    assert alone.fit.score > one[0].fit.score
