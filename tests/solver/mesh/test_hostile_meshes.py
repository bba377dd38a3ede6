"""Small files that would take long to read: refused soon and with the reason, or read soon.

Times are of the processor, so that other processes do not matter; all bounds are several times
what is needed, and a small part of what it was before there were limits.
"""

import struct
import time
import zipfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
import pytest

from solver.errors import MeshError
from solver.mesh import read_mesh
from tests.solver.mesh import mesh_files
from tests.solver.mesh.textures.textured_files import (
    grid,
    image_file,
    textured_obj,
    textured_tree,
    zipped,
)

SQUARE = b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"
VERTICES, FACES = grid(4)
UV = VERTICES[:, :2]
PIXEL = image_file(np.full((1, 1, 3), 128, np.uint8))


@contextmanager
def within(seconds: float) -> Iterator[None]:
    start = time.thread_time()
    yield
    assert time.thread_time() - start < seconds


@pytest.fixture(autouse=True, scope="module")
def kernels() -> None:
    """Compiled before anything is timed."""
    read_mesh(mesh_files.ply(VERTICES, FACES.tolist()), "ply")


def bomb(name: str, line: bytes) -> bytes:
    return zipped({name: SQUARE + line * (64 * 2**20 // len(line))})


@pytest.mark.parametrize(
    ("name", "line"),
    [("a.obj", b"f 1 2 3\n"), ("a.off", b"\n"), ("a.glb", b"\0" * 1024)],
    ids=["obj", "off", "glb"],
)
def test_archives_of_far_more_than_their_size_are_refused_unread(name: str, line: bytes) -> None:
    data = bomb(name, line)
    assert len(data) < 2**18
    with within(0.5), pytest.raises(MeshError, match="far too much for its size"):
        read_mesh(data, "zip")


def test_an_image_that_is_nothing_packed_is_refused() -> None:
    picture = image_file(np.zeros((2048, 2048, 3), np.uint8), "BMP")
    files = {
        "skin.obj": textured_obj(VERTICES, FACES, UV),
        "skin.mtl": b"newmtl skin\nmap_Kd skin.bmp\n",
    }
    with pytest.raises(MeshError, match="images as PNG or JPEG"):
        read_mesh(zipped(files | {"skin.bmp": picture}), "zip")
    png = image_file(np.zeros((2048, 2048, 3), np.uint8))
    assert len(png) < len(picture) / 500
    read_mesh(zipped(files | {"skin.bmp": png}), "zip")


def test_archives_may_be_packed_as_well_as_meshes_can_be() -> None:
    """Large numbers of a few digits, in rows of one length: text that is packed better is rare."""
    vertices, faces = grid(200)
    data = zipped({"a.obj": mesh_files.obj(np.round(100.0 * vertices), faces.tolist())})
    assert read_mesh(data, "zip").n_faces > 0


def test_lists_of_different_lengths_are_read_in_linear_time() -> None:
    """A row at a time through NumPy, this took ten seconds."""
    count = 100_000
    rows = struct.pack("<B3iB4i", 3, 0, 1, 6, 4, 0, 1, 6, 5) * count
    data = mesh_files.ply(VERTICES, [])
    data = data.replace(b"element face 0", b"element face %d" % (2 * count)) + rows
    with within(4.0):
        assert read_mesh(data, "ply").n_faces == 2


@pytest.mark.parametrize("kind", ["char", "short", "ushort", "int", "uint", "int64", "uint64"])
@pytest.mark.parametrize("order", ["<", ">"])
def test_lengths_of_lists_of_every_type(kind: str, order: str) -> None:
    code = {"char": "b", "short": "h", "ushort": "H", "int": "i", "uint": "I", "int64": "q"}
    encoding = {"<": "binary_little_endian", ">": "binary_big_endian"}[order]
    data = mesh_files.ply(VERTICES, [], encoding)
    data = data.replace(b"element face 0", b"element face 2").replace(b"uchar", kind.encode())
    size = order + code.get(kind, "Q")
    rows = b"".join(struct.pack(size + "3i", 3, *face) for face in FACES[:2].tolist())
    np.testing.assert_array_equal(read_mesh(data + rows, "ply").vertex_ids, np.unique(FACES[:2]))
    longest = {"char": 127, "short": 2**15 - 1, "int": 2**31 - 1, "int64": 2**63 - 1}
    most = longest.get(kind, 2 ** (8 * struct.calcsize(size)) - 1)
    with pytest.raises(MeshError, match=r"cut off|negative"):
        read_mesh(data + rows[: len(rows) // 2] + struct.pack(size + "3i", most, 0, 1, 2), "ply")
    if kind in longest:
        with pytest.raises(MeshError, match="negative length"):
            read_mesh(data + struct.pack(size + "3i", -1, 0, 1, 2) + rows, "ply")


def circles(count: int) -> bytes:
    angles = np.linspace(0.0, 2.0 * np.pi, 5000, endpoint=False)
    points = np.stack([np.cos(angles), np.sin(angles), np.zeros(5000)], axis=1)
    return mesh_files.obj(points, count * [list(range(5000))])


def test_polygons_that_would_take_minutes_together_are_refused() -> None:
    many = circles(11)
    with within(1.0), pytest.raises(MeshError, match=r"up to 5000 corners.* save the mesh as"):
        read_mesh(many, "obj")
    with within(5.0):
        assert read_mesh(circles(10), "obj").n_faces == 4998


def test_a_polygon_that_crosses_itself_two_thousand_times_is_cut_soon() -> None:
    angles = 2.0 * np.pi * 2001 * np.arange(4999) / 4999
    star = np.stack([np.cos(angles), np.sin(angles), np.zeros(4999)], axis=1)
    data = mesh_files.obj(star, [list(range(4999))])
    with within(20.0):
        mesh = read_mesh(data, "obj")
    assert any("crosses itself" in warning for warning in mesh.warnings)


def scene(change: Callable[[dict[str, Any]], None]) -> bytes:
    tree, buffer = textured_tree(VERTICES, FACES, UV, PIXEL)
    change(tree)
    return mesh_files.glb_of(tree, buffer)


def test_a_scene_of_endless_parts_is_refused() -> None:
    def many_nodes(tree: dict[str, Any]) -> None:
        tree["nodes"] = 20_001 * [{"mesh": 0}]
        tree["meshes"][0]["primitives"][0] = {"attributes": {"POSITION": 0}, "mode": 5}
        tree["padding"] = "x" * 2**19

    with within(2.0), pytest.raises(MeshError, match="20001 parts, more than 20000; join them"):
        read_mesh(scene(many_nodes), "glb")


def test_numbers_that_are_read_again_and_again_are_counted() -> None:
    def wide_colors(tree: dict[str, Any]) -> None:
        tree["buffers"][0]["byteLength"] += 2**20
        tree["bufferViews"].append({"buffer": 0, "byteOffset": 0, "byteLength": 2**20})
        tree["accessors"].append(
            {"bufferView": 4, "componentType": 5121, "count": 2**18, "type": "VEC4"}
        )
        (primitive,) = tree["meshes"][0]["primitives"]
        primitive["attributes"]["COLOR_0"] = 3
        tree["meshes"][0]["primitives"] = 100 * [primitive]
        tree["padding"] = "x" * 2**17

    with within(1.0), pytest.raises(MeshError, match="far too often"):
        read_mesh(scene(wide_colors), "glb")


def test_one_image_named_a_thousand_times_over() -> None:
    def many_images(tree: dict[str, Any]) -> None:
        count = 1001
        tree["images"] *= count
        tree["textures"] = [{"source": number} for number in range(count)]
        tree["materials"] = [
            {"pbrMetallicRoughness": {"baseColorTexture": {"index": number}}}
            for number in range(count)
        ]
        (primitive,) = tree["meshes"][0]["primitives"]
        tree["meshes"][0]["primitives"] = [
            primitive | {"material": number} for number in range(count)
        ]
        tree["padding"] = "x" * 2**18

    with within(5.0), pytest.raises(MeshError, match="more than 1000 images"):
        read_mesh(scene(many_images), "glb")


def test_a_progressive_jpeg_of_endless_scans_is_refused() -> None:
    picture = image_file(np.zeros((4096, 4096, 3), np.uint8), "JPEG", progressive=True)
    last = picture.rindex(b"\xff\xda")
    endless = picture[:last] + 200 * picture[last:-2] + picture[-2:]
    files = {
        "skin.obj": textured_obj(VERTICES, FACES, UV),
        "skin.mtl": b"newmtl skin\nmap_Kd skin.jpg\n",
    }
    with within(1.0), pytest.raises(MeshError, match="more than 24 scans"):
        read_mesh(zipped(files | {"skin.jpg": endless}), "zip")
    # What follows the picture, as programs append films to it, is none.
    small = image_file(np.zeros((16, 16, 3), np.uint8), "JPEG", progressive=True)
    film = small + 200 * b"\xff\xda\0\0"
    assert read_mesh(zipped(files | {"skin.jpg": film}), "zip").colors is not None


def test_materials_and_names_of_images_are_read_in_linear_time() -> None:
    """One by one over all faces, or over all names, this took minutes."""
    count = 20_000
    faces = "".join(f"usemtl {n}\nf 1/1 2/1 {3 + n % 2}/1\n" for n in range(count))
    library = "".join(f"newmtl {n}\nmap_Kd x{n}/../../skin.png\n" for n in range(count))
    files = {
        "a.obj": SQUARE + b"vt 0 0\nmtllib a.mtl\n" + faces.encode(),
        "a.mtl": library.encode(),
        "skin.png": PIXEL,
    }
    archive = zipped(files | {f"{n}.txt": b"" for n in range(900)}, zipfile.ZIP_STORED)
    with within(6.0):
        mesh = read_mesh(archive, "zip")
    assert mesh.colors is not None
    np.testing.assert_allclose(mesh.colors, 128 / 255)


def test_materials_that_no_face_uses_are_not_parsed() -> None:
    """A million of them took twenty seconds and a gigabyte."""
    library = b"".join(b"newmtl m%d\nKd 1 0 0\n" % number for number in range(300_000))
    files = {
        "skin.obj": textured_obj(VERTICES, FACES, UV),
        "skin.mtl": library + b"newmtl unused\nKd red\nnewmtl skin\nmap_Kd skin.png\n",
        "skin.png": PIXEL,
    }
    with within(3.0):
        mesh = read_mesh(zipped(files), "zip")
    assert mesh.colors is not None
    np.testing.assert_allclose(mesh.colors, 128 / 255)


def test_an_image_of_endless_options_is_refused() -> None:
    library = b"newmtl skin\nmap_Kd " + 10_000 * b"-o 1 2 3 " + b"skin.png\n"
    files = {"skin.obj": textured_obj(VERTICES, FACES, UV), "skin.mtl": library}
    with pytest.raises(MeshError, match="more options than there are"):
        read_mesh(zipped(files | {"skin.png": PIXEL}), "zip")


@pytest.mark.parametrize(("vertices", "faces"), [(500, 60_000), (3_000, 60_000), (30_000, 60_000)])
def test_random_faces_are_no_surface(vertices: int, faces: int) -> None:
    """Repaired and matched, they took minutes and gigabytes."""
    rng = np.random.default_rng(vertices)
    corners = rng.integers(0, vertices, (faces, 3))
    data = mesh_files.ply(rng.normal(size=(vertices, 3)), corners.tolist())
    with within(3.0), pytest.raises(MeshError, match="the faces are no surface"):
        read_mesh(data, "ply")


def test_what_is_a_surface_is_none_of_these() -> None:
    """Triangles on their own have an irregular edge for each vertex, pages of a book nearly two."""
    alone = np.random.default_rng(0).normal(size=(3000, 3))
    assert read_mesh(mesh_files.ply(alone, np.arange(3000).reshape(-1, 3).tolist()), "ply").n_faces
    pages = np.random.default_rng(1).normal(size=(1002, 3))
    book = [[0, 1, page] for page in range(2, 1002)]
    assert read_mesh(mesh_files.ply(pages, book), "ply").n_faces == 1000


def test_clouds_of_too_many_points_are_refused_soon() -> None:
    rows = np.random.default_rng(0).random((250_001, 3)).astype("<f4")
    header = (
        "ply\nformat binary_little_endian 1.0\nelement vertex 250001\n"
        "property float x\nproperty float y\nproperty float z\nend_header\n"
    )
    with within(3.0), pytest.raises(MeshError, match="thin them out"):
        read_mesh(header.encode() + rows.tobytes(), "ply")


def test_very_many_separate_triangles_are_refused_soon() -> None:
    """Linked to one surface, 60,000 keep a spectrum busy for minutes."""
    rng = np.random.default_rng(0)
    corners = rng.random((20_100, 1, 3)) + 1e-3 * rng.random((20_100, 3, 3))
    data = mesh_files.ply(corners.reshape(-1, 3), np.arange(60_300).reshape(-1, 3).tolist())
    with within(6.0), pytest.raises(MeshError, match="separate ones of comparable size"):
        read_mesh(data, "ply")
