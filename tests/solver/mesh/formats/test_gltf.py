"""glTF: scenes, seams and buffers, and what would be misread."""

import base64
import json
import struct
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from solver.errors import MeshError
from solver.mesh import read_mesh
from tests.solver import shapes
from tests.solver.mesh import mesh_files
from tests.solver.mesh.mesh_files import SQUARE, TWO


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


def skinned_square(
    nodes: list[dict[str, Any]], joint_of: list[int]
) -> tuple[dict[str, Any], bytes]:
    """The square, moved by joints 0 and 1 of a skin, nodes 1 and 2, that were bound at z = 5."""
    tree, buffer = mesh_files.gltf_tree(SQUARE, np.array(TWO))
    tree["nodes"] = nodes
    joints = np.zeros((4, 4), dtype=np.uint8)
    joints[:, 0] = joint_of
    weights = np.tile(np.array([1, 0, 0, 0], "<f4"), (4, 1))
    inverse = np.tile(np.eye(4, dtype="<f4"), (2, 1, 1))
    inverse[:, 3, 2] = -5.0
    for name, values in (("JOINTS_0", joints), ("WEIGHTS_0", weights)):
        tree["meshes"][0]["primitives"][0]["attributes"][name] = len(tree["accessors"])
        buffer = mesh_files.gltf_accessor(tree, buffer, values)
    tree["skins"] = [{"joints": [1, 2], "inverseBindMatrices": len(tree["accessors"])}]
    return tree, mesh_files.gltf_accessor(tree, buffer, inverse.reshape(-1, 16))


def test_gltf_meshes_with_a_skin_are_placed_by_its_joints() -> None:
    bound = {"translation": [0, 0, 5]}
    nodes: list[dict[str, Any]] = [
        {"mesh": 0, "skin": 0, "translation": [100, 0, 0]},
        bound,
        bound,
        {"children": [1, 2], "translation": [0, 7, 0], "scale": [-2, 2, 2]},
    ]
    tree, buffer = skinned_square(nodes, [0, 0, 1, 1])
    tree["scenes"] = [{"nodes": [0, 3]}]
    mesh = read_mesh(mesh_files.glb_of(tree, buffer), "glb")
    np.testing.assert_allclose(mesh.vertices, SQUARE * [-2, 2, 2] + [0, 7, 0], atol=1e-12)
    a, b, c = (mesh.vertices[mesh.faces[:, corner]] for corner in range(3))
    assert (np.cross(b - a, c - a)[:, 2] > 0.0).all()


def test_gltf_joints_that_were_moved_apart_bend_the_mesh() -> None:
    nodes: list[dict[str, Any]] = [{"mesh": 0, "skin": 0}]
    nodes += [{"translation": [0, 0, 5]}, {"translation": [0, 0, 8]}]
    tree, buffer = skinned_square(nodes, [0, 0, 1, 1])
    mesh = read_mesh(mesh_files.glb_of(tree, buffer), "glb")
    np.testing.assert_allclose(mesh.vertices, SQUARE + np.outer([0, 0, 1, 1], [0, 0, 3]))


def test_gltf_meshes_without_a_skin_ignore_their_joints() -> None:
    nodes: list[dict[str, Any]] = [{"mesh": 0, "translation": [50, 0, 0]}, {}, {}]
    mesh = read_mesh(mesh_files.glb_of(*skinned_square(nodes, [0, 0, 9, 9])), "glb")
    np.testing.assert_allclose(mesh.vertices, SQUARE + np.array([50, 0, 0]))


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        (lambda tree: tree["nodes"][0].update(skin=1), "skin 1, which does not exist"),
        (lambda tree: tree["skins"][0].update(joints=[1, 9]), "node 9, which does not exist"),
        (lambda tree: tree["skins"][0].update(joints=[]), "no joints"),
        (lambda tree: tree["skins"][0].update(joints=[1]), "joint 1 does not exist"),
        (lambda tree: tree["skins"][0].update(joints=[1, 2, 1]), "no matrix for every joint"),
        (lambda tree: tree["accessors"][2].update(count=3), "joints and weights for every vertex"),
    ],
)
def test_gltf_skins_that_are_damaged_are_refused(
    change: Callable[[dict[str, Any]], object], reason: str
) -> None:
    tree, buffer = skinned_square([{"mesh": 0, "skin": 0}, {}, {}], [0, 0, 1, 1])
    change(tree)
    with pytest.raises(MeshError, match=reason):
        read_mesh(mesh_files.glb_of(tree, buffer), "glb")


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
    with pytest.raises(MeshError, match=r"secret.bin., which is missing; save it as GLB"):
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
        ([{"mesh": 0, "children": [0]}], "cycle"),
        ([{"mesh": 0}, {"children": [2]}, {"mesh": 0, "children": [1]}], "cycle"),
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
    with pytest.raises(MeshError, match="without values"):
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


def test_a_promised_accessor_allocates_nothing() -> None:
    tree, buffer = mesh_files.gltf_tree(SQUARE, np.array(TWO))
    tree["accessors"].append({"componentType": 5126, "count": 10**12, "type": "MAT4"})
    with pytest.raises(MeshError, match="far more values"):
        read_mesh(mesh_files.glb_of(tree, buffer), "glb")


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        (
            lambda tree: tree["accessors"][0].update(type="VEC9"),
            "'VEC9' is missing in its JSON, or",
        ),
        (lambda tree: tree["accessors"][0].pop("type"), "'type' is missing in its JSON, or"),
        (lambda tree: tree.update(nodes=["body"]), "not of the kind that glTF has there"),
        (lambda tree: tree.update(meshes=7), "not of the kind that glTF has there"),
    ],
)
def test_what_is_wrong_with_the_json_is_told(
    change: Callable[[dict[str, Any]], object], reason: str
) -> None:
    tree, buffer = mesh_files.gltf_tree(SQUARE, np.array(TWO))
    change(tree)
    with pytest.raises(MeshError, match=f"damaged or cut off: .*{reason}"):
        read_mesh(mesh_files.glb_of(tree, buffer), "glb")


@pytest.mark.parametrize("version", [0, 1, 3])
def test_glb_of_another_version_is_refused(version: int) -> None:
    data = bytearray(mesh_files.glb(SQUARE, np.array(TWO)))
    data[4:8] = struct.pack("<I", version)
    with pytest.raises(MeshError, match=f"GLB of version {version} is not supported"):
        read_mesh(bytes(data), "glb")


def test_a_fallback_without_data_is_told_as_compression() -> None:
    """Extensions that are not required have buffers that programs without them would read."""
    tree, buffer = mesh_files.gltf_tree(SQUARE, np.array(TWO))
    meshopt = {"EXT_meshopt_compression": {"fallback": True}}
    tree["buffers"].append({"byteLength": 48, "extensions": meshopt})
    tree["bufferViews"][0] = {"buffer": 1, "byteLength": 48}
    with pytest.raises(MeshError, match="compressed glTF data is not supported"):
        read_mesh(mesh_files.glb_of(tree, buffer), "glb")
