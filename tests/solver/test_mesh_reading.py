"""Reading mesh files: the numbering, and the refusal of everything doubtful."""

import base64
import json
import struct
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import trimesh
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from solver.errors import MeshError
from solver.mesh import MESH_FORMATS, TriangleMesh, read_mesh, triangle_areas
from tests.solver import mesh_files, shapes

SQUARE = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
TWO = [[0, 1, 2], [0, 2, 3]]

WRITERS: dict[str, Callable[[TriangleMesh], tuple[bytes, str]]] = {
    "off": lambda m: (mesh_files.off(m.vertices, m.faces.tolist()), "off"),
    "obj": lambda m: (mesh_files.obj(m.vertices, m.faces.tolist()), "obj"),
    "ply text": lambda m: (mesh_files.ply(m.vertices, m.faces.tolist(), "ascii"), "ply"),
    "ply little": lambda m: (mesh_files.ply(m.vertices, m.faces.tolist()), "ply"),
    "ply big": lambda m: (
        mesh_files.ply(m.vertices, m.faces.tolist(), "binary_big_endian"),
        "ply",
    ),
    "stl": lambda m: (mesh_files.stl(m.vertices, m.faces), "stl"),
    "stl text": lambda m: (mesh_files.text_stl(m.vertices, m.faces), "stl"),
    "glb": lambda m: (mesh_files.glb(m.vertices, m.faces), "glb"),
}


def rounded(mesh: TriangleMesh) -> TriangleMesh:
    """Coordinates that single precision holds too."""
    return TriangleMesh(
        mesh.vertices.astype(np.float32).astype(np.float64), mesh.faces, mesh.vertex_ids
    )


@pytest.mark.parametrize("name", WRITERS)
def test_vertices_and_faces_come_back_in_the_order_of_the_file(name: str) -> None:
    mesh = rounded(shapes.permuted(shapes.blob(2), seed=1)[0])
    read = read_mesh(*WRITERS[name](mesh))
    if name.startswith("stl"):  # has no numbering but that of first appearance
        np.testing.assert_array_equal(read.vertices[read.faces], mesh.vertices[mesh.faces])
        assert read.n_vertices == mesh.n_vertices
        assert read.faces[0].tolist() == [0, 1, 2]
        assert "merged" in read.warnings[0]
        assert "numbered" in read.warnings[1]
    else:
        np.testing.assert_array_equal(read.vertices, mesh.vertices)
        np.testing.assert_array_equal(read.faces, mesh.faces)
        assert read.warnings == ()
    np.testing.assert_array_equal(read.vertex_ids, np.arange(mesh.n_vertices))
    assert read.closed


@pytest.mark.parametrize("file_type", ["off", "obj", "ply", "stl", "glb"])
def test_what_trimesh_writes_is_read(file_type: str) -> None:
    mesh = rounded(shapes.blob(2))
    written = trimesh.Trimesh(mesh.vertices, mesh.faces, process=False).export(file_type=file_type)
    assert isinstance(written, str | bytes)
    data = written.encode() if isinstance(written, str) else written
    read = read_mesh(data, f".{file_type.upper()}")
    assert read.n_vertices == mesh.n_vertices
    np.testing.assert_allclose(read.vertices[read.faces], mesh.vertices[mesh.faces], atol=1e-7)


# --- truncation -----------------------------------------------------------------------------------


@pytest.mark.parametrize("name", WRITERS)
def test_a_file_cut_anywhere_is_refused_or_suspected(name: str) -> None:
    data, file_type = WRITERS[name](rounded(shapes.tetrahedron()))
    whole = read_mesh(data, file_type)
    doubtful = 0
    for end in range(len(data) - 1):
        try:
            mesh = read_mesh(data[:end], file_type)
        except MeshError:
            continue
        same = mesh.faces.tolist() == whole.faces.tolist()
        suspected = any("cut off" in warning for warning in mesh.warnings)
        # OBJ has no counts: lines that are missing at its end are beyond anyone's knowledge.
        assert same or suspected or (file_type == "obj" and data[end - 1 : end] == b"\n")
        doubtful += not same
    assert doubtful <= (data.count(b"f ") * 3 if file_type == "obj" else 1)


