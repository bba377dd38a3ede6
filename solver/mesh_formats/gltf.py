"""glTF 2.0, as one binary file (GLB) or as JSON with its buffers inside.

The scene's meshes are joined into one, each placed by its node. A vertex of glTF carries its
normal and texture coordinates, so files repeat vertices along every seam and crease; vertices of
equal position are merged again, or the surface would fall apart along its texture's seams.
"""

import io
import json
import struct
from collections.abc import Iterator
from typing import Any

import numpy as np

from solver.arrays import FloatArray
from solver.errors import MeshError
from solver.mesh_formats.contents import (
    check_indices,
    colors_in_unit_range,
    merge_coincident,
)
from solver.repair.soup import TriangleSoup

_SEAMS = "glTF repeats vertices along texture seams and creases"
_TRIANGLES, _TRIANGLE_STRIP = 4, 5
_FLOAT = 5126
_MOST_SHARED = 16
"""Values per byte of the file: several meshes may share the same data, but within reason."""
_DEEPEST = 256
"""Levels of nodes; the bones of a figure are some dozens deep."""
_ITEMS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}


def read_glb(data: bytes) -> TriangleSoup:
    """Read a binary glTF file.

    Parameters
    ----------
    data
        Bytes of the file.

    Returns
    -------
    TriangleSoup
        `vertex_ids` number the positions of all meshes in the order in which the scene uses them.

    Raises
    ------
    MeshError
        The bytes are not a complete GLB file, or use what is not supported.
    """
    if len(data) < 20 or data[:4] != b"glTF":
        raise MeshError("not a GLB file: it does not begin with glTF")
    length, json_length = struct.unpack_from("<8xII", data)
    if max(length, 20 + json_length) > len(data):
        promised = max(length, 20 + json_length)
        raise MeshError(
            f"the GLB file promises {promised} bytes and has {len(data)}; it is cut off"
        )
    if length < 20 + json_length:
        raise MeshError("the GLB file is longer than it says; it is damaged")
    return _read(data, "glb", data[20 : 20 + json_length])


def read_gltf(data: bytes) -> TriangleSoup:
    """Read a glTF file in JSON with its buffers embedded as data URIs.

    Parameters
    ----------
    data
        Bytes of the file.

    Returns
    -------
    TriangleSoup
        As :func:`read_glb`.

    Raises
    ------
    MeshError
        The bytes are not glTF, or use what is not supported, such as buffers in other files.
    """
    return _read(data, "gltf", data)


def _read(data: bytes, file_type: str, tree: bytes) -> TriangleSoup:
    try:
        _check_tree(json.loads(tree.decode("utf-8")), len(data))
        parts = list(_parts(data, file_type))
    except MeshError:
        raise
    except Exception as error:  # trimesh lets any exception through for a malformed file
        reason = f"{type(error).__name__}: {error}".rstrip(": ")[:200]
        raise MeshError(
            f"the {file_type.upper()} file cannot be read; it is damaged or cut off ({reason})"
        ) from error
    if not parts:
        raise MeshError("the glTF scene shows no triangles")
    offsets = np.cumsum([0] + [len(part.vertices) for part in parts])
    with_colors = all(part.colors is not None for part in parts)
    notes = (f"{len(parts)} meshes of the scene were joined",) if len(parts) > 1 else ()
    joined = TriangleSoup(
        np.concatenate([part.vertices for part in parts]),
        np.concatenate([part.faces + start for part, start in zip(parts, offsets, strict=False)]),
        np.concatenate([part.colors for part in parts if part.colors is not None])
        if with_colors
        else None,
        np.arange(offsets[-1], dtype=np.int64),
        notes,
    )
    return merge_coincident(joined, _SEAMS)


def _parts(data: bytes, file_type: str) -> Iterator[TriangleSoup]:
    # Imported here: it is slow to import, and no other format needs it.
    import trimesh

    scene = trimesh.load_scene(
        io.BytesIO(data), file_type=file_type, process=False, skip_materials=True
    )
    place = {name: number for number, name in enumerate(scene.geometry)}
    for node in sorted(scene.graph.nodes_geometry, key=lambda node: place[scene.graph[node][1]]):
        matrix, name = scene.graph[node]
        geometry = scene.geometry[name]
        if not isinstance(geometry, trimesh.Trimesh):
            continue
        corners = np.asarray(geometry.faces, dtype=np.int64)
        local = np.asarray(geometry.vertices, dtype=np.float64)
        check_indices(corners.reshape(-1), len(local))
        if np.linalg.det(matrix[:3, :3]) < 0.0:  # a mirror turns faces inside out
            corners = corners[:, ::-1]
        yield TriangleSoup(
            local @ matrix[:3, :3].T + matrix[:3, 3],
            corners,
            _colors(geometry.visual),
            np.arange(len(local), dtype=np.int64),
        )


