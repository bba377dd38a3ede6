"""Landmarks carried along maps, and merged from several templates."""

import numpy as np
import numpy.typing as npt
import pytest
from isomatch import Geometry, LandmarkSet, VertexMap, WrongCoordinates
from isomatch._landmarks import (
    PlacedLandmarks,
    carried_landmarks,
    remarks_on,
    with_same_labels,
)
from isomatch._landmarks.carrying import FromTemplate, from_template, merged
from isomatch._landmarks.confidence import confidence, local_distortion, square_root_of_area
from isomatch._landmarks.surface_points import nearest_points
from scipy.spatial.transform import Rotation

from tests.client._landmarks.surfaces import blob, identity, moved, surface_samples
from tests.client._results.test_transfer import MATCH

BLOB = blob()
TURN = Rotation.from_rotvec([0.4, -1.0, 2.0]).as_matrix()
TURNED = moved(BLOB, 3.0 * BLOB.vertices @ TURN.T + [5.0, 1.0, -2.0])
BENT = moved(
    BLOB, BLOB.vertices + 0.4 * np.sin(2.0 * BLOB.vertices[:, [1, 2, 0]]) * [1.0, 0.5, -1.0]
)
PLACES = surface_samples(BLOB, 6, seed=5)
GIVEN = LandmarkSet.of(
    [(f"p{row}", None if row == 2 else place) for row, place in enumerate(PLACES.tolist())]
)
MAPS = identity(BLOB), identity(BLOB)


def test_a_similarity_carries_exactly_and_leaves_out_what_is_missing() -> None:
    one = from_template(PlacedLandmarks.of(GIVEN, BLOB), MAPS, 0.99, TURNED)
    there = GIVEN.present
    expected = 3.0 * PLACES @ TURN.T + [5.0, 1.0, -2.0]
    np.testing.assert_allclose(one.positions[there], expected[there], atol=1e-8)
    for measure in (one.round_trip, one.distortion, one.from_surface):
        np.testing.assert_allclose(measure[there], 0.0, atol=1e-7)
    for values in (one.positions, one.confidence, one.round_trip):
        assert np.isnan(values[2]).all()


def test_landmarks_off_the_surface_are_carried_from_the_nearest_point() -> None:
    outwards = PLACES * 1.05
    one = from_template(
        PlacedLandmarks.of(LandmarkSet(GIVEN.labels, outwards), BLOB), MAPS, 0.99, TURNED
    )
    nearest = nearest_points(BLOB, outwards).positions(BLOB)
    np.testing.assert_allclose(one.positions, 3.0 * nearest @ TURN.T + [5.0, 1.0, -2.0])
    size = square_root_of_area(BLOB)
    assert (one.from_surface > 0.0).all()
    assert (one.from_surface <= np.linalg.norm(outwards - PLACES, axis=1) / size).all()


def test_landmarks_far_from_the_surface_are_reported_and_missing() -> None:
    far = np.concatenate([PLACES[:3], PLACES[3:] * 20.0])
    one = from_template(
        PlacedLandmarks.of(LandmarkSet(GIVEN.labels, far), BLOB), MAPS, 0.99, TURNED
    )
    assert np.isnan(one.confidence).tolist() == 3 * [False] + 3 * [True]
    assert np.isnan(one.positions[3:]).all()
    (text,) = remarks_on(LandmarkSet(GIVEN.labels, far), BLOB)
    assert text.startswith("3 of 6 landmarks are far from the surface, 'p")
    assert all(f"{label!r} by " in text for label in GIVEN.labels[3:])
    assert text.endswith("; they are left out")
    (text,) = remarks_on(LandmarkSet(GIVEN.labels, np.vstack([PLACES[:5], far[5:]])), BLOB)
    assert text.startswith("1 of 6 landmarks is far from the surface, ")
    assert text.endswith("; it is left out")
    assert remarks_on(GIVEN, BLOB) == ()


