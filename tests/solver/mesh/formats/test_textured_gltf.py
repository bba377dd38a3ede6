"""Textured glTF: what is on the surface becomes colours of vertices, or is refused or told."""

import base64
import json
import tracemalloc
from typing import Any

import numpy as np
import pytest
import trimesh
from PIL import Image

from solver.errors import MeshError
from solver.mesh import read_mesh
from solver.mesh.textures import display_values
from tests.solver.mesh import mesh_files
from tests.solver.mesh.formats.painted_square import (
    FACES,
    INNER,
    RAMP,
    UV,
    VERTICES,
    colors_of,
    on_ramp,
)
from tests.solver.mesh.textures.textured_files import (
    image_file,
    ramp,
    textured_glb,
    textured_tree,
    zipped,
)


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
        assert not any("flipped" in warning for warning in mesh.warnings)


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
    assert any("is missing" in warning and ".zip" in warning for warning in bare.warnings)

    tree["buffers"][0]["uri"] = "shape.bin"
    files = {"a/shape.gltf": json.dumps(tree).encode(), "a/shape.bin": buffer}
    beside = read_mesh(zipped(files | {"a/textures/my skin.png": RAMP}), "zip")
    np.testing.assert_array_equal(colors_of(beside), colors_of(alone))
    with pytest.raises(MeshError, match=r"my%20skin.png', which is not in the archive"):
        read_mesh(zipped(files), "zip")
