"""Matches of a part and a whole."""

from dataclasses import replace

import numpy as np
import pytest

from solver.arrays import IntArray
from solver.errors import OptionError
from solver.matching import Match, MatchOptions, match
from solver.mesh import simplified, triangle_mesh
from solver.registration.confidence import RIVAL
from solver.shape import Shape
from synthetic import human, submesh
from tests.solver.shapes import icosphere, plane_grid

RESOLUTION = 700
OPTIONS = MatchOptions(points=16, dense=True)


@pytest.fixture(scope="module")
def whole() -> Shape:
    body = human("standing", resolution=RESOLUTION, seed=1)
    return Shape(triangle_mesh(body.vertices, body.faces))


@pytest.fixture(scope="module")
def half() -> tuple[Shape, IntArray]:
    """The walking body without an arm and a leg, in other units; and its vertices of the whole."""
    body = human("walking", resolution=RESOLUTION, seed=1)
    mesh = triangle_mesh(5.0 * body.vertices, body.faces)
    side = mesh.vertices[:, 0] / np.ptp(mesh.vertices[:, 0])
    vertices, part = submesh(mesh, np.all(side[mesh.faces] > np.median(side) - 0.1, axis=1))
    assert part.components == 1
    return Shape(part), vertices


@pytest.fixture(scope="module")
def without_leg() -> tuple[Shape, IntArray]:
    """The walking body without a leg, and its vertices of the whole."""
    body = human("walking", resolution=RESOLUTION, seed=1)
    mesh = triangle_mesh(body.vertices, body.faces)
    side, height, _ = mesh.vertices.T
    leg = (side > np.median(side)) & (height < np.quantile(height, 0.3))
    vertices, part = submesh(mesh, ~leg[mesh.faces].any(axis=1))
    assert part.components == 1
    return Shape(part), vertices


@pytest.fixture(scope="module")
def of_part(whole: Shape, half: tuple[Shape, IntArray]) -> Match:
    """Which of them is the part is not said."""
    return match(half[0], whole, OPTIONS)


@pytest.fixture(scope="module")
def of_whole(whole: Shape, half: tuple[Shape, IntArray]) -> Match:
    return match(whole, half[0], replace(OPTIONS, partial="target"))


def errors(whole: Shape, answer: IntArray, truth: IntArray) -> float:
    distances = whole.metric("geodesic").distances(truth)
    return float(distances[np.arange(len(truth)), answer].mean())


def test_points_of_the_part_go_where_they_were(
    whole: Shape, half: tuple[Shape, IntArray], of_part: Match
) -> None:
    best, (_, vertices) = of_part.best, half
    assert len(best.source) + len(best.unmatched) == 16
    assert len(best.source) >= 12
    assert errors(whole, best.target, vertices[best.source]) < 0.06


def test_points_that_the_part_lacks_stay_unmatched(
    whole: Shape, half: tuple[Shape, IntArray], of_whole: Match
) -> None:
    best, (_, vertices) = of_whole.best, half
    lacking = ~np.isin(np.arange(whole.n_vertices), vertices)
    assert lacking[best.unmatched].mean() > 0.6
    assert lacking[best.source].mean() < 0.2
    assert errors(whole, vertices[best.target], best.source) < 0.06


def test_the_answer_is_certified(of_part: Match, of_whole: Match) -> None:
    for found in (of_part, of_whole):
        assert found.certified
        assert found.lower_bound <= found.best.energy
        assert found.proof is not None
        assert found.proof.lower_bound <= found.proof.energy <= found.best.energy * (1 + 1e-9)


def test_the_overlap_is_told(
    whole: Shape, half: tuple[Shape, IntArray], of_part: Match, of_whole: Match
) -> None:
    there, back = of_part.overlap, of_whole.overlap
    assert there is not None
    assert back is not None
    assert (there.part, back.part) == ("source", "target")
    assert (there.source, back.target) == (1.0, 1.0)
    share = whole.spectrum().mass[half[1]].sum()
    assert there.target == pytest.approx(share, abs=0.1)
    assert there.target == pytest.approx(back.source)
    assert there.scale == pytest.approx(0.2, rel=0.11)
    assert there.scale * back.scale == pytest.approx(1.0)


def test_vertices_without_a_partner_are_not_mapped(of_whole: Match, of_part: Match) -> None:
    assert of_whole.dense is not None
    assert of_part.dense is not None
    assert len(of_whole.dense.source) < RESOLUTION
    assert of_part.dense.inverse is not None
    np.testing.assert_array_equal(of_whole.dense.source, of_part.dense.inverse.source)


def test_a_part_that_is_sure_is_not_matched_as_a_whole(of_part: Match) -> None:
    assert of_part.overlap is not None
    assert of_part.overlap.part == "source"
    assert "coarse matching" not in of_part.timings