def test_landmarks_that_are_all_far_or_missing_are_refused() -> None:
    with pytest.raises(ValueError, match=r"6 of 6 landmarks are far .*: check the unit of length"):
        remarks_on(LandmarkSet(GIVEN.labels, PLACES * 2.0), BLOB)
    with pytest.raises(ValueError, match="all landmarks are missing"):
        remarks_on(LandmarkSet(GIVEN.labels, np.full_like(PLACES, np.nan)), BLOB)


def test_landmarks_in_another_coordinate_system_are_refused_if_only_some_are_far() -> None:
    there = GIVEN.present
    offset = np.array([0.0, 0.15, 0.0])
    surface = moved(BLOB, offset + BLOB.vertices)
    right = LandmarkSet(GIVEN.labels, offset + GIVEN.positions)
    wrong = right.flipped()
    nearest = nearest_points(surface, wrong.positions[there]).positions(surface)
    apart = np.linalg.norm(wrong.positions[there] - nearest, axis=1) / square_root_of_area(surface)
    assert 0 < (apart > 0.05).sum() < there.sum()
    with pytest.raises(WrongCoordinates, match=r"but none with x and y negated"):
        remarks_on(wrong, surface)
    with pytest.raises(WrongCoordinates):
        PlacedLandmarks.of(wrong, surface)
    # One that is misplaced does not turn the others.
    misplaced = right.positions.copy()
    misplaced[0] *= 20.0
    (text,) = remarks_on(LandmarkSet(GIVEN.labels, misplaced), surface)
    assert text.startswith("1 of 5 landmarks is far from the surface, 'p0' by ")


def test_landmarks_beside_the_surface_are_reported_if_negating_brings_them_nearer() -> None:
    """As on a bone that is round about the z axis: none is far."""
    offset = np.array([0.0, 0.05, 0.0])
    surface = moved(BLOB, offset + BLOB.vertices)
    right = LandmarkSet(GIVEN.labels, offset + GIVEN.positions)
    assert remarks_on(right, surface) == ()
    (text,) = remarks_on(right.flipped(), surface)
    assert text.startswith("the landmarks lie beside the surface; with x and y negated")


def restricted(along: VertexMap, vertices: npt.NDArray[np.int64]) -> VertexMap:
    """The map of some of its vertices."""
    kept = np.isin(along.vertices, vertices)
    return VertexMap(*(values[kept] for values in vars(along).values()))


def test_landmarks_on_what_a_part_lacks_are_missing() -> None:
    rows = np.flatnonzero(BLOB.vertices[:, 2] < 0.3)
    part = Geometry(BLOB.vertices, BLOB.faces[np.isin(BLOB.faces, rows).all(axis=1)],
                    BLOB.vertex_ids, None)  # fmt: skip
    whole, rows = identity(BLOB), np.unique(part.faces)
    # As at the edge of a cover, the lowest vertex has a partner, and those round it have none.
    lowest = rows[BLOB.vertices[rows, 2].argmin()]
    ring = np.unique(part.faces[(part.faces == lowest).any(axis=1)])
    there = restricted(whole, BLOB.vertex_ids[np.setdiff1d(rows, ring[ring != lowest])])
    back = restricted(whole, BLOB.vertex_ids[rows])
    inside = int(rows[np.abs(BLOB.vertices[rows, 2] + 0.3).argmin()])
    # The map back goes astray, to that vertex.
    back.faces[rows == inside] = whole.faces[lowest]
    back.weights[rows == inside] = whole.weights[lowest]
    places = BLOB.vertices[[inside, lowest, BLOB.vertices[:, 2].argmax()]]
    given = LandmarkSet(("inside", "uncovered", "lacking"), places)
    one = from_template(PlacedLandmarks.of(given, BLOB), (there, back), 0.99, part)
    for values in (one.positions[:, 0], one.confidence, one.round_trip, one.distortion):
        assert np.isnan(values).tolist() == [False, True, True]
    np.testing.assert_allclose(one.positions[0], places[0], atol=1e-9)
    astray = np.linalg.norm(places[0] - places[1]) / square_root_of_area(BLOB)
    np.testing.assert_allclose(one.round_trip[0], astray)