@pytest.mark.parametrize(
    ("data", "file_type"),
    [
        (b"OFF\n1000000000000 1000000000000 0\n0 0 0\n", "off"),
        (b"OFF\n4 1000000000000 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2\n", "off"),
        (b"OFF\n3 1 0\n0 0 0\n1 0 0\n1 1 0\n1000000000000 0 1 2\n", "off"),
        (
            b"ply\nformat ascii 1.0\nelement vertex 1000000000000\nproperty float x\nend_header\n",
            "ply",
        ),
        (
            b"ply\nformat binary_little_endian 1.0\nelement vertex 1000000000000\n"
            b"property float x\nproperty float y\nproperty float z\nend_header\n",
            "ply",
        ),
        (
            b"ply\nformat binary_little_endian 1.0\nelement vertex 99999999999999999999999\n"
            b"property list uint int x\nend_header\n\xff\xff\xff\xff",
            "ply",
        ),
        (
            b"ply\nformat binary_little_endian 1.0\nelement face 1\n"
            b"property list uint int vertex_indices\nend_header\n\xff\xff\xff\xff\0\0\0\0",
            "ply",
        ),
        (b"\0" * 80 + b"\xff\xff\xff\xff" + b"\0" * 50, "stl"),
    ],
)
def test_promises_of_a_header_are_not_believed(data: bytes, file_type: str) -> None:
    with pytest.raises(MeshError, match=r"cut off|damaged|bytes"):
        read_mesh(data, file_type)


def test_a_promised_accessor_allocates_nothing() -> None:
    tree, buffer = mesh_files.gltf_tree(SQUARE, np.array(TWO))
    tree["accessors"].append({"componentType": 5126, "count": 10**12, "type": "MAT4"})
    with pytest.raises(MeshError, match="far more values"):
        read_mesh(mesh_files.glb_of(tree, buffer), "glb")


@pytest.mark.parametrize("file_type", MESH_FORMATS)
@pytest.mark.parametrize(
    "data", [b"", b" \n", b"Dear all,\nthis is a letter, 3 4 5.\n", b"\0" * 99]
)
def test_other_files_are_refused(data: bytes, file_type: str) -> None:
    with pytest.raises(MeshError):
        read_mesh(data, file_type)


def test_unknown_formats_are_refused() -> None:
    with pytest.raises(MeshError, match="use one of off, obj, ply, stl, glb, gltf, zip"):
        read_mesh(b"x", "fbx")


# --- OFF ------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "text",
    [
        "OFF 4 2 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2\n3 0 2 3\n",
        "OFF4 2 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2\n3 0 2 3\n",
        "# first\nOFF # here\n\n4 2\n0 0 0 # a\n1 0 0\n\n1 1 0\n0 1 0\n"
        "3 0 1 2 255 0 0\n3 0 2 3 1 1 1\n",
        "OFF\r\n4 1 0\r\n0 0 0\r\n1 0 0\r\n1 1 0\r\n0 1 0\r\n4 0 1 2 3\r\n",
        "NOFF\n4 1 0\n0 0 0 0 0 1\n1 0 0 0 0 1\n1 1 0 0 0 1\n0 1 0 0 0 1\n4 0 1 2 3\n",
    ],
)
def test_dialects_of_off(text: str) -> None:
    mesh = read_mesh(text.encode(), "off")
    np.testing.assert_array_equal(mesh.vertices, SQUARE)
    assert mesh.faces.tolist() == TWO
    assert mesh.colors is None