def test_a_body_without_a_leg_is_detected_as_a_part(
    whole: Shape, without_leg: tuple[Shape, IntArray]
) -> None:
    """What it lacks tells, as its boundary is short."""
    part, vertices = without_leg
    assert part.mesh.relative_boundary < 1.0
    found = match(whole, part, OPTIONS)
    assert found.overlap is not None
    assert found.overlap.part == "target"
    assert errors(whole, vertices[found.best.target], found.best.source) < 0.06


def test_whole_surfaces_are_no_parts(whole: Shape) -> None:
    body = human("walking", resolution=RESOLUTION, seed=2)
    found = match(whole, Shape(triangle_mesh(body.vertices, body.faces)), OPTIONS)
    assert found.overlap is None


def test_surfaces_that_are_all_boundary_are_matched_as_wholes() -> None:
    """Nothing on them is inside the other, so that no part is found."""
    ours, theirs = Shape(plane_grid(30, 2)), Shape(plane_grid(25, 2))
    options = MatchOptions(points=8)
    found = match(ours, theirs, options)
    assert found.overlap is None
    assert found.best.energy == match(ours, theirs, replace(options, partial="none")).best.energy
    with pytest.raises(OptionError, match="match them as wholes"):
        match(ours, theirs, replace(options, partial="source"))


def test_a_symmetric_sheet_is_no_part_of_itself() -> None:
    """Its own eight symmetries cast doubt on the answer; but it fits as a whole."""
    sheet = Shape(plane_grid(9, 9, 1.0))
    found = match(sheet, sheet, MatchOptions(points=12))
    assert found.overlap is None
    assert found.best.energy == pytest.approx(0.0, abs=1e-9)
    assert found.confidence is not None
    assert found.confidence.reasons == (RIVAL,)


def test_fewer_points_than_asked_for_are_said(whole: Shape, half: tuple[Shape, IntArray]) -> None:
    few = Shape(simplified(half[0].mesh, 80), normalise=False)
    larger = triangle_mesh(5.0 * whole.mesh.vertices, whole.mesh.faces)
    options = MatchOptions(points=100, partial="source")
    found = match(few, Shape(larger, normalise=False), options)
    assert len(found.best.source) + len(found.best.unmatched) == few.n_vertices
    assert any(f"only {few.n_vertices} points could be matched" in one for one in found.warnings)


def test_options_that_parts_do_not_have_are_named(
    whole: Shape, half: tuple[Shape, IntArray]
) -> None:
    given = MatchOptions(
        points=8,
        partial="source",
        third_order=0.1,
        metric=("geodesic",),
        descriptor=("none",),
        time_limit=1.0,
    )
    found = match(half[0], whole, given)
    (warning,) = (one for one in found.warnings if "no effect" in one)
    assert "at one level" in warning
    assert warning.endswith("`descriptor` and `third_order` have no effect")


def test_nothing_is_looked_for_that_is_not_wanted(
    whole: Shape, without_leg: tuple[Shape, IntArray]
) -> None:
    found = match(without_leg[0], whole, replace(OPTIONS, partial="none", points=8))
    assert found.overlap is None
    assert found.dense is not None
    assert found.dense.inverse is not None
    assert len(found.dense.inverse.source) == whole.n_vertices


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_landmarks_choose_between_symmetric_answers(side: float) -> None:
    """An ellipsoid with a hole at its end may lie on the whole one in four ways."""
    sphere = icosphere(3)
    ellipsoid = triangle_mesh(sphere.vertices * np.array([1.0, 0.7, 1.8]), sphere.faces)
    low = ellipsoid.vertices[:, 2] < 1.2
    part = submesh(ellipsoid, np.all(low[ellipsoid.faces], axis=1))[1]
    ours, theirs = part.vertices, ellipsoid.vertices
    side_point = int(ours[:, 0].argmax()), int((side * theirs[:, 0]).argmax())
    landmarks = side_point, (int(ours[:, 2].argmin()), int(theirs[:, 2].argmin()))
    options = MatchOptions(points=8, dense=True, partial="source", landmarks=landmarks)
    found = match(Shape(part), Shape(ellipsoid), options)
    assert set(landmarks) <= set(zip(found.best.source, found.best.target, strict=True))
    assert found.dense is not None
    turned = ours[found.dense.source] * np.array([side, side, 1.0])
    assert np.linalg.norm(theirs[found.dense.target] - turned, axis=1).mean() < 0.2


def test_a_landmark_that_is_missing_is_named(whole: Shape, half: tuple[Shape, IntArray]) -> None:
    lacking = whole.n_vertices
    with pytest.raises(OptionError) as caught:
        match(half[0], whole, MatchOptions(partial="source", landmarks=((0, lacking),)))
    assert caught.value.field == "landmarks.0.1"


def test_a_part_is_not_refined(whole: Shape) -> None:
    with pytest.raises(OptionError) as caught:
        match(whole, whole, MatchOptions(partial="target", refine="gmds"))
    assert caught.value.field == "refine"


def test_the_minimax_objective_has_no_parts() -> None:
    with pytest.raises(OptionError) as caught:
        MatchOptions(partial="source", objective="linf", points=8)
    assert caught.value.field == "partial"
