"""The Varadhan level, between commute times and geodesic distances."""

from dataclasses import replace
from itertools import permutations

import numpy as np
import pytest

from solver.labelling import UNMATCHED
from solver.matching import (
    MatchOptions,
    add_varadhan_size,
    build_varadhan_level,
    match,
    rematch,
    uses_varadhan_level,
)
from solver.mesh import triangle_mesh
from solver.optimisation import minimise
from solver.shape import Shape
from solver.shape.choices import Geodesic
from synthetic import correspondence, human
from tests.solver import shapes


def test_only_commute_times_and_geodesics_use_a_varadhan_level() -> None:
    assert uses_varadhan_level(MatchOptions())
    assert not uses_varadhan_level(MatchOptions(metric=("commute_time",)))
    assert not uses_varadhan_level(MatchOptions(metric=("geodesic",)))
    assert not uses_varadhan_level(MatchOptions(metric=("commute_time", "biharmonic")))
    assert not uses_varadhan_level(MatchOptions(beta=0.0))
    assert not uses_varadhan_level(MatchOptions(points=8, objective="linf"))


def test_samples_of_a_level_begin_those_of_the_next() -> None:
    assert add_varadhan_size([(8, 12), (10, 40)], 642) == [(8, 12), (8, 48), (10, 48)]
    assert add_varadhan_size([(8, 12), (16, 64)], 642) == [(8, 12), (8, 48), (16, 64)]
    assert add_varadhan_size([(8, 12)], 42) == [(8, 12), (8, 42)]


def test_few_points_are_matched_twice_and_the_answer_is_of_the_second_level() -> None:
    source = Shape(shapes.blob(3))
    target = Shape(shapes.moved(shapes.blob(4), seed=3, scale=2.0))
    found = match(source, target, MatchOptions(points=6))
    coarse, decided = found.levels
    assert (coarse.metric, decided.metric) == ("commute_time", "varadhan")
    assert (coarse.points, decided.points) == (6, 6)
    # Images of the points under the registration are added to the samples.
    assert 36 <= decided.target_points <= 36 + 6
    assert 6 <= decided.candidates < 6 * decided.target_points
    assert coarse.certified
    assert decided.lower_bound <= decided.energy == found.best.energy
    assert found.best.costs.sum() == pytest.approx(found.best.energy)
    less = [other for other in found.alternatives if other.energy < found.best.energy - 1e-12]
    assert len(less) < decided.rank


def test_rematching_finds_the_best_partners_near_the_old_ones() -> None:
    """All assignments of three points within ρ covering radii: none is better."""
    source = Shape(shapes.blob(3))
    target = Shape(shapes.moved(shapes.blob(4), seed=3))
    options = MatchOptions(points=3, first_order_weight=0.0).settled(1.0)
    level = build_varadhan_level(source, target, 0, (3, 18), options)
    before = np.array([2, 0, 4])
    found = rematch(before, level, 1.2)
    moved = level.target.distances[before]
    reach = 1.2 * moved.min(axis=0).max()
    assert (found.problem.candidates == np.argwhere(moved <= reach)).all()
    whole = level.problem(level.all_candidates())
    energies = {
        places: whole.energy(np.array(places))
        for places in permutations(range(18), 3)
        if (moved[[0, 1, 2], places] <= reach).all()
    }
    best = minimise(found.problem, found.partners)
    assert len(energies) > 100
    assert best.value == pytest.approx(min(energies.values()))
    assert best.lower_bound <= best.value <= found.energy <= energies[tuple(before.tolist())]


def test_unmatched_points_have_all_candidates() -> None:
    blob = Shape(shapes.blob())
    options = MatchOptions(points=6).settled(1.0)
    level = build_varadhan_level(blob, blob, 0, (6, 36), options)
    found = rematch(np.array([0, 1, UNMATCHED, 3, 4, 5]), level, 1.0)
    assert (found.problem.candidates[:, 0] == 2).sum() == 36
    np.testing.assert_array_equal(found.partners, np.arange(6))


def test_landmarks_stay_where_they_are() -> None:
    mesh = shapes.blob()
    options = MatchOptions(points=8, landmarks=((5, 5), (40, 40), (77, 77)))
    found = match(Shape(mesh), Shape(mesh), options)
    assert len(found.levels) == 2
    np.testing.assert_array_equal(found.best.target, found.best.source)


def test_few_points_do_not_depend_on_motion_scale_and_numbering() -> None:
    one, other = shapes.blob(3), shapes.blob(4)
    order = np.random.default_rng(0).permutation(other.n_vertices)
    place = np.argsort(order)
    turned = shapes.moved(other, seed=1, scale=7.0)
    again = triangle_mesh(turned.vertices[order], place[turned.faces])
    found, moved = (
        match(Shape(one), Shape(mesh), MatchOptions(points=7)) for mesh in (other, again)
    )
    np.testing.assert_array_equal(order[moved.best.target], found.best.target)
    assert moved.best.energy == pytest.approx(found.best.energy, rel=1e-4)


def test_twisted_hypotheses_lose_at_the_varadhan_level() -> None:
    """By commute times a hand may as well be a foot of the other side."""
    walking = human("walking", resolution=900, seed=1)
    reaching = human("reaching", resolution=900, seed=2)
    source, target = (Shape(triangle_mesh(one.vertices, one.faces)) for one in (walking, reaching))
    truth = correspondence(walking, reaching)
    across = np.linalg.norm((walking.rest * [-1.0, 1.0, 1.0])[:, None] - walking.rest, axis=2)
    mirrored = truth[np.argmin(across, axis=1)]

    def worst(options: MatchOptions) -> tuple[float, list[int]]:
        found = match(source, target, replace(options, orientation=False))
        distances = target.metric(Geodesic()).distances(found.best.target)
        rows = np.arange(8)
        errors = [distances[rows, one[found.best.source]].max() for one in (truth, mirrored)]
        return float(min(errors)), [level.rank for level in found.levels]

    assert worst(MatchOptions(points=8, metric=("commute_time",)))[0] > 0.5
    error, ranks = worst(MatchOptions(points=8))
    assert error < 0.25
    assert ranks[0] > ranks[1] == 1
