"""Attributes as columns of tables, and columns grouped into attributes again."""

from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

from solver.transfer import Attribute
from solver.transfer.files import WrittenSurface, read_attributes
from solver.transfer.files.columns import from_columns, to_columns
from tests.solver.transfer.files.test_round_trips import TRIANGLE
from tests.solver.transfer.files.written import write_attributes

ROWS = np.arange(3)
XY = np.arange(6.0).reshape(3, 2)
RGB = np.array([[1.0, 0, 0], [0, 1, 0], [0, 0, 1]])


@pytest.mark.parametrize(
    ("names", "expected"),
    [
        ("seg.label", {"seg.label": ()}),
        ("weights.hip", {"weights": ("hip",)}),
        ("weights.Arm.L weights.Arm.R", {"weights": ("Arm.L", "Arm.R")}),
        ("flow.x flow.y flow.z", {"flow": ("x", "y", "z")}),
        ("k k.max k.min", {"k": (), "k.max": (), "k.min": ()}),
        ("flow flow.x.0 flow.x.1", {"flow": (), "flow.x": ("0", "1")}),
        ("red green a blue", {"colors": ("red", "green", "blue"), "a": ()}),
        ("alpha red green blue", {"colors": ("red", "green", "blue", "alpha")}),
        ("colors red green blue", {"colors_": (), "colors": ("red", "green", "blue")}),
        (
            "red green blue colors colors_",
            {"colors": ("red", "green", "blue"), "colors__": (), "colors_": ()},
        ),
        (
            "colors.a colors.b red green blue",
            {"colors_": ("a", "b"), "colors": ("red", "green", "blue")},
        ),
        ("red alpha", {"red": (), "alpha": ()}),
        (".x .y a. b.", {".x": (), ".y": (), "a.": (), "b.": ()}),
    ],
)
def test_columns_are_grouped(names: str, expected: dict[str, tuple[str, ...]]) -> None:
    found = from_columns(dict.fromkeys(names.split(), ROWS))
    assert {one.name: one.columns for one in found} == expected
    assert [one.name for one in found] == [*expected]
    for one in found:
        assert one.values.shape == ((3, len(one.columns)) if one.columns else (3,))
        assert (one.values.dtype.kind == "i") == (not one.columns)


def test_text_is_never_grouped() -> None:
    text = np.array(["a", "b", "c"])
    found = from_columns({"k.a": text, "k.b": ROWS, "red": text, "green": ROWS, "blue": ROWS})
    assert [one.name for one in found] == ["k.a", "k.b", "red", "green", "blue"]


@pytest.mark.parametrize("file_type", ["csv", "ply"])
@pytest.mark.parametrize(
    ("attributes", "names"),
    [
        ({"flow": ROWS * 1.5, "flow.x": XY}, ["flow", "flow.x"]),
        ({"a.b": ROWS, "flow": XY}, ["a.b", "flow"]),
        ({"flow.0": ROWS, "flow": XY}, ["flow_0", "flow"]),
        ({"flow.0": ROWS, "flow_0": ROWS + 7, "flow": XY}, ["flow_0_", "flow_0", "flow"]),
        ({"flow.0": ROWS, "flow_0": XY + 7, "flow": XY}, ["flow_0_", "flow_0", "flow"]),
        ({"flow": RGB, "flow.x": XY}, ["flow", "flow.x_"]),
        ({"flow.x": XY, "flow": RGB, "flow.x_": ROWS}, ["flow.x__", "flow", "flow_x_"]),
        ({"a.b.c": ROWS, "a.b": XY, "a": RGB}, ["a_b_c", "a.b", "a"]),
        ({"red": XY, "colors": RGB}, ["red_", "colors"]),
        (
            {"weights": RGB, "weights.a": XY, "Weights": XY + 1},
            ["weights", "weights_a", "Weights_"],
        ),
        (
            {"weights": RGB, "weights.a": ROWS, "Weights.b": ROWS},
            ["weights", "weights_a", "Weights_b"],
        ),
        ({"Red": ROWS, "alpha": ROWS * 5, "colors": RGB}, ["Red_", "alpha_", "colors"]),
    ],
)
def test_attributes_of_similar_names_are_read_again(
    attributes: dict[str, npt.NDArray[Any]], names: list[str], file_type: str
) -> None:
    given = [Attribute(name, values) for name, values in attributes.items()]
    data = write_attributes(given, file_type, WrittenSurface.of(TRIANGLE, given))
    found = {one.name: one.values for one in read_attributes(data, file_type)}
    assert {*found} == {*names}
    for name, values in zip(names, attributes.values(), strict=True):
        np.testing.assert_array_equal(found[name], values)


@pytest.mark.parametrize("file_type", ["csv", "ply"])
def test_joints_called_as_columns_of_another_attribute_keep_their_weights(file_type: str) -> None:
    skin = Attribute("weights", XY + 0.5, ("a.0", "a.1"))
    given = [skin, Attribute("weights.a", XY)]
    data = write_attributes(given, file_type, WrittenSurface.of(TRIANGLE, given))
    found, other = read_attributes(data, file_type)
    assert (found.name, found.columns) == ("weights", skin.columns)
    np.testing.assert_array_equal(found.values, skin.values)
    assert other.name == "weights_a"
    np.testing.assert_array_equal(other.values, XY)


def test_columns_keep_the_order_of_attributes() -> None:
    given = [Attribute("a", ROWS), Attribute("flow", XY), Attribute("b", ROWS)]
    assert [*to_columns(given)] == ["a", "flow.0", "flow.1", "b"]
