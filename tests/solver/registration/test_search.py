"""Search: when it ends, and what it returns."""

from itertools import combinations
from typing import NoReturn

import numpy as np
import pytest

from solver.arrays import FloatArray
from solver.control import Control
from solver.errors import MeshError
from solver.mesh import triangle_mesh
from solver.registration.choice import SAME, Task
from solver.registration.comparison import compare
from solver.registration.confidence import RIVAL
from solver.registration.reduction import FEW_VERTICES, ReducedTask
from solver.registration.search import first_found, search
from solver.registration.surface import smooth_surface
from solver.shape import Shape
from tests.solver.shapes import icosphere


@pytest.fixture(scope="module")
def ellipsoids() -> tuple[Shape, Shape]:
    """One lies on the other in four ways."""
    sphere = icosphere(3)
    one, other = (
        Shape(triangle_mesh(sphere.vertices * axes, sphere.faces))
        for axes in ([1.0, 0.7, 1.8], [1.1, 0.7, 1.7])
    )
    return one, other


def cannot_be_reduced(left: int) -> NoReturn:
    raise MeshError(f"nothing can be displaced with {left} vertices")


def test_beyond_doubt_nothing_is_refined(blob: Shape) -> None:
    asked: list[int] = []

    def reduced(left: int) -> ReducedTask:
        asked.append(left)
        return ReducedTask.entire(Task.of(blob, blob))

    found = search(Task.of(blob, blob), reduced, (), Control())
    assert found.confidence.probability > 0.99
    assert not asked
    np.testing.assert_array_equal(
        found.candidates[0].images,
        smooth_surface(blob).samples.first(len(found.candidates[0].images)).vertices,
    )


def stone(seed: int, height: float = 0.1) -> Shape:
    """A ball with low waves in all directions."""
    random, sphere = np.random.default_rng(seed), icosphere(3)
    phases = sphere.vertices @ (2.2 * random.standard_normal((3, 14)))
    waves = np.cos(phases + random.uniform(0.0, 2.0 * np.pi, 14))
    heights = height * (waves @ random.standard_normal(14)) / np.sqrt(7.0)
    return Shape(triangle_mesh(sphere.vertices * (1.0 + heights[:, None]), sphere.faces))


def test_round_surfaces_whose_curvatures_disagree_are_doubted() -> None:
    """Whatever the map, their normals and distances change little."""
    task = Task.of(stone(0), stone(1))
    assert first_found(task, (), Control()).confidence.probability > 0.99
    found = search(task, lambda left: ReducedTask.entire(task), (), Control(), others=False)
    assert found.confidence.probability < 0.5
    alike = Task.of(stone(0), stone(0, 0.11))
    found = search(alike, cannot_be_reduced, (), Control())
    assert found.confidence.probability > 0.99


def test_in_doubt_those_that_differ_are_compared(ellipsoids: tuple[Shape, Shape]) -> None:
    task = Task.of(*ellipsoids)
    found = search(task, lambda left: ReducedTask.entire(task), (), Control(), others=False)
    assert found.confidence.reasons == (RIVAL,)
    assert len(found.candidates) >= 4
    compared = compare(ReducedTask.entire(task), found.candidates, Control())
    for one, other in combinations((one.image_positions for one in compared), 2):
        assert np.linalg.norm(one - other, axis=1).mean() > SAME


def test_what_cannot_be_refined_is_mapped_by_eigenfunctions(
    ellipsoids: tuple[Shape, Shape],
) -> None:
    found = search(Task.of(*ellipsoids), cannot_be_reduced, (), Control())
    scores = [one.fit.score for one in found.candidates]
    assert scores == sorted(scores)
    assert "refined_score" not in found.confidence.measures


def test_rivals_are_told_apart_by_what_few_vertices_do_not_show() -> None:
    """One ellipsoid lies on the other in four ways, but for knobs."""
    sphere = icosphere(4)
    centres = np.random.default_rng(4).standard_normal((20, 3))
    centres /= np.linalg.norm(centres, axis=1, keepdims=True)
    apart = np.linalg.norm(sphere.vertices[:, None] - centres, axis=2)
    knobs = 1.0 + 0.05 * np.exp(-((apart / 0.1) ** 2)).sum(axis=1, keepdims=True)
    axes = [1.0, 0.7, 1.8], [1.1, 0.7, 1.7]

    def task(radius: FloatArray) -> Task:
        one, other = (
            Shape(triangle_mesh(sphere.vertices * radius * by, sphere.faces)) for by in axes
        )
        return Task.of(one, other)

    plain, knobbly = task(np.ones_like(knobs)), task(knobs)

    def reduced(left: int) -> ReducedTask:
        if left != FEW_VERTICES:
            return ReducedTask.entire(knobbly)
        here, there = (one.vertices for one in plain.samples)
        return ReducedTask(plain, (knobbly.source.at(here), knobbly.target.at(there)))

    found = search(knobbly, reduced, (), Control(), others=False)
    images = found.candidates[0].images
    truth = knobbly.samples[0].first(len(images)).vertices
    apart = np.linalg.norm(knobbly.positions[images] - knobbly.positions[truth], axis=1)
    assert apart.mean() < 0.05
    assert found.confidence.probability > 0.5
