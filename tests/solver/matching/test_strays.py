"""Stray components: what only one of two scans has, such as the floor, is left out."""

from dataclasses import replace

import numpy as np
import pytest

from bench import strays
from solver.control import Control
from solver.matching import MatchOptions, match
from solver.matching.strays import without_strays
from solver.mesh import triangle_mesh
from solver.shape import Shape
from synthetic import human
from tests.solver.matching.test_incomplete import errors
from tests.solver.matching.test_overlap import RESOLUTION, Cut, body

OPTIONS = MatchOptions(points=16, dense=True)
FLOOR = "left out 1 component of 576 vertices"
BALL = "left out 1 component of 642 vertices"


def with_ball(shape: Shape) -> Shape:
    """A ball of a sixth of the shape's area beside it."""
    return Shape(strays.with_ball(shape.mesh, 1.0 / 6.0, np.ones(3)))


def with_floor(shape: Shape) -> Shape:
    """A floor of half the shape's area below it."""
    return Shape(strays.with_floor(shape.mesh, up=1))


def without_hands(one: Cut, width: float) -> Shape:
    """The body with rings of its arms gone: in three pieces."""
    shape, _ = one
    rest = np.abs(human("standing", resolution=RESOLUTION, seed=1).rest[:, 0])
    ring = (rest > 0.7 * rest.max()) & (rest < (0.7 + width) * rest.max())
    kept = ~ring[shape.mesh.faces].any(axis=1)
    return Shape(triangle_mesh(shape.mesh.vertices, shape.mesh.faces[kept]))


@pytest.fixture(scope="module")
def bodies() -> tuple[Cut, Cut]:
    places = human("standing", resolution=RESOLUTION, seed=1).rest
    nothing = np.zeros(len(places), dtype=np.bool_)
    return body("walking", nothing, 1.0), body("standing", nothing, 1.0)


@pytest.mark.parametrize("swapped", [False, True])
def test_a_ball_beside_a_body_is_left_out(bodies: tuple[Cut, Cut], swapped: bool) -> None:
    """The map and its inverse are then those of the bodies alone."""
    (walking, every), (standing, _) = bodies
    shapes_matched = (with_ball(walking), standing)
    source, target = shapes_matched[::-1] if swapped else shapes_matched
    found = match(source, target, OPTIONS)
    assert any(BALL in warning for warning in found.warnings)
    assert found.dense is not None
    assert found.dense.inverse is not None
    back, there = found.dense.inverse, found.dense
    assert np.array_equal((back if swapped else there).source, every)
    assert np.isin((there if swapped else back).target, every).all()
    assert errors(found, every, bodies[not swapped][0], every).mean() < 0.05
    assert found.confidence is not None
    assert found.confidence.is_sure


def test_several_balls_are_left_out_together(bodies: tuple[Cut, Cut]) -> None:
    """Without one of them the shapes hardly fit better."""
    (walking, every), (standing, _) = bodies
    crowded = walking.mesh
    for corner in ([1.0, 1.0, 1.0], [-1.0, 1.0, 1.0], [1.0, 1.0, -1.0], [-1.0, 1.0, -1.0]):
        share = 0.15 * walking.mesh.area / crowded.area
        crowded = strays.with_ball(crowded, share, np.array(corner))
    assert crowded.components == 5
    found = match(Shape(crowded), standing, OPTIONS)
    assert any("left out 4 components" in warning for warning in found.warnings)
    assert errors(found, every, standing, every).mean() < 0.05
    assert found.confidence is not None
    assert found.confidence.is_sure


def test_both_scans_lose_what_the_other_has_not(bodies: tuple[Cut, Cut]) -> None:
    (walking, every), (standing, _) = bodies
    found = match(with_floor(walking), with_ball(standing), OPTIONS)
    assert any(f"source: {FLOOR}" in warning for warning in found.warnings)
    assert any(f"target: {BALL}" in warning for warning in found.warnings)
    assert found.dense is not None
    assert np.array_equal(found.dense.source, every)
    assert errors(found, every, standing, every).mean() < 0.05


def test_a_floor_that_both_scans_have_is_kept(bodies: tuple[Cut, Cut]) -> None:
    source, target = (with_floor(one) for one, _ in bodies)
    assert without_strays(source, target, (), Control()) == (source, target)


def test_pieces_of_a_body_are_kept(bodies: tuple[Cut, Cut]) -> None:
    pieces = without_hands(bodies[0], 0.06)
    assert pieces.mesh.components == 3
    found = match(pieces, bodies[1][0], OPTIONS)
    assert not any("left out" in warning for warning in found.warnings)
    assert found.dense is not None
    assert len(found.dense.source) == pieces.n_vertices


def test_components_that_are_asked_for_are_kept(bodies: tuple[Cut, Cut]) -> None:
    """With `partial: none`, and where a landmark is on them."""
    source, target = with_ball(bodies[0][0]), bodies[1][0]
    found = match(source, target, replace(OPTIONS, partial="none", time_limit=1.0))
    assert found.dense is not None
    assert len(found.dense.source) == source.n_vertices
    on_ball = ((source.n_vertices - 1, 0),)
    assert without_strays(source, target, on_ball, Control()) == (source, target)
    assert without_strays(source, target, ((0, 0),), Control())[0] is not source


def test_half_a_body_with_a_floor_is_matched_without_it(bodies: tuple[Cut, Cut]) -> None:
    rest = human("standing", resolution=RESOLUTION, seed=1).rest
    half, kept = body("reaching", rest[:, 1] < np.median(rest[:, 1]), 1.0)
    found = match(with_floor(half), bodies[1][0], OPTIONS)
    assert found.overlap is not None
    assert found.overlap.part == "source"
    assert any(f"source: {FLOOR}" in warning for warning in found.warnings)
    assert errors(found, kept, *bodies[1]).mean() < 0.05
