"""STL, which numbers no vertices: merged by position, and what is broken."""

import numpy as np
import pytest

from solver.errors import MeshError
from solver.mesh import read_mesh
from tests.solver.mesh import mesh_files
from tests.solver.mesh.mesh_files import SQUARE, TWO


def test_binary_stl_that_begins_like_a_text_one() -> None:
    data = mesh_files.stl(SQUARE, np.array(TWO), header=b"solid but binary")
    assert read_mesh(data, "stl").faces.tolist() == TWO


def test_stl_merges_vertices_of_equal_position_only() -> None:
    vertices = np.concatenate([SQUARE, SQUARE + np.array([0.0, 0.0, 1e-3]), -0.0 * SQUARE[:1]])
    faces = np.array([[0, 1, 2], [8, 2, 3], [4, 5, 6]])
    mesh = read_mesh(mesh_files.stl(vertices, faces), "stl")
    assert mesh.n_vertices == 7
    assert mesh.components == 2
    assert mesh.faces.tolist() == [*TWO, [4, 5, 6]]
    assert mesh.warnings[0].endswith("9 vertices were merged into 7")


def test_several_solids_in_a_text_stl_are_one_mesh() -> None:
    upper = mesh_files.text_stl(SQUARE, np.array(TWO[:1]))
    lower = mesh_files.text_stl(SQUARE, np.array(TWO[1:])).upper()
    assert read_mesh(upper + lower, "stl").faces.tolist() == TWO


def test_a_text_stl_may_begin_with_a_byte_order_mark() -> None:
    text = mesh_files.text_stl(SQUARE, np.array(TWO))
    assert read_mesh(b"\xef\xbb\xbf" + text, "stl").faces.tolist() == TWO


def test_stl_names_are_not_read() -> None:
    text = mesh_files.text_stl(SQUARE, np.array(TWO))
    text = text.replace(b"solid shape", b"solid vertex 1 2 3 normal endsolid")
    assert read_mesh(text, "stl").faces.tolist() == TWO
    binary = mesh_files.stl(SQUARE, np.array(TWO), header=b"solid \xe9\xff")
    assert read_mesh(binary, "stl").faces.tolist() == TWO


@pytest.mark.parametrize("end", [20, 60, 200])
def test_a_second_solid_that_is_cut_off(end: int) -> None:
    text = mesh_files.text_stl(SQUARE, np.array(TWO))
    with pytest.raises(MeshError, match="cut off"):
        read_mesh(text + text[:-end], "stl")


@pytest.mark.parametrize(
    ("old", "new"),
    [(b"endsolid", b""), (b"endfacet", b""), (b"vertex 1.0", b"corner 1.0"), (b"1.0", b"one")],
)
def test_broken_text_stl(old: bytes, new: bytes) -> None:
    data = mesh_files.text_stl(SQUARE, np.array(TWO))
    with pytest.raises(MeshError, match=r"damaged|cannot be read"):
        read_mesh(data.replace(old, new, 1), "stl")