@pytest.mark.parametrize(
    ("header", "colors"),
    [
        ("COFF", "255 0 51 255"),
        ("COFF", "1.0 0.0 0.2"),
        ("OFF", "255 0 51"),
        ("CNOFF", "0 0 1 1. 0 .2"),
    ],
)
def test_colors_of_off(header: str, colors: str) -> None:
    rows = [f"{x} {y} {z} {colors}" for x, y, z in SQUARE.tolist()]
    mesh = read_mesh("\n".join([header, "4 1 0", *rows, "4 0 1 2 3\n"]).encode(), "off")
    assert mesh.colors is not None
    np.testing.assert_allclose(mesh.colors, np.tile([1.0, 0.0, 0.2], (4, 1)), atol=1e-12)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("OFF\n", "ends before"),
        ("OFF\nx y z\n", "counts"),
        ("OFF\n-4 2 0\n", "negative"),
        ("OFF BINARY\n", "binary OFF"),
        ("4OFF\n1 0 0\n0 0 0 0\n", "only OFF"),
        ("OFF\n3 1 0\n0 0\n1 0\n1 1\n3 0 1 2\n", "fewer than three"),
        ("OFF\n3 1 0\n0 0 0\n1 0 zero\n1 1 0\n3 0 1 2\n", "vertex line"),
        ("OFF\n3 1 0\n0 0 0\n1 0 0\n1 1 0\n3 0 1 two\n", "face line"),
        ("OFF\n3 1 0\n0 0 0\n1 0 0\n1 1 0\n3 0 1 0_2\n", "face line"),
        ("OFF\n3 1 0\n0 0 0\n1 0 0\n1 1 0\n3 0 1 3\n", "vertex 3"),
        ("OFF\n3 1 0\n0 0 0\n1 0 0\n1 1 0\n3 0 1 -1\n", "vertex -1"),
        ("OFF\n3 1 0\n0 0 0\n1 0 0\n1 1 0\n3 0 1\n", "promises 3 values and has 2"),
        ("OFF\n3 1 0\n0 0 0\n1 0 0\n1 1 0\n2 0 1\n", "2 corners"),
        ("OFF\n3 1 0\n0 0 0\n1 0 nan\n1 1 0\n3 0 1 2\n", "not a finite number"),
        ("OFF\n3 0 0\n0 0 0\n1 0 0\n1 1 0\n", "no faces"),
    ],
)
def test_broken_off(text: str, message: str) -> None:
    with pytest.raises(MeshError, match=message):
        read_mesh(text.encode(), "off")


# --- OBJ ------------------------------------------------------------------------------------------


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
        ("f 1 2 -5", "vertex -1"),
        ("f 1 2", "2 corners"),
        ("f 1 2 x", "face line"),
        ("v 1 2\nf 1 2 3", "vertex line"),
        ("v 1 2 inf\nf 1 2 5", "not a finite"),
        ("", "no faces"),
    ],
)
def test_broken_obj(text: str, message: str) -> None:
    with pytest.raises(MeshError, match=message):
        read_mesh(mesh_files.obj(SQUARE, []) + text.encode() + b"\n", "obj")


# --- PLY ------------------------------------------------------------------------------------------

MIXED = [[0, 1, 4], [3, 2, 1, 0], [2, 3, 4]]
FIVE = np.concatenate([SQUARE, [[0.5, 0.5, 1.0]]])


@pytest.mark.parametrize("encoding", ["ascii", "binary_little_endian", "binary_big_endian"])
def test_ply_polygons_of_any_mix_of_sizes(encoding: str) -> None:
    mesh = read_mesh(mesh_files.ply(FIVE, MIXED, encoding), "ply")
    np.testing.assert_array_equal(mesh.vertices, FIVE)
    assert mesh.faces.tolist() == [[0, 1, 4], [3, 2, 1], [3, 1, 0], [2, 3, 4]]


@pytest.mark.parametrize("encoding", ["ascii", "binary_little_endian"])
def test_ply_runs_of_polygons_of_one_size(encoding: str) -> None:
    """Binary rows are read run by run, and runs may have any length."""
    rng = np.random.default_rng(4)
    sizes = np.repeat(rng.integers(3, 6, size=40), rng.integers(1, 30, size=40))
    owner = np.repeat(np.arange(len(sizes)), sizes)
    starts = np.cumsum(sizes) - sizes
    angles = 2.0 * np.pi * (np.arange(len(owner)) - starts[owner]) / sizes[owner]
    vertices = np.stack([np.cos(angles), np.sin(angles), owner], axis=1)
    where = rng.permutation(len(owner))
    shuffled = np.empty_like(vertices)
    shuffled[where] = vertices
    polygons = [where[a : a + n].tolist() for a, n in zip(starts, sizes, strict=True)]
    mesh = read_mesh(mesh_files.ply(shuffled, polygons, encoding), "ply")
    np.testing.assert_array_equal(mesh.vertices, shuffled)
    level = mesh.vertices[mesh.faces, 2]
    assert (level == level[:, :1]).all()
    areas = np.bincount(level[:, 0].astype(int), triangle_areas(mesh.vertices, mesh.faces))
    np.testing.assert_allclose(areas, 0.5 * sizes * np.sin(2.0 * np.pi / sizes))


