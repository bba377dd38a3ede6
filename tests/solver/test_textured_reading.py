"""Textured files: what is on the surface becomes colours of vertices, or is refused or told."""

import base64
import json
import struct
import time
import tracemalloc
import zipfile
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image

from solver.arrays import BoolArray, FloatArray, IntArray
from solver.errors import MeshError
from solver.mesh import TriangleMesh, read_mesh
from solver.textures import display_values
from tests.solver import mesh_files
from tests.solver.textured_files import (
    MTL,
    grid,
    image_file,
    ramp,
    textured_glb,
    textured_obj,
    textured_tree,
    zipped,
    zipped_obj,
)

VERTICES, FACES = grid(8)
UV = VERTICES[:, :2]
RAMP = image_file(ramp())
INNER: BoolArray = np.all((UV > 0.05) & (UV < 0.95), axis=1)


def colors_of(mesh: TriangleMesh) -> FloatArray:
    assert mesh.colors is not None
    return mesh.colors


def on_ramp(coordinates: FloatArray) -> FloatArray:
    """Red and green of the ramp, v downwards."""
    return (coordinates * 256 - 0.5) / 255.0


# --- glTF -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("stored", ["<f4", "u1", "<u2"])
def test_glb_textures_are_on_the_vertices_with_v_downwards(stored: str) -> None:
    greatest = {"u1": 255, "<u2": 65535}.get(stored, 1)
    coordinates = (UV * greatest).round(7 if stored == "<f4" else 0).astype(stored)
    mesh = read_mesh(textured_glb(VERTICES, FACES, coordinates, RAMP), "glb")
    assert mesh.warnings == ()
    tolerance = 2e-5 if stored == "<f4" else 1 / 255
    np.testing.assert_allclose(colors_of(mesh)[INNER, :2], on_ramp(UV[INNER]), atol=tolerance)


def test_glb_as_trimesh_writes_it() -> None:
    """An independent writer, which turns v round."""
    visual: Any = trimesh.visual
    skin = visual.material.PBRMaterial(baseColorTexture=Image.fromarray(ramp()))
    shown = trimesh.Trimesh(
        VERTICES, FACES, visual=visual.TextureVisuals(uv=UV, material=skin), process=False
    )
    data = shown.export(file_type="glb")
    assert isinstance(data, bytes)
    mesh = read_mesh(data, "glb")
    expected = on_ramp(np.stack([UV[:, 0], 1.0 - UV[:, 1]], axis=1))
    np.testing.assert_allclose(colors_of(mesh)[INNER, :2], expected[INNER], atol=2e-5)


