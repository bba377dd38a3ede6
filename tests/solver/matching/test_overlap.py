"""Matches of two surfaces that overlap, neither a part of the other: one body, cut twice."""

from dataclasses import replace

import numpy as np
import pytest

from solver.arrays import BoolArray, IntArray
from solver.errors import OptionError
from solver.matching import Match, MatchOptions, Overlap, match
from solver.mesh import triangle_mesh
from solver.shape import Shape
from synthetic import human, submesh

RESOLUTION = 700
OPTIONS = MatchOptions(points=16, dense=True, partial="both")
SCALE = 4.0

Cut = tuple[Shape, IntArray]
"""A surface, and the vertices of the body that it has."""


def body(pose: str, lacking: BoolArray, scale: float) -> Cut:
    """A body in a pose, without some of its vertices, in other units."""
    whole = human(pose, resolution=len(lacking), seed=1)
    mesh = triangle_mesh(scale * whole.vertices, whole.faces)
    vertices, mesh = submesh(mesh, ~np.any(lacking[mesh.faces], axis=1))
    assert mesh.components == 1
    return Shape(mesh), vertices


@pytest.fixture(scope="module")
def without_a_leg() -> Cut:
    """The walking body without what is below one hip."""
    rest = human("standing", resolution=RESOLUTION, seed=1).rest
    low = rest[:, 1] < rest[:, 1].min() + 0.42 * np.ptp(rest[:, 1])
    return body("walking", low & (rest[:, 0] > 0.0), 1.0)


@pytest.fixture(scope="module")
def without_an_arm() -> Cut:
    """The standing body without an arm and a piece of the shoulder, in other units."""
    rest = human("standing", resolution=RESOLUTION, seed=1).rest
    return body("standing", rest[:, 0] < -0.16 * np.ptp(rest[:, 1]), SCALE)


@pytest.fixture(scope="module")
def found(without_a_leg: Cut, without_an_arm: Cut) -> Match:
    return match(without_a_leg[0], without_an_arm[0], OPTIONS)


@pytest.fixture(scope="module")
def swapped(without_a_leg: Cut, without_an_arm: Cut) -> Match:
    return match(without_an_arm[0], without_a_leg[0], OPTIONS)


def overlap_of(found: Match) -> Overlap:
    assert found.overlap is not None
    return found.overlap


def covered(one: Cut, other: Cut) -> BoolArray:
    """(V,) vertices of a surface that the other one has, too."""
    return np.isin(one[1], other[1])


def f1(found: BoolArray, true: BoolArray) -> float:
    """F1 score of the vertices without a partner."""
    both = (~found & ~true).sum()
    return float(2.0 * both / ((~found).sum() + (~true).sum()))


def mapped(found: Match, count: int) -> BoolArray:
    assert found.dense is not None
    return np.isin(np.arange(count), found.dense.source)


def test_vertices_go_where_they_are_on_the_other(
    without_a_leg: Cut, without_an_arm: Cut, found: Match
) -> None:
    here, (target, there) = without_a_leg[1], without_an_arm
    assert found.dense is not None
    points = found.dense.source
    common = np.isin(here[points], there)
    truth = np.searchsorted(there, here[points[common]])
    distances = target.metric("geodesic").distances(truth)
    errors = distances[np.arange(len(truth)), found.dense.target[common]]
    assert errors.mean() < 0.05


def test_vertices_without_a_partner_are_left_out_on_both_sides(
    without_a_leg: Cut, without_an_arm: Cut, found: Match, swapped: Match
) -> None:
    ours = mapped(found, without_a_leg[0].n_vertices)
    theirs = mapped(swapped, without_an_arm[0].n_vertices)
    assert f1(ours, covered(without_a_leg, without_an_arm)) > 0.75
    assert f1(theirs, covered(without_an_arm, without_a_leg)) > 0.75


def test_roles_do_not_matter(found: Match, swapped: Match) -> None:
    assert found.dense is not None
    assert swapped.dense is not None
    assert found.dense.inverse is not None
    assert swapped.dense.inverse is not None
    np.testing.assert_array_equal(found.dense.source, swapped.dense.inverse.source)
    np.testing.assert_array_equal(found.dense.inverse.source, swapped.dense.source)
    np.testing.assert_array_equal(found.dense.faces, swapped.dense.inverse.faces)
    there, back = overlap_of(found), overlap_of(swapped)
    assert (there.source, there.target) == (back.target, back.source)
    assert there.scale * back.scale == pytest.approx(1.0)


def test_the_overlap_is_told(without_a_leg: Cut, without_an_arm: Cut, found: Match) -> None:
    overlap = overlap_of(found)
    assert overlap.part == "both"
    assert overlap.scale == pytest.approx(SCALE, rel=0.1)
    for share, (one, other) in (
        (overlap.source, (without_a_leg, without_an_arm)),
        (overlap.target, (without_an_arm, without_a_leg)),
    ):
        true = one[0].spectrum().mass[covered(one, other)].sum()
        assert share == pytest.approx(true, abs=0.08)


def test_points_without_a_partner_stay_unmatched(
    without_a_leg: Cut, without_an_arm: Cut, found: Match
) -> None:
    there = covered(without_a_leg, without_an_arm)
    best = found.best
    assert len(best.source) + len(best.unmatched) == 16
    assert there[best.source].mean() > 0.8
    assert set(best.source) <= set(found.dense.source if found.dense is not None else ())


def test_the_answer_is_certified(found: Match, swapped: Match) -> None:
    for one in (found, swapped):
        assert one.certified
        assert one.lower_bound <= one.best.energy
        assert one.proof is not None
        assert one.proof.lower_bound <= one.proof.energy <= one.best.energy * (1 + 1e-9)


def test_a_given_scale_and_landmarks_are_kept(without_a_leg: Cut, without_an_arm: Cut) -> None:
    common = np.intersect1d(without_a_leg[1], without_an_arm[1])[::300]
    pairs = (np.searchsorted(one[1], common) for one in (without_a_leg, without_an_arm))
    landmarks = tuple(zip(*(one.tolist() for one in pairs), strict=True))
    ours, theirs = (Shape(one.mesh, normalise=False) for one, _ in (without_a_leg, without_an_arm))
    options = replace(OPTIONS, landmarks=landmarks)
    found = match(ours, Shape(theirs.mesh.scaled(1.0 / SCALE), normalise=False), options)
    assert overlap_of(found).scale == pytest.approx(1.0)
    assert set(landmarks) <= set(zip(found.best.source, found.best.target, strict=True))
    assert f1(mapped(found, ours.n_vertices), covered(without_a_leg, without_an_arm)) > 0.65


def test_what_overlaps_is_not_refined(without_a_leg: Cut) -> None:
    with pytest.raises(OptionError) as caught:
        match(without_a_leg[0], without_a_leg[0], replace(OPTIONS, refine="gmds"))
    assert caught.value.field == "refine"


def test_the_minimax_objective_has_no_overlap() -> None:
    with pytest.raises(OptionError) as caught:
        MatchOptions(partial="both", objective="linf", points=8)
    assert caught.value.field == "partial"
