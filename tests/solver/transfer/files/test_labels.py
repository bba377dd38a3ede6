"""Labels stay what they are: text stays text, whatever it looks like, and numbers stay numbers."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from solver.errors import TransferError
from solver.mesh import triangle_mesh
from solver.transfer import FACES, LABELS, Attribute, selected
from solver.transfer.files import WrittenSurface, read_attributes, write_csv, write_glb
from tests.solver.mesh import mesh_files
from tests.solver.transfer.files.test_hostile_files import changed_glb
from tests.solver.transfer.files.written import write_attributes

MESH = triangle_mesh(np.eye(4)[:, :3], np.array([[0, 1, 2], [0, 3, 1]]))
LIKE_NUMBERS = ["01", "1", "1.0", "-1", "1e3", "inf", "nan", "NA", "null", "", " ", "True", "head"]
# NumPy drops NUL at the end of a text.
TEXTS = st.sampled_from(LIKE_NUMBERS) | st.text(st.characters(exclude_characters="\0"), max_size=9)
ONE_LINE = TEXTS.map(lambda text: "".join(text.splitlines()))


def read_again(attribute: Attribute, file_type: str) -> Attribute:
    surface = WrittenSurface.of(MESH, [attribute])
    (found,) = read_attributes(write_attributes([attribute], file_type, surface), file_type)
    return found


@pytest.mark.parametrize("file_type", ["npz", "csv", "glb"])
@given(texts=st.lists(TEXTS, min_size=4, max_size=4))
def test_text_stays_text(file_type: str, texts: list[str]) -> None:
    one = Attribute("part", np.array(texts, dtype=np.str_))
    found = read_again(one, file_type)
    assert found.is_text
    assert (found.name, found.values.tolist()) == ("part", texts)


@given(st.lists(ONE_LINE, min_size=4, max_size=4))
def test_text_of_one_line_stays_text_in_ply(texts: list[str]) -> None:
    assert read_again(Attribute("part", np.array(texts)), "ply").values.tolist() == texts


@pytest.mark.parametrize("file_type", ["npz", "csv", "ply", "glb"])
@given(numbers=st.lists(st.integers(-(2**24), 2**24), min_size=4, max_size=4))
def test_numbers_stay_labels(file_type: str, numbers: list[int]) -> None:
    found = read_again(Attribute("part", np.array(numbers)), file_type)
    assert selected([found], LABELS) == (found,)
    assert found.values.tolist() == numbers


@pytest.mark.parametrize("file_type", ["npz", "csv", "ply", "glb"])
def test_truth_values_are_labels(file_type: str) -> None:
    """NPZ has them as 0 and 1, as text they are words."""
    for values in (np.array([1, 0, 1, 1]), np.array(["True", "False", "True", "true"])):
        found = read_again(Attribute("inside", values), file_type)
        assert found.values.tolist() == values.tolist()


@given(
    st.sampled_from(["a", "a:text", "A:TEXT", "vertex:text", "vertex", "face:text", ":text"]),
    st.sampled_from([["01", "2", "3", "4"], ["arm", "leg", "arm", ""], [1, 2, 3, 4]]),
)
def test_names_that_look_like_the_mark_of_text_are_told_apart(name: str, values: list[Any]) -> None:
    one, other = Attribute(name, np.array(values)), Attribute("b", np.array([1.5, 2.0, 3.0, 4.0]))
    first, second = read_attributes(write_csv([one, other]), "csv")
    assert first.values.tolist() == values
    assert first.name.rstrip("_") == name.rstrip("_")
    assert second.values.tolist() == other.values.tolist()


def test_only_text_that_looks_like_something_else_is_marked() -> None:
    text = write_csv(
        [Attribute("a", np.array(["arm", "leg"])), Attribute("b", np.array(["1", "2"]))]
    )
    assert text.decode() == "vertex,a,b:text\n0,arm,1\n1,leg,2\n"


def test_columns_that_differ_by_the_mark_alone_are_refused() -> None:
    with pytest.raises(TransferError, match="different names, also without ':text'"):
        read_attributes(b"a,a:text\n1,01\n", "csv")
    with pytest.raises(TransferError, match="different names"):
        read_attributes(b":text,b\n1,01\n", "csv")


def test_glb_has_the_texts_of_each_surface() -> None:
    kinds = np.array(["01", "02", "03", "01"]), np.array(["x", "03", "x", "x"])
    surfaces = [
        WrittenSurface.of(MESH, [Attribute("kind", one), Attribute("n", np.arange(4))])
        for one in kinds
    ]
    bare = WrittenSurface.of(MESH, [])
    found = {one.name: one for one in read_attributes(write_glb([*surfaces, bare]), "glb")}
    assert found["kind"].values.tolist() == [*kinds[0], *kinds[1], "", "", "", ""]
    np.testing.assert_array_equal(found["n"].values, [0, 1, 2, 3, 0, 1, 2, 3, *[np.nan] * 4])


def test_glb_has_texts_of_faces_at_the_vertices_of_each() -> None:
    one = Attribute("part", np.array(["1", "02"]), on=FACES)
    (found,) = read_attributes(write_glb([WrittenSurface.of(MESH, [one])]), "glb")
    assert found.values.tolist() == 3 * ["1"] + 3 * ["02"]


@pytest.mark.parametrize(
    "extras",
    [
        None,
        "labels",
        ["labels"],
        {"labels": 7},
        {"labels": {"a": "text"}},
        {"labels": {"a": [1, 2]}},
        {"labels": {"a": ["too", "few"]}},
        {"labels": {"b": ["of", "another"]}},
        {"labels": {"weights": ["w"], "colors": ["c"]}},
    ],
)
def test_extras_of_other_programs_change_nothing(extras: Any) -> None:
    data = changed_glb(lambda tree: tree["meshes"][0]["primitives"][0].update(extras=extras))
    expected = read_attributes(changed_glb(lambda tree: None), "glb")
    found = read_attributes(data, "glb")
    assert [one.name for one in found] == [one.name for one in expected]
    for one, other in zip(found, expected, strict=True):
        np.testing.assert_array_equal(one.values, other.values)


ENDLESS, ROWS = 100_000 * "a", 3_000
ENDLESS_LABELS = {
    "csv": f"a\n{ENDLESS}\n" + ROWS * "b\n",
    "seg": f"{ENDLESS}\n" + ROWS * "b\n",
    "obj": f"v 0 0 0\nv 1 0 0\nv 0 1 0\ng {ENDLESS}\nf 1 2 3\ng b\n" + ROWS * "f 1 2 3\n",
    "ply": (
        f"ply\nformat ascii 1.0\ncomment label a 0 {ENDLESS}\nelement vertex {ROWS}\n"
        "property float x\nproperty int a\nend_header\n" + ROWS * "0 0\n"
    ),
}


@pytest.mark.parametrize("file_type", ENDLESS_LABELS)
def test_one_label_of_endless_length_is_refused(file_type: str) -> None:
    """As an array all texts are as long as the longest."""
    with pytest.raises(TransferError, match="label of 100000 characters is too long"):
        read_attributes(ENDLESS_LABELS[file_type].encode(), file_type)


def test_so_is_one_in_the_extras_of_glb() -> None:
    tree, buffer = mesh_files.gltf_tree(np.zeros((ROWS, 3)), np.array([[0, 1, 2]]))
    primitive = tree["meshes"][0]["primitives"][0]
    primitive["attributes"]["_a"] = 2
    primitive["extras"] = {"labels": {"a": [ENDLESS]}}
    buffer = mesh_files.gltf_accessor(tree, buffer, np.zeros((ROWS, 3), "<f4"))
    tree["accessors"][2]["type"] = "SCALAR"
    with pytest.raises(TransferError, match="label of 100000 characters is too long"):
        read_attributes(mesh_files.glb_of(tree, buffer), "glb")