def test_factors_are_of_linear_light_and_solid_colors_count_if_they_differ() -> None:
    white = image_file(np.full((2, 2, 3), 255, np.uint8))
    grey = {"baseColorFactor": [0.21586, 1.0, 0.0, 0.5]}
    mesh = read_mesh(textured_glb(VERTICES, FACES, UV, white, material=grey), "glb")
    np.testing.assert_allclose(colors_of(mesh), np.tile([128 / 255, 1, 0], (81, 1)), atol=1e-5)
    tree, buffer = mesh_files.gltf_tree(VERTICES, FACES)
    tree["materials"] = [{"pbrMetallicRoughness": grey}, {}]
    tree["meshes"][0]["primitives"][0]["material"] = 0
    assert read_mesh(mesh_files.glb_of(tree, buffer), "glb").colors is None
    halves = [dict(tree["meshes"][0]["primitives"][0]) for _ in range(2)]
    tree["meshes"] = [{"primitives": [halves[0] | {"indices": 2}, halves[1] | {"indices": 3}]}]
    halves[1]["material"] = 1
    tree["meshes"][0]["primitives"][1]["material"] = 1
    for start in (0, len(FACES) // 2):
        tree["accessors"].append(
            tree["accessors"][1] | {"byteOffset": 12 * start, "count": 3 * len(FACES) // 2}
        )
    mesh = read_mesh(mesh_files.glb_of(tree, buffer), "glb")
    assert mesh.n_vertices == len(VERTICES)
    np.testing.assert_allclose(colors_of(mesh)[8], [128 / 255, 1, 0], atol=1e-4)
    np.testing.assert_allclose(colors_of(mesh)[72], [1, 1, 1], atol=1e-7)


def test_materials_that_tint_one_image_share_it() -> None:
    """Twelve images of 17 million texels would be 600 MB, and a minute's work."""
    image = image_file(np.full((4096, 4096, 3), 255, np.uint8))
    tree, buffer = textured_tree(VERTICES, FACES, UV, image)
    (primitive,) = tree["meshes"][0]["primitives"]
    (material,) = tree["materials"]
    factors = np.linspace(0.1, 0.9, 12)
    tree["materials"] = [
        {"pbrMetallicRoughness": material["pbrMetallicRoughness"] | {"baseColorFactor": 4 * [x]}}
        for x in factors
    ]
    tree["meshes"][0]["primitives"] = [primitive | {"material": k} for k in range(12)]
    tracemalloc.start()
    mesh = read_mesh(mesh_files.glb_of(tree, buffer), "glb")
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < 400 * 2**20
    expected = display_values(factors).mean()
    np.testing.assert_allclose(colors_of(mesh), expected, atol=1e-9)


def test_several_textures_second_coordinates_wraps_and_transformations() -> None:
    tree, buffer = textured_tree(VERTICES, FACES, UV, RAMP)
    placed = tree["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]
    # The example in the extension's own text: the lower left quadrant, turned clockwise.
    transform = {"offset": [0, 1], "rotation": np.pi / 2, "scale": [0.5, 0.5]}
    placed["extensions"] = {"KHR_texture_transform": transform}
    mesh = read_mesh(mesh_files.glb_of(tree, buffer), "glb")
    expected = np.stack([0.5 * UV[:, 1], 1.0 - 0.5 * UV[:, 0]], axis=1)
    np.testing.assert_allclose(colors_of(mesh)[INNER, :2], on_ramp(expected)[INNER], atol=2e-5)

    outside = UV + 1.0
    for wrap, shown in ((10497, UV), (33648, 1.0 - UV), (33071, np.ones_like(UV))):
        tree, buffer = textured_tree(
            VERTICES, FACES, outside, RAMP, sampler={"wrapS": wrap, "wrapT": wrap}
        )
        colors = colors_of(read_mesh(mesh_files.glb_of(tree, buffer), "glb"))
        # The border of a halved image is the mean of some texels there.
        tolerance = 0.02 if wrap == 33071 else 2e-5
        np.testing.assert_allclose(colors[INNER, :2], on_ramp(shown)[INNER], atol=tolerance)

    tree, buffer = textured_tree(VERTICES, FACES, UV, RAMP)
    attributes = tree["meshes"][0]["primitives"][0]["attributes"]
    attributes["TEXCOORD_1"] = attributes.pop("TEXCOORD_0")
    assert read_mesh(mesh_files.glb_of(tree, buffer), "glb").colors is None
    tree["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["texCoord"] = 1
    colors = colors_of(read_mesh(mesh_files.glb_of(tree, buffer), "glb"))
    np.testing.assert_allclose(colors[INNER, :2], on_ramp(UV[INNER]), atol=2e-5)


def test_vertices_split_along_seams_are_one_of_both_colors() -> None:
    left, right = UV[FACES].max(axis=1)[:, 0] <= 0.5, UV[FACES].min(axis=1)[:, 0] >= 0.5
    assert (left | right).all()
    vertices = np.concatenate([VERTICES, VERTICES])
    faces = np.concatenate([FACES[left], FACES[right] + len(VERTICES)])
    pixels = np.zeros((4, 4, 3), np.uint8)
    pixels[:, :2, 0] = 255
    uv = np.concatenate([np.full_like(UV, 0.25), np.full_like(UV, 0.75)])
    mesh = read_mesh(textured_glb(vertices, faces, uv, image_file(pixels)), "glb")
    assert mesh.n_vertices == len(VERTICES)
    assert mesh.components == 1
    x = mesh.vertices[:, 0]
    red = colors_of(mesh)[:, 0]
    np.testing.assert_allclose(red[x < 0.5], 1.0, atol=1e-9)
    np.testing.assert_allclose(red[x > 0.5], 0.0, atol=1e-9)
    np.testing.assert_allclose(red[(x == 0.5) & INNER[mesh.vertex_ids % 81]], 0.5, atol=1e-9)


@pytest.mark.parametrize(("kind", "code"), [("u1", 5121), ("<u2", 5123), ("<f4", 5126)])
@pytest.mark.parametrize("channels", [3, 4])
def test_vertex_colors_are_read_as_they_are_written(kind: str, code: int, channels: int) -> None:
    colors = np.random.default_rng(0).random((len(VERTICES), channels))
    greatest = {"u1": 255, "<u2": 65535, "<f4": 1}[kind]
    stored = (colors * greatest).round(7 if greatest == 1 else 0).astype(kind)
    padded = np.zeros((len(VERTICES), -(-stored.itemsize * channels // 4) * 4), np.uint8)
    padded[:, : stored.itemsize * channels] = stored.view(np.uint8).reshape(len(VERTICES), -1)
    tree, buffer = mesh_files.gltf_tree(VERTICES, FACES)
    tree["bufferViews"].append(
        {
            "buffer": 0,
            "byteOffset": len(buffer),
            "byteLength": padded.size,
            "byteStride": padded.shape[1],
        }
    )
    tree["accessors"].append(
        {
            "bufferView": 2,
            "componentType": code,
            "normalized": True,
            "count": len(VERTICES),
            "type": f"VEC{channels}",
        }
    )
    tree["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = 2
    found = colors_of(read_mesh(mesh_files.glb_of(tree, buffer + padded.tobytes()), "glb"))
    np.testing.assert_allclose(found, colors[:, :3], atol=0.5 / greatest if greatest > 1 else 1e-6)


def test_strips_and_fans_are_triangles() -> None:
    square = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    for mode, walk in ((5, [1, 2, 0, 3]), (6, [0, 1, 2, 3])):
        tree, buffer = mesh_files.gltf_tree(square, np.array([walk]))
        tree["meshes"][0]["primitives"][0]["mode"] = mode
        mesh = read_mesh(mesh_files.glb_of(tree, buffer), "glb")
        assert mesh.n_faces == 2
        assert mesh.area == pytest.approx(1.0)
        a, b, c = (mesh.vertices[mesh.faces[:, corner]] for corner in range(3))
        assert (np.cross(b - a, c - a)[:, 2] > 0.0).all()
        assert not any("turned" in warning for warning in mesh.warnings)


def test_gltf_images_in_uris_beside_it_and_missing() -> None:
    tree, buffer = textured_tree(VERTICES, FACES, UV, RAMP)
    inside = "data:application/octet-stream;base64," + base64.b64encode(buffer).decode()
    image = "data:image/png;base64," + base64.b64encode(RAMP).decode()
    tree["buffers"][0]["uri"] = inside
    tree["images"] = [{"uri": image}]
    alone = read_mesh(json.dumps(tree).encode(), "gltf")
    np.testing.assert_allclose(colors_of(alone)[INNER, :2], on_ramp(UV[INNER]), atol=2e-5)

    tree["images"] = [{"uri": "textures/my%20skin.png"}]
    bare = read_mesh(json.dumps(tree).encode(), "gltf")
    assert bare.colors is None
    assert any("did not come" in warning and ".zip" in warning for warning in bare.warnings)

    tree["buffers"][0]["uri"] = "shape.bin"
    files = {"a/shape.gltf": json.dumps(tree).encode(), "a/shape.bin": buffer}
    beside = read_mesh(zipped(files | {"a/textures/my skin.png": RAMP}), "zip")
    np.testing.assert_array_equal(colors_of(beside), colors_of(alone))
    with pytest.raises(MeshError, match=r"my%20skin.png', which is not in the archive"):
        read_mesh(zipped(files), "zip")


# --- OBJ in an archive ----------------------------------------------------------------------------


def test_obj_with_its_materials_has_v_upwards_and_keeps_its_numbers() -> None:
    order = np.random.default_rng(0).permutation(len(VERTICES))
    vertices = np.empty_like(VERTICES)
    vertices[order] = VERTICES
    mesh = read_mesh(zipped_obj(vertices, order[FACES], vertices[:, :2], RAMP), "zip")
    np.testing.assert_array_equal(mesh.vertices, vertices)
    np.testing.assert_array_equal(mesh.vertex_ids, np.arange(len(vertices)))
    assert mesh.warnings == ()
    uv = np.stack([vertices[:, 0], 1.0 - vertices[:, 1]], axis=1)
    inner = INNER[np.argsort(order)]
    np.testing.assert_allclose(colors_of(mesh)[inner, :2], on_ramp(uv[inner]), atol=1e-5)


def test_a_material_file_that_is_named_thousands_of_times_is_read_once() -> None:
    """Read as often as it is named, it would keep a worker busy for minutes."""
    text = b"mtllib m.mtl\n" * 5000 + b"mtllib " + b"m.mtl ./m.mtl " * 5000 + b"\n"
    text += b"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nusemtl a\nf 1 2 3\nusemtl b7\nf 1 2 4\n"
    others = b"".join(b"newmtl b%d\nKd 0 0 1\n" % number for number in range(2000))
    data = zipped({"a.obj": text, "m.mtl": b"newmtl a\nKd 1 0 0\n" + others})
    started = time.process_time()
    mesh = read_mesh(data, "zip")
    assert time.process_time() - started < 10.0
    np.testing.assert_allclose(colors_of(mesh)[[2, 3]], [[1, 0, 0], [0, 0, 1]])


def test_obj_and_glb_of_the_same_shape_have_the_same_colors() -> None:
    pixels = np.random.default_rng(5).integers(0, 256, (64, 64, 3), dtype=np.uint8)
    data = image_file(pixels)
    upwards = np.stack([UV[:, 0], 1.0 - UV[:, 1]], axis=1)
    glb = read_mesh(textured_glb(VERTICES, FACES, UV, data), "glb")
    obj = read_mesh(zipped_obj(VERTICES, FACES, upwards, data), "zip")
    np.testing.assert_allclose(colors_of(glb), colors_of(obj), atol=1e-5)


def test_obj_polygons_seams_and_several_materials() -> None:
    """A cube's side of two quadrilaterals, each of its own material; coordinates from the end."""
    obj = b"""mtllib  two materials.mtl
v 0 0 0\nv 1 0 0\nv 2 0 0\nv 0 1 0\nv 1 1 0\nv 2 1 0
vt 0.25 0.75\nvt 0.75 0.25
usemtl red
f 1/1 2/1/7 5/1 4/1
usemtl map
f -5/-1 -4/-1 -1/-1 -2/-1
"""
    pixels = np.zeros((2, 2, 3), np.uint8)
    pixels[1, 1] = 0, 0, 255  # at u = v = 3/4 downwards: v = 1/4 upwards
    mtl = b"newmtl red\nKd 1 0 0\nnewmtl map\nKd 0 0 0\nmap_Kd -clamp on -s 1 1 1 maps\\a b.png\n"
    files = {"x/two materials.mtl": mtl, "x/maps/a b.png": image_file(pixels), "x/y.obj": obj}
    mesh = read_mesh(zipped(files | {"__MACOSX/x/._y.obj": b"\0", "x/readme.txt": b""}), "zip")
    assert mesh.n_faces == 4
    colors = colors_of(mesh)
    np.testing.assert_allclose(colors[[0, 3]], np.tile([1, 0, 0], (2, 1)))
    np.testing.assert_allclose(colors[[2, 5]], np.tile([0, 0, 1], (2, 1)), atol=1e-9)
    assert ((colors[[1, 4], 0] > 0.2) & (colors[[1, 4], 2] > 0.2)).all()


def test_obj_colors_of_materials_alone() -> None:
    obj = textured_obj(VERTICES[:, :3], FACES, UV).replace(b"usemtl skin\n", b"usemtl a\n")
    lines = obj.split(b"\n")
    lines.insert(len(lines) - 20, b"usemtl b")
    two = b"newmtl a\nKd 1 0.5 0\nnewmtl b\nKd 0 0.25 1\n"
    mesh = read_mesh(zipped({"a.obj": b"\n".join(lines), "skin.mtl": two}), "zip")
    np.testing.assert_allclose(colors_of(mesh)[0], [1.0, 0.5, 0.0])
    one = read_mesh(zipped({"a.obj": obj, "skin.mtl": two}), "zip")
    assert one.colors is None  # one colour all over says nothing


def test_an_obj_alone_says_what_did_not_come() -> None:
    mesh = read_mesh(textured_obj(VERTICES, FACES, UV), "obj")
    assert mesh.colors is None
    assert len(mesh.warnings) == 1
    for word in ("skin.mtl", "did not come", ".zip"):
        assert word in mesh.warnings[0]


SIMPLE = textured_obj(VERTICES, FACES, UV)


def encrypted() -> bytes:
    data = bytearray(zipped({"skin.obj": SIMPLE}, zipfile.ZIP_STORED))
    data[data.index(b"PK\1\2") + 8] |= 1
    data[6] |= 1
    return bytes(data)


def lying(size: int) -> bytes:
    """An archive whose directory promises a file of that size."""
    data = bytearray(zipped({"skin.obj": SIMPLE}))
    start = data.index(b"PK\1\2")
    struct.pack_into("<I", data, start + 24, size)
    return bytes(data)


@pytest.mark.parametrize(
    ("data", "reason"),
    [
        (zipped({"a.txt": b"x"}), "no mesh file; one ending in .obj"),
        (zipped({}), "no mesh file"),
        (zipped({"a.obj": SIMPLE, "b/c.OBJ": SIMPLE}), r"2 mesh files \(a.obj, b/c.OBJ\)"),
        (zipped({"skin.obj": SIMPLE}), "material file 'skin.mtl', which is not in the archive"),
        (zipped({"skin.obj": SIMPLE, "skin.mtl": MTL}), "image 'skin.png', which is not in the"),
        (
            zipped({"skin.obj": SIMPLE, "skin.mtl": MTL, "skin.png": RAMP[:300]}),
            "image skin.png cannot be decoded",
        ),
        (
            zipped({"skin.obj": SIMPLE, "skin.mtl": b"newmtl skin\nKd red\n"}),
            "Kd in the material file cannot be read",
        ),
        (zipped({"../skin.obj": SIMPLE}), "leads out of it"),
        (zipped({"/skin.obj": SIMPLE}), "leads out of it"),
        (zipped({"a\\..\\..\\skin.obj": SIMPLE}), "leads out of it"),
        (zipped({f"{n}.txt": b"" for n in range(1001)}), "more than 1000 files"),
        (encrypted(), "encrypted"),
        (lying(10), "damaged"),
        (lying(2**31), "larger than 8 MiB when unpacked, which is far too much"),
        (b"PK\3\4", "not a ZIP archive"),
        (zipped({"skin.obj": SIMPLE})[:-30], "not a ZIP archive"),
    ],
    ids=range(16),
)
def test_archives_that_are_refused(data: bytes, reason: str) -> None:
    with pytest.raises(MeshError, match=reason):
        read_mesh(data, "zip")


def test_a_face_that_names_no_texture_coordinate() -> None:
    for bad in (b"f 1/900 2/1 3/1\n", b"f 1/0 2/1 3/1\n", b"f 1/x 2/1 3/1\n", b"vt 1 a\n"):
        files = {"skin.obj": SIMPLE + bad, "skin.mtl": MTL, "skin.png": RAMP}
        with pytest.raises(MeshError, match=r"texture coordinate|face line"):
            read_mesh(zipped(files), "zip")
    # Faces without any are of the material's colour.
    files = {"skin.obj": SIMPLE + b"f 1 2 3\n", "skin.mtl": MTL, "skin.png": RAMP}
    assert read_mesh(zipped(files), "zip").colors is not None


# --- anything at all ------------------------------------------------------------------------------

SMALL = grid(2)
FILES: dict[str, Callable[[FloatArray, IntArray, FloatArray, bytes], bytes]] = {
    "glb": textured_glb,
    "zip": zipped_obj,
}
PICTURE = image_file(ramp(8, 8))
DATA = {kind: write(*SMALL, SMALL[0][:, :2], PICTURE) for kind, write in FILES.items()}
TREE: Any = textured_tree(*SMALL, SMALL[0][:, :2], PICTURE)


def read_or_refuse(data: bytes, file_type: str) -> None:
    try:
        mesh = read_mesh(data, file_type)
    except MeshError:
        return
    assert mesh.colors is None or (
        np.isfinite(mesh.colors).all() and 0.0 <= mesh.colors.min() <= mesh.colors.max() <= 1.0
    )


@pytest.mark.parametrize("kind", FILES)
def test_files_cut_anywhere(kind: str) -> None:
    for end in range(0, len(DATA[kind]), 7):
        with pytest.raises(MeshError):
            read_mesh(DATA[kind][:end], kind)


@settings(max_examples=300, deadline=None)
@given(
    st.sampled_from(sorted(FILES)), st.floats(0.0, 1.0), st.integers(0, 8), st.binary(max_size=8)
)
@pytest.mark.filterwarnings("ignore")
def test_damaged_textured_files(kind: str, place: float, removed: int, inserted: bytes) -> None:
    data = DATA[kind]
    start = int(place * len(data))
    read_or_refuse(data[:start] + inserted + data[start + removed :], kind)


LEAVES = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(-3, 10),
    st.floats(),
    st.text(max_size=4),
    st.sampled_from([5121, 10497, "VEC2", "data:,", "data:;base64,", [], {}, [1, 2], {"index": 0}]),
)


def places_in(tree: Any, path: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    inside = tree.items() if isinstance(tree, dict) else enumerate(tree)
    found = []
    for key, value in inside:
        found.append((*path, key))
        if isinstance(value, dict | list):
            found += places_in(value, (*path, key))
    return found


PLACES = places_in(TREE[0])


@settings(max_examples=400, deadline=None)
@given(st.lists(st.tuples(st.sampled_from(PLACES), LEAVES), min_size=1, max_size=3))
@pytest.mark.filterwarnings("ignore")
def test_gltf_trees_with_anything_anywhere(changes: list[tuple[tuple[Any, ...], Any]]) -> None:
    tree = json.loads(json.dumps(TREE[0]))
    for path, value in changes:
        at = tree
        try:
            for key in path[:-1]:
                at = at[key]
            at[path[-1]] = value
        except (KeyError, IndexError, TypeError):
            continue
    read_or_refuse(mesh_files.glb_of(tree, TREE[1]), "glb")


@settings(max_examples=150, deadline=None)
@given(st.binary(max_size=60), st.text(max_size=60), st.sampled_from(["map_Kd ", "Kd ", "newmtl "]))
@pytest.mark.filterwarnings("ignore")
def test_any_material_file(raw: bytes, text: str, keyword: str) -> None:
    mtl = b"newmtl skin\n" + keyword.encode() + text.encode() + b"\n" + raw
    read_or_refuse(zipped({"skin.obj": SIMPLE[:400], "skin.mtl": mtl, "skin.png": PICTURE}), "zip")