def _colors(visual: object) -> FloatArray | None:
    if getattr(visual, "kind", None) != "vertex":
        return None
    return colors_in_unit_range(
        np.asarray(getattr(visual, "vertex_colors", ()), dtype=np.float64)[:, :3] / 255.0
    )


def _check_tree(tree: Any, size: int) -> None:
    """Refuse what trimesh would read as something else, or allocate memory for unseen."""
    if not isinstance(tree, dict):
        raise MeshError("not a glTF file: its JSON is not an object")
    required = tree.get("extensionsRequired", [])
    unsupported = [
        name
        for name in required
        if name.startswith(("KHR_draco", "EXT_meshopt", "KHR_mesh_quantization"))
    ]
    if unsupported:
        raise MeshError(f"glTF compressed with {', '.join(unsupported)}: save it uncompressed")
    for buffer in tree.get("buffers", []):
        if not buffer.get("uri", "data:").startswith("data:"):
            raise MeshError("the glTF file keeps its data in other files; save it as GLB")
    accessors = tree.get("accessors", [])
    if any(type(accessor["count"]) is not int or accessor["count"] < 1 for accessor in accessors):
        raise MeshError("the glTF file has an accessor of no values; it is damaged")
    values = sum(accessor["count"] * _ITEMS[accessor["type"]] for accessor in accessors)
    if values > _MOST_SHARED * size:
        raise MeshError("the glTF file promises far more values than it has bytes; it is damaged")
    drawn = [
        sum(_check_primitive(primitive, accessors) for primitive in mesh["primitives"])
        for mesh in tree.get("meshes", [])
    ]
    nodes = tree.get("nodes", [])
    _check_nodes(nodes)
    placed = sum(_entry(drawn, node["mesh"], "mesh") for node in nodes if "mesh" in node)
    if placed > _MOST_SHARED * size:
        raise MeshError(
            "the glTF scene shows the same mesh far too often; save only what is to be matched"
        )


def _check_nodes(nodes: Any) -> None:
    """Refuse nodes that are not trees, or so deep that finding their places takes minutes."""
    children = [child for node in nodes for child in node.get("children", [])]
    for child in children:
        _entry(nodes, child, "node")
    if len(set(children)) < len(children):
        raise MeshError("a node of the glTF scene has two parents; the file is damaged")
    level = set(range(len(nodes))) - set(children)
    reached = len(level)
    for _ in range(_DEEPEST):
        level = {child for node in level for child in nodes[node].get("children", [])}
        reached += len(level)
    if level or reached < len(nodes):
        raise MeshError(
            f"the nodes of the glTF scene form a ring, or more than {_DEEPEST} levels; save it flat"
        )


def _entry(entries: Any, index: Any, what: str) -> Any:
    if type(index) is not int or not 0 <= index < len(entries):
        raise MeshError(
            f"the glTF file refers to {what} {str(index)[:20]}, which is not there; it is damaged"
        )
    return entries[index]


def _check_primitive(primitive: Any, accessors: Any) -> int:
    """Return the number of values that are read for it."""
    if primitive.get("mode", _TRIANGLES) not in (_TRIANGLES, _TRIANGLE_STRIP):
        return 0
    position = _entry(accessors, primitive["attributes"]["POSITION"], "accessor")
    used = [position]
    if "indices" in primitive:
        used.append(_entry(accessors, primitive["indices"], "accessor"))
    if any("bufferView" not in accessor or "sparse" in accessor for accessor in used):
        raise MeshError("sparse or compressed glTF data is not supported; save it uncompressed")
    if position["componentType"] != _FLOAT or position["type"] != "VEC3":
        raise MeshError("quantised glTF positions are not supported; save them as floats")
    return sum(accessor["count"] * _ITEMS[accessor["type"]] for accessor in used)