def test_landmarks_whose_image_has_no_partner_are_missing() -> None:
    low = BLOB.vertex_ids[BLOB.vertices[:, 2] < 0.3]
    places = BLOB.vertices[[BLOB.vertices[:, 2].argmin(), BLOB.vertices[:, 2].argmax()]]
    maps = identity(BLOB), restricted(identity(BLOB), low)
    one = from_template(
        PlacedLandmarks.of(LandmarkSet(("low", "high"), places), BLOB), maps, 0.99, BLOB
    )
    assert np.isnan(one.confidence).tolist() == [False, True]


def test_a_part_is_not_distorted_at_its_scale() -> None:
    """Its area is not that of the specimen."""
    rows = np.flatnonzero(BLOB.vertices[:, 2] < 0.3)
    faces = BLOB.faces[np.isin(BLOB.faces, rows).all(axis=1)]
    part = Geometry(BLOB.vertices, faces, BLOB.vertex_ids, None)
    there = restricted(identity(BLOB), BLOB.vertex_ids[np.unique(faces)])
    point = BLOB.vertices[[BLOB.vertices[:, 2].argmin()]]
    assert local_distortion(part, there, TURNED, point, 3.0).max() < 1e-7
    assert local_distortion(part, there, TURNED, point).min() > 0.05


def test_distortion_is_that_of_the_best_rotation() -> None:
    whole = identity(BLOB)
    assert (local_distortion(BLOB, whole, TURNED, PLACES) < 1e-7).all()
    found = local_distortion(BLOB, whole, BENT, PLACES)
    size, other_size = square_root_of_area(BLOB), square_root_of_area(BENT)
    turns = Rotation.random(300, rng=np.random.default_rng(1)).as_matrix()
    for place, value in zip(PLACES, found, strict=True):
        # The blob has no limbs, so that what is near in space is near on the surface.
        near = np.linalg.norm(BLOB.vertices - place, axis=1) <= 0.1 * size
        here, there = BLOB.vertices[near] / size, BENT.vertices[near] / other_size
        here, there = here - here.mean(axis=0), there - there.mean(axis=0)
        apart = np.linalg.norm(here @ turns - there, axis=2)
        assert 0.0 < value <= np.sqrt((apart**2).mean(axis=1)).min() / 0.1 + 1e-9


def test_confidence_falls_with_doubt_round_trip_and_distortion() -> None:
    some = np.linspace(0.0, 0.3, 7)
    none = np.zeros(7)
    for values in (confidence(0.9, some, none), confidence(0.9, none, some)):
        assert (np.diff(values) < 0.0).all()
        assert ((values > 0.0) & (values < 1.0)).all()
    for said in (0.2, 0.99):
        assert (confidence(said, some, some) < said).all()


def carried(seed: int, shift: float, probability: float = 0.95) -> FromTemplate:
    """From one of several templates, whose positions are shifted at random by a length."""
    random = np.random.default_rng(seed)
    one = from_template(PlacedLandmarks.of(GIVEN, BLOB), MAPS, probability, BLOB)
    directions = random.standard_normal((6, 3))
    offsets = shift * directions / np.linalg.norm(directions, axis=1, keepdims=True)
    one.positions[:] += offsets
    return one


def test_one_template_is_not_changed() -> None:
    one = carried(0, 0.0)
    found = merged(GIVEN.labels, [one], np.array([0.95]), BLOB)
    np.testing.assert_array_equal(found.positions, one.positions)
    np.testing.assert_allclose(found.confidence, one.confidence)
    assert np.isnan(found.spread).all()


