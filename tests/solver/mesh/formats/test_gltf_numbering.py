"""Numbers of the vertices of glTF files whose primitives have accessors in common."""

from typing import Any

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from solver.mesh import read_mesh
from solver.transfer.files import read_attributes
from tests.solver import shapes
from tests.solver.mesh import mesh_files
from tests.solver.mesh.mesh_files import SQUARE, TWO

BALL = shapes.icosphere(1)


def cut_scene(pieces: list[int], nodes: int = 1) -> tuple[dict[str, Any], bytes]:
    """The ball as a primitive for each piece, of so many triangles, over the same accessors.

    Its vertices have their own numbers as ``_number``.
    """
    tree, buffer = mesh_files.gltf_tree(BALL.vertices, BALL.faces)
    numbers = np.tile(np.arange(BALL.n_vertices, dtype="<f4")[:, None], (1, 3))
    buffer = mesh_files.gltf_accessor(tree, buffer, numbers)
    (whole,) = tree["meshes"][0]["primitives"]
    whole["attributes"]["_number"] = 2
    primitives = []
    for size, end in zip(pieces, np.cumsum(pieces).tolist(), strict=True):
        primitives.append(whole | {"indices": len(tree["accessors"])})
        tree["accessors"].append(
            tree["accessors"][1] | {"count": 3 * size, "byteOffset": 12 * (end - size)}
        )
    tree["meshes"][0]["primitives"] = primitives
    tree["nodes"] = [{"mesh": 0, "translation": [4.0 * place, 0, 0]} for place in range(nodes)]
    tree["scenes"] = [{"nodes": list(range(nodes))}]
    return tree, buffer


@given(st.lists(st.integers(1, 19), min_size=1, max_size=4))
def test_primitives_over_the_same_accessors_are_one_surface(sizes: list[int]) -> None:
    tree, buffer = cut_scene([*sizes, BALL.n_faces - sum(sizes)])
    data = mesh_files.glb_of(tree, buffer)
    found = read_mesh(data, "glb")
    np.testing.assert_allclose(found.vertices, BALL.vertices, atol=1e-6)
    np.testing.assert_array_equal(found.faces, BALL.faces)
    np.testing.assert_array_equal(found.vertex_ids, np.arange(BALL.n_vertices))
    assert found.file_rows == (BALL.n_vertices, BALL.n_faces)
    assert not found.warnings
    (number,) = read_attributes(data, "glb")
    np.testing.assert_array_equal(number.values[:, 0], np.arange(BALL.n_vertices))


def test_each_node_that_shows_them_has_vertices_of_its_own() -> None:
    data = mesh_files.glb_of(*cut_scene([10, BALL.n_faces - 10], nodes=3))
    found = read_mesh(data, "glb")
    assert found.file_rows == (3 * BALL.n_vertices, 3 * BALL.n_faces)
    (number,) = read_attributes(data, "glb")
    expected = np.tile(np.arange(BALL.n_vertices), 3)
    np.testing.assert_array_equal(number.values[:, 0], expected)
    # Vertex i is that of node i // V.
    for place, ids in enumerate(np.split(found.vertex_ids, 3)):
        rows = found.vertices[np.isin(found.vertex_ids, ids)]
        np.testing.assert_allclose(rows, BALL.vertices + np.array([4.0 * place, 0, 0]), atol=1e-6)


def test_primitives_with_another_accessor_have_vertices_of_their_own() -> None:
    """Those of points have none that count; vertices follow the order of primitives."""
    tree, buffer = mesh_files.gltf_tree(SQUARE, np.array(TWO))
    for values in (
        SQUARE + np.array([0, 0, 5]),
        np.array([[9.0, 9, 9]]),
        SQUARE + np.array([0, 0, 7]),
    ):
        buffer = mesh_files.gltf_accessor(tree, buffer, values.astype("<f4"))
    colors = np.tile(np.array([255, 0, 0, 255], np.uint8), (4, 1))
    buffer = mesh_files.gltf_accessor(tree, buffer, colors)
    (first,) = tree["meshes"][0]["primitives"]
    other, points, last = (first | {"attributes": {"POSITION": one}} for one in (2, 3, 4))
    painted = first | {"attributes": {"POSITION": 0, "_COLOR": 5}}
    tree["meshes"] = [
        {"primitives": [first, points | {"mode": 0}, other, first | {"indices": 1}, painted]},
        {"primitives": [last, last]},
        {"primitives": [first]},
    ]
    tree["nodes"] = [
        {"mesh": 2, "translation": [0, 0, 9]},  # meshes are in the order of the file
        {"mesh": 1},
        {"mesh": 0},
    ]
    tree["scenes"] = [{"nodes": [0, 1, 2]}]
    found = read_mesh(mesh_files.glb_of(tree, buffer), "glb")
    assert found.file_rows == (5 * 4, 7 * 2)
    level = dict(zip(found.vertex_ids.tolist(), found.vertices[:, 2].tolist(), strict=True))
    # Those of the painted one, 8 to 11, lie where the first are.
    assert level == {
        number: z
        for start, z in ((0, 0.0), (4, 5.0), (12, 7.0), (16, 9.0))
        for number in range(start, start + 4)
    }
