"""Words that Python reads as numbers, and no mesh file has: 1_0, and digits of other scripts."""

from collections.abc import Callable

import pytest
from hypothesis import given
from hypothesis import strategies as st

from solver.errors import MeshError
from solver.mesh.formats import READERS
from solver.mesh.formats.materials import read_materials

WORDS = ("1", "2", "10", "0", "-1", "0.5")
"""Numbers to be disguised."""


def in_script(word: str, zero: int) -> str:
    """A word with the digits of another script, of which this is zero."""
    return "".join(chr(zero + int(one)) if one.isdigit() else one for one in word)


def grouped(word: str) -> str:
    """A word with an underscore between digits, or before a leading zero."""
    sign, digits = ("-", word[1:]) if word.startswith("-") else ("", word)
    return sign + "0_" + digits


DISGUISED = st.one_of(
    st.builds(in_script, st.sampled_from(WORDS), st.sampled_from([0x660, 0x966, 0xFF10, 0x1D7CE])),
    st.sampled_from(WORDS).map(grouped),
)

PLY = (
    "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
    "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
)
FILES: dict[str, tuple[str, Callable[[str], str]]] = {
    "corner of OBJ": ("obj", lambda one: 12 * "v 0 0 0\n" + f"f 1 2 {one}\n"),
    "coordinate of OBJ": ("obj", lambda one: f"v 0 0 {one}\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"),
    "vertices of OFF": ("off", lambda one: f"OFF\n{one} 1 0\n" + 10 * "0 0 0\n" + "3 0 1 2\n"),
    "faces of OFF": ("off", lambda one: f"OFF\n3 {one} 0\n" + 3 * "0 0 0\n" + 10 * "3 0 1 2\n"),
    "corner of OFF": ("off", lambda one: "OFF\n12 1 0\n" + 12 * "0 0 0\n" + f"3 0 1 {one}\n"),
    "corner of a polygon of OFF": (
        "off",
        lambda one: "OFF\n12 2 0\n" + 12 * "0 0 0\n" + f"3 0 1 {one}\n4 0 1 2 3\n",
    ),
    "coordinate of OFF": ("off", lambda one: f"OFF\n3 1 0\n0 0 {one}\n1 0 0\n0 1 0\n3 0 1 2\n"),
    "corner of PLY": ("ply", lambda one: PLY + f"0 0 0\n1 0 0\n0 1 0\n3 0 1 {one}\n"),
    "coordinate of PLY": ("ply", lambda one: PLY + f"0 0 {one}\n1 0 0\n0 1 0\n3 0 1 2\n"),
    "first point": ("xyz", lambda one: f"0 0 {one}\n1 0 0\n0 1 0\n"),
    "second point": ("xyz", lambda one: f"0 0 0\n1 0 {one}\n0 1 0\n"),
    "vertex of STL": (
        "stl",
        lambda one: (
            f"solid\nfacet\nouter\nvertex 0 0 {one}\nvertex 1 0 0\nvertex 0 1 0\n"
            "endloop\nendfacet\nendsolid\n"
        ),
    ),
}


@pytest.mark.parametrize("where", FILES)
@given(word=DISGUISED)
def test_digits_that_only_python_takes_for_numbers_are_refused(where: str, word: str) -> None:
    kind, written = FILES[where]
    with pytest.raises(MeshError, match=r"cannot be read|counts"):
        READERS[kind](written(word).encode())


@given(DISGUISED)
def test_so_are_those_of_materials(word: str) -> None:
    with pytest.raises(MeshError, match="number of Kd"):
        read_materials(f"newmtl skin\nKd {word} 0 0\n".encode(), ["skin"])
    # It may be the name of a file.
    (skin,) = read_materials(f"newmtl skin\nmap_Kd -s 2 3 {word}\n".encode(), ["skin"]).values()
    assert skin.image == word
    assert skin.scale.tolist() == [2.0, 3.0]


@pytest.mark.parametrize("where", ["coordinate of OBJ", "coordinate of OFF", "coordinate of PLY"])
def test_decimal_commas_are_named(where: str) -> None:
    kind, written = FILES[where]
    with pytest.raises(MeshError, match=r"'0,5' is no number .*write a decimal point\)"):
        READERS[kind](written("0,5").encode())


def test_a_word_that_is_no_number_is_named_with_its_row() -> None:
    with pytest.raises(MeshError, match=r"'three' is no number \(row 1, counted from 0\)"):
        READERS["xyz"](b"0 0 0\n1 0 three\n0 1 0\n")


@pytest.mark.parametrize("word", ["0x3", "1d3", "three", "--1", "1,5,2"])
def test_a_first_point_with_a_word_that_is_no_number_is_no_header(word: str) -> None:
    with pytest.raises(MeshError, match=r"point line|decimal commas"):
        READERS["xyz"](f"1 2 {word}\n4 5 6\n7 8 9\n".encode())
