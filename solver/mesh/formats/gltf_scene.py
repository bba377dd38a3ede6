"""The scene of a glTF file: checks before anything is read, and transformations of nodes."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from operator import itemgetter
from typing import Any

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.errors import MeshError
from solver.mesh.formats.gltf_data import FLOAT, ITEMS, entry

_MOST_SHARED = 16
"""Values read per byte of the file and its buffers; meshes and nodes may share data."""

_MOST_PARTS = 20_000
"""Primitives, once for each node that shows them; each takes time, however small it is."""

_DEEPEST = 256
"""Levels of nodes; skeletons of figures have some dozens."""

_COMPRESSED = ("KHR_draco", "EXT_meshopt", "KHR_mesh_quantization")


def _triangles(indices: IntArray) -> IntArray:
    if len(indices) % 3:
        raise MeshError(
            "the number of indices of a glTF mesh is not a multiple of three; it is damaged"
        )
    return indices.reshape(-1, 3)


def _strip(indices: IntArray) -> IntArray:
    faces = np.stack([indices[:-2], indices[1:-1], indices[2:]], axis=1)
    faces[1::2] = faces[1::2, [1, 0, 2]]  # every other triangle has reversed winding
    return faces


def _fan(indices: IntArray) -> IntArray:
    return np.stack(
        [np.repeat(indices[:1], max(len(indices) - 2, 0)), indices[1:-1], indices[2:]], axis=1
    )


MODES: Mapping[int, Callable[[IntArray], IntArray]] = {4: _triangles, 5: _strip, 6: _fan}
"""(n,) indices to (F, 3) triangles, by primitive mode; other modes are points and lines."""


def vertex_set(primitive: Any) -> frozenset[tuple[str, int]]:
    """Return what primitives of a mesh have in common that have the same vertices: all accessors.

    They are one surface, cut by material, and its vertices are numbered once.
    """
    return frozenset(primitive["attributes"].items())


@dataclass(frozen=True, eq=False)
class Placement:
    """One of the nodes that show a mesh.

    Parameters
    ----------
    matrix
        (4, 4) transformation of the node.
    skin
        Index of its skin, whose joints then place the mesh, not the node; ``None`` without.
    """

    matrix: FloatArray
    skin: int | None


@dataclass(frozen=True, eq=False)
class Scene:
    """The meshes that a glTF file shows, with their places.

    Parameters
    ----------
    meshes
        The meshes that are shown, in the order of the file, and the nodes that show them.
    transforms
        (4, 4) matrix of each node that is shown, by its index; of every node if there are skins.
    """

    meshes: list[tuple[int, list[Placement]]]
    transforms: Mapping[int, FloatArray]


def scene_of(tree: Any) -> Scene:
    """Return the scene that a file shows.

    Parameters
    ----------
    tree
        JSON that :func:`check_tree` accepted.
    """
    nodes = tree.get("nodes", [])
    scenes = tree.get("scenes", [])
    inner = {child for node in nodes for child in node.get("children", [])}
    outer = [index for index in range(len(nodes)) if index not in inner]
    roots = entry(scenes, tree.get("scene", 0), "scene").get("nodes", []) if scenes else outer
    shown = _transforms(nodes, roots)
    everywhere = _transforms(nodes, outer) | shown if tree.get("skins") else shown
    placed: dict[int, list[Placement]] = {}
    for index, matrix in shown.items():
        node = nodes[index]
        if "mesh" in node:
            placed.setdefault(node["mesh"], []).append(Placement(matrix, node.get("skin")))
    return Scene(sorted(placed.items(), key=itemgetter(0)), everywhere)


def _transforms(nodes: Any, roots: Sequence[int]) -> dict[int, FloatArray]:
    """Matrices of the nodes below some, these included, depth first."""
    found: dict[int, FloatArray] = {}
    waiting = [(root, np.eye(4)) for root in reversed(roots)]
    while waiting:
        index, above = waiting.pop()
        node = entry(nodes, index, "node")
        if index in found:
            continue
        found[index] = above @ _matrix(node)
        waiting += [(child, found[index]) for child in reversed(node.get("children", []))]
    return found


def _matrix(node: Any) -> FloatArray:
    if "matrix" in node:
        matrix = np.array(node["matrix"], dtype=np.float64).reshape(4, 4).T
    else:
        x, y, z, w = np.array(node.get("rotation", (0.0, 0.0, 0.0, 1.0)), dtype=np.float64)
        scale = np.array(node.get("scale", (1.0, 1.0, 1.0)), dtype=np.float64).reshape(3)
        square = x * x + y * y + z * z + w * w
        s = 2.0 / square if square > 0.0 else 0.0
        rotation = np.array(
            [
                [1 - s * (y * y + z * z), s * (x * y - z * w), s * (x * z + y * w)],
                [s * (x * y + z * w), 1 - s * (x * x + z * z), s * (y * z - x * w)],
                [s * (x * z - y * w), s * (y * z + x * w), 1 - s * (x * x + y * y)],
            ]
        )
        matrix = np.eye(4)
        matrix[:3, :3] = rotation * scale
        matrix[:3, 3] = np.array(node.get("translation", (0.0, 0.0, 0.0)), dtype=np.float64)
    if not np.isfinite(matrix).all():
        raise MeshError(
            "a node of the glTF scene has a transformation that is not finite; it is damaged"
        )
    return matrix


def check_tree(tree: Any, size: int) -> None:
    """Refuse features that are not supported, and files that would take too much memory or time.

    Parameters
    ----------
    tree
        JSON of the file.
    size
        Bytes of the file and its buffers.

    Raises
    ------
    MeshError
        With the reason; a tree that is not valid glTF may raise any other exception.
    """
    if not isinstance(tree, dict):
        raise MeshError("not a glTF file: its JSON is not an object")
    required = tree.get("extensionsRequired", [])
    unsupported = [name for name in required if name.startswith(_COMPRESSED)]
    if unsupported:
        raise MeshError(f"glTF compressed with {', '.join(unsupported)}: save it uncompressed")
    accessors = tree.get("accessors", [])
    if any(type(accessor["count"]) is not int or accessor["count"] < 1 for accessor in accessors):
        raise MeshError("the glTF file has an accessor without values; it is damaged")
    values = sum(accessor["count"] * ITEMS[accessor["type"]] for accessor in accessors)
    if values > _MOST_SHARED * size:
        raise MeshError("the glTF file promises far more values than it has bytes; it is damaged")
    drawn = [
        sum(_check_primitive(primitive, accessors) for primitive in mesh["primitives"])
        for mesh in tree.get("meshes", [])
    ]
    nodes = tree.get("nodes", [])
    _check_nodes(nodes)
    shown = [node["mesh"] for node in nodes if "mesh" in node]
    placed = sum(entry(drawn, mesh, "mesh") for mesh in shown)
    if placed > _MOST_SHARED * size:
        raise MeshError(
            "the glTF scene shows the same mesh far too often; save only the shape to be matched"
        )
    parts = sum(len(tree["meshes"][mesh]["primitives"]) for mesh in shown)
    if parts > _MOST_PARTS:
        raise MeshError(
            f"the glTF scene has {parts} parts, more than {_MOST_PARTS}; join them, or save only "
            "the shape to be matched"
        )


def _check_nodes(nodes: Any) -> None:
    """Refuse nodes that do not form trees, or trees of more than `_DEEPEST` levels."""
    children = [child for node in nodes for child in node.get("children", [])]
    for child in children:
        entry(nodes, child, "node")
    if len(set(children)) < len(children):
        raise MeshError("a node of the glTF scene has two parents; the file is damaged")
    level = set(range(len(nodes))) - set(children)
    reached = len(level)
    for _ in range(_DEEPEST):
        level = {child for node in level for child in nodes[node].get("children", [])}
        reached += len(level)
    if level or reached < len(nodes):
        raise MeshError(
            f"the nodes of the glTF scene form a cycle or more than {_DEEPEST} levels; save the "
            "meshes without a hierarchy"
        )


def _check_primitive(primitive: Any, accessors: Any) -> int:
    """Return the number of values that are read for a primitive, 0 for points and lines."""
    if primitive.get("mode", 4) not in MODES:
        return 0
    position = entry(accessors, primitive["attributes"]["POSITION"], "accessor")
    used = [position]
    if "indices" in primitive:
        used.append(entry(accessors, primitive["indices"], "accessor"))
    if any("bufferView" not in accessor or "sparse" in accessor for accessor in used):
        raise MeshError("sparse or compressed glTF data is not supported; save it uncompressed")
    if position["componentType"] != FLOAT or position["type"] != "VEC3":
        raise MeshError("quantised glTF positions are not supported; save them as floats")
    others = [
        entry(accessors, index, "accessor")
        for name, index in primitive["attributes"].items()
        if name.startswith(("COLOR_", "TEXCOORD_", "JOINTS_", "WEIGHTS_"))
    ]
    return sum(accessor["count"] * ITEMS[accessor["type"]] for accessor in (*used, *others))