@pytest.mark.parametrize(
    ("old", "new"),
    [
        (b"1.0 1.0 0.0\n", b"1.0 1.0\n"),
        (b"1.0 1.0 0.0\n", b"1.0 1.0 0.0 7\n"),
        (b"1.0 1.0 0.0\n", b"1.0 1_0 0.0\n"),
        (b"3 0 2 3\n", b"3 0 2\n"),
        (b"3 0 2 3\n", b"2 0 2 3\n"),
        (b"3 0 2 3\n", b"-3 0 2 3\n"),
        (b"3 0 2 3\n", b"3 0 2.9 3\n"),
        (b"3 0 2 3\n", b"3 0 two 3\n"),
    ],
)
def test_text_ply_rows_that_contradict_the_header(old: bytes, new: bytes) -> None:
    data = mesh_files.ply(SQUARE, TWO, "ascii")
    assert old in data
    with pytest.raises(MeshError, match="line of the PLY file cannot be read"):
        read_mesh(data.replace(old, new, 1), "ply")


def test_binary_ply_list_lengths_are_all_believed() -> None:
    """Two faces of three corners have as many bytes whatever the second says of its length."""
    data = mesh_files.ply(SQUARE, TWO)
    for length in (2, 4, 255):
        wrong = data[:-13] + bytes([length]) + data[-12:]
        with pytest.raises(MeshError, match=r"cut off|more than its header"):
            read_mesh(wrong, "ply")


def _ply(encoding: str, kind: str, face_first: str, body: bytes) -> bytes:
    header = (
        f"ply\r\nformat {encoding} 1.0\r\nobj_info none\r\nelement vertex 3\r\n"
        f"property float x\r\nproperty {kind} red\r\nproperty {kind} green\r\n"
        f"property {kind} blue\r\nproperty float y\r\nproperty float z\r\n"
        f"element edge 1\r\nproperty int vertex1\r\nproperty int vertex2\r\n"
        f"element face 1\r\nproperty uchar flags\r\n{face_first}"
        "property list uchar uint vertex_index\r\nproperty float quality\r\nend_header\r\n"
    )
    return header.encode() + body


TEXCOORD = "property list uchar float texcoord\r\n"


@pytest.mark.parametrize("encoding", ["ascii", "binary_little_endian"])
@pytest.mark.parametrize("properties", [1001, 30_000])
def test_ply_headers_of_endless_properties_are_refused(encoding: str, properties: int) -> None:
    lines = "".join(f"property list uchar float p{n}\n" for n in range(properties - 4))
    data = mesh_files.ply(SQUARE, TWO, encoding).replace(
        b"element face", lines.encode() + b"element face"
    )
    with pytest.raises(MeshError, match="more than 1000 properties"):
        read_mesh(data, "ply")


@pytest.mark.parametrize("count", ["9" * 5000, "-4", "4.0", "\u0664", ""])
def test_ply_counts_that_are_none(count: str) -> None:
    data = mesh_files.ply(SQUARE, TWO, "ascii")
    data = data.replace(b"element vertex 4", b"element vertex " + count.encode())
    with pytest.raises(MeshError, match="line of the PLY header cannot be read"):
        read_mesh(data, "ply")


@pytest.mark.parametrize("texcoord", ["", TEXCOORD])
def test_ply_with_colors_and_other_properties(texcoord: str) -> None:
    corner = np.dtype([("x", "<f4"), ("rgb", "u1", 3), ("yz", "<f4", 2)])
    rows = np.array([(x, (255, 0, 51), (y, z)) for x, y, z in SQUARE[:3].tolist()], corner)
    uv = b"\2" + np.array([0.5, np.nan], "<f4").tobytes() if texcoord else b""
    indices = b"\3" + np.array([0, 1, 2], "<u4").tobytes()
    edge = np.array([0, 1], "<i4").tobytes()
    body = rows.tobytes() + edge + b"\1" + uv + indices + np.array([2.5], "<f4").tobytes()
    binary = read_mesh(_ply("binary_little_endian", "uchar", texcoord, body), "ply")
    text_rows = [f"{x} 255 0 51 {y} {z}\r\n" for x, y, z in SQUARE[:3].tolist()]
    uv_text = "2 0.5 nan " if texcoord else ""
    text_body = "".join([*text_rows, "0 1\r\n", f"1 {uv_text}3 0 1 2 2.5\r\n"]).encode()
    text = read_mesh(_ply("ascii", "uchar", texcoord, text_body), "ply")
    for mesh in (binary, text):
        np.testing.assert_array_equal(mesh.vertices, SQUARE[:3])
        assert mesh.faces.tolist() == [[0, 1, 2]]
        assert mesh.colors is not None
        np.testing.assert_allclose(mesh.colors, np.tile([1.0, 0.0, 0.2], (3, 1)), atol=1e-12)


