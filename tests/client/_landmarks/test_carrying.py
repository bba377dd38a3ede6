"""Landmarks of transfers, and merged from several templates."""

from typing import Any

import numpy as np
import pytest
from isomatch import LandmarkSet, TransferredLandmark, WrongCoordinates
from isomatch._landmarks import FromTemplate, from_transfer, merged, remarks_on, with_same_labels
from isomatch._landmarks.surface_points import nearest_points, square_root_of_area

from tests.client._landmarks.surfaces import blob, moved, surface_samples

BLOB = blob()
PLACES = surface_samples(BLOB, 6, seed=5)
GIVEN = LandmarkSet.of(
    [(f"p{row}", None if row == 2 else place) for row, place in enumerate(PLACES.tolist())]
)


def transferred(label: str, **known: Any) -> TransferredLandmark:
    nothing = dict.fromkeys(TransferredLandmark.model_fields)
    return TransferredLandmark.model_validate({**nothing, "label": label, **known})


def test_landmarks_of_a_transfer_without_a_confidence_are_missing() -> None:
    image = {"position": (1.0, 2.0, 3.0), "vertices": (1, 2, 3), "weights": (0.2, 0.3, 0.5)}
    measured = {"round_trip": 0.01, "distortion": 0.1, "from_surface": 0.002}
    one = from_transfer(
        [
            transferred("known", **image, **measured, confidence=0.8),
            transferred("missing"),
            transferred("at the edge of a part", **image, distortion=0.1, from_surface=0.0),
        ]
    )
    np.testing.assert_array_equal(one.positions[0], image["position"])
    for name, value in {**measured, "confidence": 0.8}.items():
        np.testing.assert_array_equal(getattr(one, name), [value, np.nan, np.nan])
    assert np.isnan(one.positions[1:]).all()


def test_landmarks_far_from_the_surface_are_reported() -> None:
    far = np.concatenate([PLACES[:3], PLACES[3:] * 20.0])
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
    given = wrong.positions[there]
    apart = np.linalg.norm(given - nearest_points(surface, given), axis=1)
    apart /= square_root_of_area(surface)
    assert 0 < (apart > 0.05).sum() < there.sum()
    with pytest.raises(WrongCoordinates, match=r"but none with x and y negated"):
        remarks_on(wrong, surface)
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


def carried(seed: int, shift: float, given: LandmarkSet = GIVEN, sure: float = 0.9) -> FromTemplate:
    """From one of several templates, whose positions are shifted at random by a length."""
    random = np.random.default_rng(seed)
    directions = random.standard_normal((6, 3))
    offsets = shift * directions / np.linalg.norm(directions, axis=1, keepdims=True)
    values = [np.where(given.present, value, np.nan) for value in (sure, 0.01, 0.1, 0.0)]
    return FromTemplate(given.positions + offsets, *values)


def test_one_template_is_not_changed() -> None:
    one = carried(0, 0.0)
    found = merged(GIVEN.labels, [one], np.array([0.95]), None)
    np.testing.assert_array_equal(found.positions, one.positions)
    np.testing.assert_allclose(found.confidence, one.confidence)
    assert np.isnan(found.spread).all()


def test_matches_without_any_confidence_give_landmarks_of_confidence_zero() -> None:
    one = carried(0, 0.0, sure=0.0)
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
    whole = carried(0, 0.0, LandmarkSet(GIVEN.labels, PLACES))
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