def test_matches_without_any_confidence_give_landmarks_of_confidence_zero() -> None:
    one = from_template(PlacedLandmarks.of(GIVEN, BLOB), MAPS, 0.0, BLOB)
    found = merged(GIVEN.labels, [one, one], np.zeros(2), BLOB)
    np.testing.assert_array_equal(found.confidence[GIVEN.present], 0.0)
    np.testing.assert_allclose(found.positions[GIVEN.present], PLACES[GIVEN.present], atol=1e-6)


def test_a_template_far_from_the_others_moves_nothing() -> None:
    far = 0.5 * square_root_of_area(BLOB)
    each = [carried(0, 0.0), carried(1, 0.0), carried(2, far)]
    found = merged(GIVEN.labels, each, np.array([0.95] * 3), BLOB)
    there = GIVEN.present
    np.testing.assert_allclose(found.positions[there], PLACES[there], atol=1e-6)
    np.testing.assert_allclose(found.confidence[there], 2.0 / 3.0 * each[0].confidence[there])
    np.testing.assert_allclose(found.spread[there], 0.5 / 3.0, rtol=1e-6)
    sure = merged(GIVEN.labels, each[:2], np.array([0.95] * 2), BLOB)
    np.testing.assert_allclose(sure.confidence[there], each[0].confidence[there])
    assert np.isnan(sure.confidence[2])
    assert np.isnan(sure.positions[2]).all()


def test_a_landmark_that_one_template_lacks_comes_from_the_other() -> None:
    whole = from_template(
        PlacedLandmarks.of(LandmarkSet(GIVEN.labels, PLACES), BLOB), MAPS, 0.95, BLOB
    )
    found = merged(GIVEN.labels, [carried(0, 0.0), whole], np.array([0.95] * 2), BLOB)
    np.testing.assert_allclose(found.positions, PLACES, atol=1e-6)
    assert np.isnan(found.spread).tolist() == [False, False, True, False, False, False]
    said = found.landmark_set("a")
    assert said.name == "a"
    assert said.descriptions[2].startswith("confidence 0.")


def test_labels_of_templates_are_brought_into_one_order() -> None:
    _, second = with_same_labels([GIVEN, LandmarkSet(GIVEN.labels[::-1], PLACES[::-1])])
    assert second.labels == GIVEN.labels
    np.testing.assert_array_equal(second.positions, PLACES)
    other = LandmarkSet.of([("p0", None)])
    for sets, having, lacking in (([GIVEN, other], 1, 2), ([other, GIVEN], 2, 1)):
        with pytest.raises(
            ValueError,
            match="template 1 and template 2 do not have the same landmarks:"
            f" template {having} has 'p1' and 4 more, template {lacking} does not",
        ):
            with_same_labels(sets)
    twice = [LandmarkSet.of([("a", None), (last, None), ("b", None)]) for last in "ab"]
    with pytest.raises(
        ValueError, match=r"x\.csv and y\.csv do not .* x\.csv has 'a', y\.csv does"
    ):
        with_same_labels(twice, ["x.csv", "y.csv"])
    turned = [LandmarkSet.of([(label, None) for label in order]) for order in ("aab", "aba")]
    with pytest.raises(ValueError, match="landmarks of the same label in different orders"):
        with_same_labels(turned)


def test_labels_that_recur_are_reported() -> None:
    twice = LandmarkSet(("p", "q", "p", "r", "q", "p"), PLACES)
    assert remarks_on(twice, BLOB) == (
        "3 landmarks are called 'p'; only their order tells them apart",
        "2 landmarks are called 'q'; only their order tells them apart",
    )


def test_matches_without_a_map_carry_nothing() -> None:
    sparse = MATCH.model_copy(update={"dense": None})
    with pytest.raises(ValueError, match="dense matches with a confidence"):
        carried_landmarks([PlacedLandmarks.of(GIVEN, BLOB)], [sparse], BLOB)
