"""OBJ: the numbers of its ``v`` lines, its colours, and what is broken."""

import numpy as np
import pytest

from solver.errors import MeshError
from solver.mesh import read_mesh
from tests.solver import shapes
from tests.solver.mesh import mesh_files
from tests.solver.mesh.mesh_files import SQUARE, TWO


def test_obj_keeps_the_numbering_of_its_v_lines_despite_seams() -> None:
    """Each corner has its own texture coordinate and normal, and two materials alternate."""
    mesh = shapes.permuted(shapes.cube(3), seed=2)[0]
    lines = ["# cube", "mtllib none.mtl", "o cube"]
    for number, (x, y, z) in enumerate(mesh.vertices.tolist()):
        lines += [f"v {x!r} {y!r} {z!r}", f"vt {number / 99} 0.5", f"vn 0 0 {number}"]
    for number, face in enumerate(mesh.faces.tolist()):
        lines += [f"usemtl m{number % 2}", f"g part{number % 3}"]
        texture = [(corner * 7 + number) % mesh.n_vertices + 1 for corner in face]
        lines.append(
            "f " + " ".join(f"{v + 1}/{t}/{t}" for v, t in zip(face, texture, strict=True))
        )
    read = read_mesh("\n".join([*lines, ""]).encode(), "obj")
    np.testing.assert_array_equal(read.vertices, mesh.vertices)
    np.testing.assert_array_equal(read.faces, mesh.faces)
    np.testing.assert_array_equal(read.vertex_ids, np.arange(mesh.n_vertices))


def test_obj_indices_may_count_back_from_the_last_vertex() -> None:
    text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nf -3//1 -2//1 -1//1\nv 0 1 0\nf -4 \\\n-2 -1\n"
    mesh = read_mesh(text.encode(), "obj")
    assert mesh.faces.tolist() == TWO


@pytest.mark.parametrize(
    "line", ["# from C:\\models\\", "g C:\\", "o a\\", "usemtl b\\", "vn 0 0 1 # of C:\\"]
)
def test_obj_comments_and_names_do_not_continue_on_the_next_line(line: str) -> None:
    data = line.encode() + b"\n" + mesh_files.obj(SQUARE, TWO)
    np.testing.assert_array_equal(read_mesh(data, "obj").vertices, SQUARE)


@pytest.mark.parametrize("separator", ["\x0b", "\x0c", "\x1c", "\x85", "\u2028"])
@pytest.mark.parametrize("file_type", ["obj", "off"])
def test_lines_end_with_line_breaks_alone(file_type: str, separator: str) -> None:
    data = {"obj": mesh_files.obj, "off": mesh_files.off}[file_type](SQUARE, TWO)
    comment = f"# two{separator}v 5 5 5\n".encode()
    np.testing.assert_array_equal(read_mesh(comment + data, file_type).vertices, SQUARE)


@pytest.mark.parametrize("line_break", [b"\r\n", b"\r"])
def test_obj_of_other_systems(line_break: bytes) -> None:
    text = b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 \\\n2 3\nf 1 3 4\n"
    assert read_mesh(text.replace(b"\n", line_break), "obj").faces.tolist() == TWO


def test_obj_polygons_mixed_with_triangles() -> None:
    text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 2 0\nf 1 2 3 4\nf 4/1 3/1 5/1\nl 1 2\n"
    mesh = read_mesh(text.encode(), "obj")
    assert mesh.faces.tolist() == [*TWO, [3, 2, 4]]
    assert mesh.warnings == ("cut 1 face of more than three corners into triangles",)


def test_obj_colors() -> None:
    rows = [f"v {x} {y} {z} 1.0 0.5 0.0" for x, y, z in SQUARE.tolist()]
    mesh = read_mesh("\n".join([*rows, "f 1 2 3 4\n"]).encode(), "obj")
    assert mesh.colors is not None
    np.testing.assert_array_equal(mesh.colors, np.tile([1.0, 0.5, 0.0], (4, 1)))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("f 0 1 2", "counts from 1"),
        ("f 1 2 5", "vertex 4"),
        ("f 1 2 -5", "vertex -5, counted back, but 4 come before it"),
        (f"f 1 2 {10**20}", "read: a number in it is too large"),
        ("f 1 2", "2 corners"),
        ("f 1 2 x", "'x' is no whole number"),
        ("f 1 2 " + "9" * 5000, "too many digits"),
        ("f 1 2 3 /4", "no vertex before its slash"),
        ("f 1 2 / 3", "no vertex before its slash"),
        ("f //1 2 3", "no vertex before its slash"),
        ("v 1 2\nf 1 2 3", "vertex line"),
        ("v 1 2 inf\nf 1 2 5", "not a finite"),
        ("", "no faces"),
    ],
)
def test_broken_obj(text: str, message: str) -> None:
    with pytest.raises(MeshError, match=message):
        read_mesh(mesh_files.obj(SQUARE, []) + text.encode() + b"\n", "obj")