@pytest.mark.parametrize(
    ("kind", "red"), [("float", "1 0 0.2"), ("ushort", "65535 0 13107"), ("int", "255 0 51")]
)
def test_ply_colors_of_other_types(kind: str, red: str) -> None:
    body = "".join(f"{x} {red} {y} {z}\n" for x, y, z in SQUARE[:3].tolist())
    data = _ply("ascii", kind, "", f"{body}0 1\n1 3 0 1 2 2.5\n".encode())
    colors = read_mesh(data, "ply").colors
    assert colors is not None
    np.testing.assert_array_equal(colors, np.tile([1.0, 0.0, 0.2], (3, 1)))


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (b"element face", b"element tristrips", "strips"),
        (b"element vertex", b"element corner", "no vertices"),
        (b"double x", b"double a", "no x"),
        (b"double x", b"half x", "property"),
        (b"vertex_indices", b"corners", "no list of integers"),
        (b"uchar int", b"uchar float", "no list of integers"),
        (b"uchar int", b"float int", "property"),
        (b"format", b"flavour", "line of the PLY header"),
        (b"end_header", b"header_ends", "does not end"),
        (b"double y", b"double x", "twice"),
        (b"comment made by hand\n", b"element vertex 0\n", "twice"),
    ],
)
def test_broken_ply_headers(old: bytes, new: bytes, message: str) -> None:
    data = mesh_files.ply(SQUARE, TWO)
    assert old in data
    with pytest.raises(MeshError, match=message):
        read_mesh(data.replace(old, new, 1), "ply")


@pytest.mark.parametrize("index", [-1, 4, 2**31 - 1])
@pytest.mark.parametrize("encoding", ["ascii", "binary_little_endian"])
def test_ply_indices_out_of_range(index: int, encoding: str) -> None:
    with pytest.raises(MeshError, match=f"vertex {index}"):
        read_mesh(mesh_files.ply(SQUARE, [[0, 1, index]], encoding), "ply")


def test_binary_ply_changed_by_a_text_transfer() -> None:
    data = mesh_files.ply(np.concatenate([SQUARE, [[5e-324 * 10, 0, 0]]]), TWO)
    with pytest.raises(MeshError, match=r"more than its header|cut off"):
        read_mesh(data.replace(b"\n", b"\r\n"), "ply")


# --- STL ------------------------------------------------------------------------------------------


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


# --- glTF -----------------------------------------------------------------------------------------


def test_gltf_seams_are_closed_and_ids_are_those_of_first_appearance() -> None:
    vertices = np.concatenate([SQUARE[:3], SQUARE[[0, 2, 3]]])
    mesh = read_mesh(mesh_files.glb(vertices, np.array([[0, 1, 2], [3, 4, 5]])), "glb")
    assert mesh.faces.tolist() == TWO
    assert mesh.vertex_ids.tolist() == [0, 1, 2, 5]
    assert mesh.warnings == (
        "glTF repeats vertices along texture seams and creases: 6 vertices were merged into 4",
    )


def test_gltf_meshes_are_joined_and_placed_by_their_nodes() -> None:
    tree, buffer = mesh_files.gltf_tree(SQUARE, np.array(TWO))
    tree["nodes"] = [
        {"children": [1, 2], "translation": [0, 0, 10]},
        {"mesh": 0},
        {"mesh": 0, "translation": [5, 0, 0], "scale": [-2, 2, 2]},
    ]
    mesh = read_mesh(mesh_files.glb_of(tree, buffer), "glb")
    placed = np.concatenate([SQUARE, SQUARE * [-2, 2, 2] + np.array([5.0, 0, 0])])
    placed[:, 2] += 10.0
    order = np.lexsort(mesh.vertices.T)
    np.testing.assert_allclose(mesh.vertices[order], placed[np.lexsort(placed.T)], atol=1e-12)
    assert mesh.components == 2
    a, b, c = (mesh.vertices[mesh.faces[:, corner]] for corner in range(3))
    assert (np.cross(b - a, c - a)[:, 2] > 0.0).all()  # the mirror image is not inside out
    assert "2 meshes of the scene were joined" in mesh.warnings


