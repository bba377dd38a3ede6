"""Attributes by kind: which are selected, and how they are carried."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from solver.errors import OptionError, TransferError
from solver.transfer import (
    COLORS,
    LABELS,
    SCALARS,
    SKINNING,
    VECTORS,
    Attribute,
    PullBack,
    carried,
    selected,
)
from solver.transfer.skinning import normalised_weights, strongest_weights
from tests.solver.transfer.maps import random_pull_back

SEEDS = st.integers(0, 2**31 - 1)
RANDOM = np.random.default_rng(1)
TABLE = (
    Attribute("height", RANDOM.standard_normal(30)),
    Attribute("part", RANDOM.integers(0, 4, size=30)),
    Attribute("name", np.array(["head", "arm", "leg"])[RANDOM.integers(0, 3, size=30)]),
    Attribute("flow", RANDOM.standard_normal((30, 3)), ("x", "y", "z")),
    Attribute("colors", RANDOM.random((30, 3))),
    Attribute("weights", RANDOM.random((30, 5)), ("hip", "knee", "foot", "hand", "head")),
)


@pytest.mark.parametrize(
    ("kind", "names"),
    [
        (SCALARS, ["height", "part"]),
        (LABELS, ["part", "name"]),
        (VECTORS, ["flow"]),
        (COLORS, ["colors"]),
        (SKINNING, ["weights"]),
    ],
)
def test_attributes_of_a_kind_are_selected(kind: str, names: list[str]) -> None:
    assert [one.name for one in selected(TABLE, kind)] == names


def test_attributes_are_selected_by_name() -> None:
    assert [one.name for one in selected(TABLE, SCALARS, ["part"])] == ["part"]
    (skin,) = selected(TABLE, SKINNING, ["foot", "hip"])
    assert skin.columns == ("foot", "hip")
    np.testing.assert_array_equal(skin.values, TABLE[-1].values[:, [2, 0]])
    with pytest.raises(OptionError, match="no labels called 'flow'; there are 'part', 'name'"):
        selected(TABLE, LABELS, ["flow"])
    with pytest.raises(OptionError, match="no joint called 'tail'"):
        selected(TABLE, SKINNING, ["tail"])
    with pytest.raises(OptionError, match="the file has no colors; there are 'height'"):
        selected(TABLE[:1], COLORS)
    told = r"no labels; there are 'height' \(scalars\), 'flow' \(vectors\), 'weights' \(skinning\)"
    with pytest.raises(OptionError, match=told):
        selected([TABLE[0], TABLE[3], TABLE[5]], LABELS)


def test_floats_that_are_whole_are_labels_where_there_are_no_others() -> None:
    mask = Attribute("mask", np.arange(30.0) // 10)
    for table, names in ((TABLE[:1], []), (TABLE, ["mask"])):
        (found,) = selected([*table, mask], LABELS, names)
        assert (found.name, found.values.dtype.kind) == ("mask", "i")
        np.testing.assert_array_equal(found.values, mask.values)
    assert [one.name for one in selected([*TABLE, mask], LABELS)] == ["part", "name"]
    (found,) = selected([Attribute("mask", np.append(mask.values, np.nan))], LABELS)
    np.testing.assert_array_equal(found.values, np.append(mask.values, -1))
    for wrong in (np.inf, 0.5, 1e300):
        values = np.append(mask.values, wrong)
        with pytest.raises(OptionError, match=r"no labels; there are 'mask' \(scalars\)"):
            selected([Attribute("mask", values)], LABELS)


def test_scalars_without_a_table_of_weights_are_those_of_joints() -> None:
    (skin,) = selected(TABLE[:2], SKINNING)
    assert skin.columns == ("height", "part")


@given(SEEDS, st.sampled_from([None, 1, 2, 4, 9]))
def test_sums_of_weights_stay_one(seed: int, influences: int | None) -> None:
    along = random_pull_back(seed)
    weights = np.random.default_rng(seed).random((30, 6)) * 3.0
    found = carried(Attribute("weights", weights), SKINNING, along, influences).values
    np.testing.assert_allclose(found.sum(axis=1), 1.0, rtol=1e-12)
    assert found.min() >= 0.0
    if influences is not None:
        assert ((found > 0.0).sum(axis=1) <= influences).all()
    else:
        expected = along.means(weights / weights.sum(axis=1, keepdims=True))
        np.testing.assert_allclose(found, expected, rtol=1e-12)


def test_the_strongest_weights_are_kept_as_they_are() -> None:
    weights = np.array([[0.1, 0.4, 0.3, 0.2], [0.0, 1.0, 0.0, 0.0]])
    np.testing.assert_array_equal(
        strongest_weights(weights, 2), [[0.0, 0.4, 0.3, 0.0], [0.0, 1.0, 0.0, 0.0]]
    )
    np.testing.assert_array_equal(normalised_weights(np.zeros((2, 3))), np.zeros((2, 3)))
    huge = np.array([[1e308, 1e308], [5e-324, 0.0]])
    np.testing.assert_allclose(normalised_weights(huge).sum(axis=1), 1.0)


@given(SEEDS)
def test_labels_stay_labels(seed: int) -> None:
    along = random_pull_back(seed)
    for attribute in TABLE[1:3]:
        found = carried(attribute, LABELS, along)
        assert set(found.values) <= set(attribute.values)
        assert found.values.dtype == attribute.values.dtype


def test_missing_vertices() -> None:
    along = PullBack(np.array([1]), np.array([[0, 1, 2]]), np.array([[1.0, 0.0, 0.0]]), 2)
    assert carried(TABLE[1], LABELS, along).values.tolist() == [-1, TABLE[1].values[0]]
    assert carried(TABLE[2], LABELS, along).values.tolist() == ["", TABLE[2].values[0]]
    assert np.isnan(carried(TABLE[3], VECTORS, along).values[0]).all()


def test_rows_without_a_value_have_no_weight() -> None:
    """As after a transfer from a part, where vertices without a partner have nan."""
    corners = np.array([[0, 1, 2]] * 4)
    weights = np.array([[0.5, 0.3, 0.2], [0.3, 0.3, 0.4], [0.6, 0.4, 0.0], [0.0, 0.0, 1.0]])
    along = PullBack(np.arange(4), corners, weights, 4)
    heights = carried(Attribute("height", np.array([1.0, 6.0, np.nan])), SCALARS, along).values
    np.testing.assert_allclose(heights, [2.3 / 0.8, 3.5, 3.0, np.nan])
    flow = np.array([[1.0, 2.0], [3.0, 4.0], [5.0, np.nan]])
    moved = carried(Attribute("flow", flow), VECTORS, along).values
    np.testing.assert_allclose(moved[2], 0.6 * flow[0] + 0.4 * flow[1])
    assert np.isnan(moved[3]).all()
    joints = np.array([[1.0, 3.0], [1.0, 0.0], [np.nan, np.nan]])
    skin = carried(Attribute("weights", joints), SKINNING, along).values
    np.testing.assert_allclose(skin[:3].sum(axis=1), 1.0)
    np.testing.assert_allclose(skin[2], [0.6 * 0.25 + 0.4, 0.6 * 0.75])
    assert np.isnan(skin[3]).all()


def test_numbers_must_not_be_infinite_and_weights_not_negative() -> None:
    along = random_pull_back(0)
    values = np.zeros(30)
    values[7] = np.inf
    with pytest.raises(TransferError, match="'height' of vertex 7 is infinite"):
        carried(Attribute("height", values), SCALARS, along)
    weights = np.ones((30, 2))
    weights[4, 1] = -0.1
    with pytest.raises(TransferError, match="joint 1 at vertex 4 is negative"):
        carried(Attribute("weights", weights), SKINNING, along)
