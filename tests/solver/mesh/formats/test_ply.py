"""PLY: text and binary, its polygons and colours, and headers that lie."""

import codecs
import time

import numpy as np
import pytest

from solver.errors import MeshError
from solver.mesh import read_mesh, triangle_areas
from tests.solver.mesh import mesh_files
from tests.solver.mesh.mesh_files import SQUARE, TWO

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
@pytest.mark.parametrize("properties", [1101, 30_000])
def test_ply_headers_of_endless_properties_are_refused(encoding: str, properties: int) -> None:
    lines = "".join(f"property list uchar float p{n}\n" for n in range(properties - 4))
    data = mesh_files.ply(SQUARE, TWO, encoding).replace(
        b"element face", lines.encode() + b"element face"
    )
    with pytest.raises(MeshError, match="more than 1100 properties"):
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


@pytest.mark.parametrize(
    ("comment", "texcoord", "said"),
    [
        ("TextureFile skin 1.png", True, "the image 'skin 1.png'"),
        ("TextureFile skin.png", False, "the image 'skin.png'"),
        ("made by hand", True, "places in an image"),
        ("a TextureFile", False, None),
    ],
)
def test_a_warning_says_that_textures_are_not_read(
    comment: str, texcoord: bool, said: str | None
) -> None:
    places = " 6 0 0 1 0 0 1" if texcoord else ""
    lines = ["ply", "format ascii 1.0", f"comment {comment}", "element vertex 3"]
    lines += [f"property float {axis}" for axis in "xyz"]
    lines += ["element face 1", "property list uchar int vertex_indices"]
    lines += ["property list uchar float texcoord"] * texcoord
    lines += ["end_header", "0 0 0", "1 0 0", "0 1 0", f"3 0 1 2{places}", ""]
    warnings = read_mesh("\n".join(lines).encode(), "ply").warnings
    expected = [] if said is None else [f"the file refers to {said}: textures of PLY files are not"]
    assert [one[: one.find(" read;")] for one in warnings if "PLY" in one] == expected


def test_short_rows_of_many_properties_are_refused_at_the_first() -> None:
    """Each was filled property by property: half a megabyte took minutes and gigabytes."""
    lines = "".join(f"property float p{n}\n" for n in range(1000)).encode()
    data = mesh_files.ply(SQUARE, TWO, "ascii").replace(b"element face", lines + b"element face")
    data = data.replace(b"element vertex 4", b"element vertex 300000") + 300_000 * b"1\n"
    start = time.thread_time()
    with pytest.raises(MeshError, match="p0 has not as many values as it promises"):
        read_mesh(data, "ply")
    assert time.thread_time() - start < 5.0


@pytest.mark.parametrize("size", ["-3", "9" * 30, str(2**31)])
def test_lengths_of_lists_in_text_that_cannot_be(size: str) -> None:
    data = mesh_files.ply(SQUARE, TWO, "ascii").replace(b"3 0 2 3\n", size.encode() + b" 0 2 3\n")
    with pytest.raises(MeshError, match="vertex_indices has not as many values as it promises"):
        read_mesh(data, "ply")


@pytest.mark.parametrize("line_break", [b"\n", b"\r\n", b"\r"])
@pytest.mark.parametrize("start", [b"", codecs.BOM_UTF8])
def test_text_ply_of_other_systems(line_break: bytes, start: bytes) -> None:
    data = start + mesh_files.ply(SQUARE, TWO, "ascii").replace(b"\n", line_break)
    mesh = read_mesh(data, "ply")
    np.testing.assert_array_equal(mesh.vertices, SQUARE)
    assert mesh.faces.tolist() == TWO
    assert not mesh.warnings


def test_text_ply_with_more_lines_than_promised_is_told() -> None:
    mesh = read_mesh(mesh_files.ply(SQUARE, TWO, "ascii") + b"3 0 1 3\n", "ply")
    assert mesh.faces.tolist() == TWO
    assert mesh.warnings == ("lines after the last row of the PLY file were ignored",)


def test_ply_headers_with_two_formats_are_refused() -> None:
    data = mesh_files.ply(SQUARE, TWO, "ascii")
    twice = data.replace(b"ply\n", b"ply\nformat binary_big_endian 1.0\n", 1)
    with pytest.raises(MeshError, match="says its format twice"):
        read_mesh(twice, "ply")