def test_gltf_colors() -> None:
    tree, buffer = mesh_files.gltf_tree(SQUARE, np.array(TWO))
    colors = np.tile(np.array([255, 0, 51, 255], np.uint8), (4, 1)).tobytes()
    tree["bufferViews"].append({"buffer": 0, "byteOffset": len(buffer), "byteLength": len(colors)})
    tree["accessors"].append(
        {"bufferView": 2, "componentType": 5121, "normalized": True, "count": 4, "type": "VEC4"}
    )
    tree["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = 2
    mesh = read_mesh(mesh_files.glb_of(tree, buffer + colors), "glb")
    assert mesh.colors is not None
    np.testing.assert_allclose(mesh.colors, np.tile([1.0, 0.0, 0.2], (4, 1)), atol=1e-12)


def test_gltf_with_its_buffer_inside() -> None:
    tree, buffer = mesh_files.gltf_tree(SQUARE, np.array(TWO))
    uri = "data:application/octet-stream;base64," + base64.b64encode(buffer).decode()
    tree["buffers"][0]["uri"] = uri
    mesh = read_mesh(json.dumps(tree).encode(), "gltf")
    np.testing.assert_array_equal(mesh.vertices, SQUARE)
    assert mesh.faces.tolist() == TWO
    tree["buffers"][0]["uri"] = "../../secret.bin"
    with pytest.raises(MeshError, match="other files"):
        read_mesh(json.dumps(tree).encode(), "gltf")


def test_gltf_that_would_be_misread_is_refused() -> None:
    faces = np.array(TWO)
    tree, buffer = mesh_files.gltf_tree(SQUARE, faces)
    with pytest.raises(MeshError, match="KHR_draco_mesh_compression"):
        read_mesh(
            mesh_files.glb_of(
                tree | {"extensionsRequired": ["KHR_draco_mesh_compression"]}, buffer
            ),
            "glb",
        )
    sparse, _ = mesh_files.gltf_tree(SQUARE, faces)
    sparse["accessors"][0]["sparse"] = {"count": 1}
    with pytest.raises(MeshError, match="sparse"):
        read_mesh(mesh_files.glb_of(sparse, buffer), "glb")
    quantised, _ = mesh_files.gltf_tree(SQUARE, faces)
    quantised["accessors"][0]["componentType"] = 5122
    with pytest.raises(MeshError, match="quantised"):
        read_mesh(mesh_files.glb_of(quantised, buffer), "glb")
    with pytest.raises(MeshError, match="vertex 4"):
        read_mesh(mesh_files.glb(SQUARE, np.array([[0, 1, 4]])), "glb")
    lines, _ = mesh_files.gltf_tree(SQUARE, faces)
    lines["meshes"][0]["primitives"][0]["mode"] = 1
    with pytest.raises(MeshError, match="no triangles"):
        read_mesh(mesh_files.glb_of(lines, buffer), "glb")


def test_gltf_scenes_that_are_no_trees_are_refused() -> None:
    tree, buffer = mesh_files.gltf_tree(SQUARE, np.array(TWO))

    def chain(levels: int) -> list[dict[str, Any]]:
        return [{"children": [n + 1]} for n in range(levels - 1)] + [{"mesh": 0}]

    assert read_mesh(mesh_files.glb_of(tree | {"nodes": chain(200)}, buffer), "glb").n_faces == 2
    for nodes, what in (
        (chain(5000), "levels"),
        ([{"mesh": 0, "children": [0]}], "ring"),
        ([{"mesh": 0}, {"children": [2]}, {"mesh": 0, "children": [1]}], "ring"),
        ([{"mesh": 0, "children": [1, 1]}, {"mesh": 0}], "two parents"),
        ([{"mesh": 0, "children": [7]}], "node 7"),
        ([{"mesh": -1}], "mesh -1"),
        ([{"mesh": True}], "mesh True"),
    ):
        with pytest.raises(MeshError, match=what):
            read_mesh(mesh_files.glb_of(tree | {"nodes": nodes}, buffer), "glb")


def test_gltf_that_shows_a_mesh_again_and_again_is_refused() -> None:
    sphere = shapes.icosphere(4)
    tree, buffer = mesh_files.gltf_tree(sphere.vertices, sphere.faces)
    for count, refused in ((20, False), (200, True)):
        tree["nodes"] = [{"mesh": 0, "translation": [3 * n, 0, 0]} for n in range(count)]
        tree["scenes"] = [{"nodes": list(range(count))}]
        data = mesh_files.glb_of(tree, buffer)
        if refused:
            with pytest.raises(MeshError, match="far too often"):
                read_mesh(data, "glb")
        else:
            assert read_mesh(data, "glb").n_faces == count * sphere.n_faces


@pytest.mark.parametrize("count", [0, -3, 3.0, "3", True])
def test_gltf_counts_that_are_none_are_refused(count: Any) -> None:
    tree, buffer = mesh_files.gltf_tree(SQUARE, np.array(TWO))
    tree["accessors"][1]["count"] = count
    with pytest.raises(MeshError, match="no values"):
        read_mesh(mesh_files.glb_of(tree, buffer), "glb")


def test_gltf_indices_do_not_count_from_the_end() -> None:
    tree, buffer = mesh_files.gltf_tree(SQUARE, np.array(TWO))
    tree["meshes"][0]["primitives"][0]["indices"] = -1
    with pytest.raises(MeshError, match="accessor -1"):
        read_mesh(mesh_files.glb_of(tree, buffer), "glb")


@pytest.mark.parametrize("length", [0, 20, 2**32 - 1])
def test_glb_lengths_that_lie_are_refused(length: int) -> None:
    data = bytearray(mesh_files.glb(SQUARE, np.array(TWO)))
    data[8:12] = struct.pack("<I", length)
    with pytest.raises(MeshError, match=r"damaged|cut off"):
        read_mesh(bytes(data), "glb")


def test_cuts_in_the_surface_are_closed() -> None:
    vertices = np.concatenate([SQUARE[:3], SQUARE[[0, 2, 3]]])
    mesh = read_mesh(mesh_files.off(vertices, [[0, 1, 2], [3, 4, 5]]), "off")
    assert mesh.components == 1
    assert mesh.vertex_ids.tolist() == [0, 1, 2, 5]
    assert mesh.vertices_of(np.arange(7)).tolist() == [0, 1, 2, 0, 2, 3, -1]
    assert mesh.warnings[0].startswith("closed seams: merged 2 border vertices")


# --- anything at all ------------------------------------------------------------------------------

MAGIC = [b"OFF\n", b"v 0 0 0\nf ", b"ply\n", b"solid \n", b"glTF\2\0\0\0", b"{", b""]
TETRAHEDRA = {name: writer(rounded(shapes.tetrahedron())) for name, writer in WRITERS.items()}


def read_or_refuse(data: bytes, file_type: str) -> None:
    try:
        mesh = read_mesh(data, file_type)
    except MeshError:
        return
    assert np.isfinite(mesh.vertices).all()
    assert 0.0 < mesh.area < np.inf
    assert mesh.faces.min() == 0
    assert mesh.faces.max() == mesh.n_vertices - 1


@settings(max_examples=150, deadline=None)
@given(st.sampled_from(MESH_FORMATS), st.sampled_from(MAGIC), st.binary(max_size=300))
@pytest.mark.filterwarnings("ignore")
def test_random_bytes(file_type: str, magic: bytes, data: bytes) -> None:
    read_or_refuse(magic + data, file_type)


@settings(max_examples=400, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(
    st.sampled_from(sorted(TETRAHEDRA)),
    st.lists(
        st.tuples(
            st.floats(0.0, 1.0),
            st.integers(0, 8),
            st.one_of(
                st.binary(max_size=8), st.sampled_from([b"-1", b"nan", b"1e400", b"\n", b"9" * 20])
            ),
        ),
        min_size=1,
        max_size=4,
    ),
)
@pytest.mark.filterwarnings("ignore")
def test_damaged_files(name: str, damages: list[tuple[float, int, bytes]]) -> None:
    data, file_type = TETRAHEDRA[name]
    for place, removed, inserted in damages:
        start = int(place * len(data))
        data = data[:start] + inserted + data[start + removed :]
    read_or_refuse(data, file_type)
