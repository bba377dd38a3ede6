"""Mesh files made by hand, independent of the readers they test."""

import json
import struct
from collections.abc import Sequence
from typing import Any

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.mesh import TriangleMesh

SQUARE = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
"""Corners of the unit square."""

TWO = [[0, 1, 2], [0, 2, 3]]
"""The two triangles that it is cut into."""


def off(vertices: FloatArray, faces: Sequence[Sequence[int]]) -> bytes:
    """Text OFF."""
    lines = ["OFF", f"{len(vertices)} {len(faces)} 0"]
    lines += [" ".join(map(repr, row)) for row in vertices.tolist()]
    lines += [f"{len(face)} " + " ".join(map(str, face)) for face in faces]
    return ("\n".join(lines) + "\n").encode()


def obj(vertices: FloatArray, faces: Sequence[Sequence[int]]) -> bytes:
    """OBJ with positions only."""
    lines = ["v " + " ".join(map(repr, row)) for row in vertices.tolist()]
    lines += ["f " + " ".join(str(corner + 1) for corner in face) for face in faces]
    return ("\n".join(lines) + "\n").encode()


def ply(
    vertices: FloatArray, faces: Sequence[Sequence[int]], encoding: str = "binary_little_endian"
) -> bytes:
    """PLY with double coordinates, in any of its three encodings."""
    header = (
        f"ply\nformat {encoding} 1.0\ncomment made by hand\nelement vertex {len(vertices)}\n"
        "property double x\nproperty double y\nproperty double z\n"
        f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n"
    ).encode()
    if encoding == "ascii":
        return header + b"\n".join(off(vertices, faces).split(b"\n")[2:])
    order = "<" if encoding == "binary_little_endian" else ">"
    rows = [struct.pack(f"{order}B{len(face)}i", len(face), *face) for face in faces]
    return header + vertices.astype(order + "f8").tobytes() + b"".join(rows)


def stl(vertices: FloatArray, faces: IntArray, header: bytes = b"") -> bytes:
    """Binary STL."""
    records = [
        struct.pack("<12fH", 0, 0, 0, *vertices[face].ravel(), 0) for face in np.asarray(faces)
    ]
    return header.ljust(80, b"\0") + struct.pack("<I", len(records)) + b"".join(records)


def text_stl(vertices: FloatArray, faces: IntArray) -> bytes:
    """Text STL."""
    lines = ["solid shape"]
    for face in np.asarray(faces):
        corners = ["vertex " + " ".join(map(repr, row)) for row in vertices[face].tolist()]
        lines += ["facet normal 0 0 0", "outer loop", *corners, "endloop", "endfacet"]
    return ("\n".join([*lines, "endsolid shape"]) + "\n").encode()


def gltf_tree(vertices: FloatArray, faces: IntArray) -> tuple[dict[str, Any], bytes]:
    """JSON of a glTF scene with one mesh, and its buffer."""
    positions, indices = vertices.astype("<f4").tobytes(), np.asarray(faces, "<u4").tobytes()
    views = [
        {"buffer": 0, "byteOffset": 0, "byteLength": len(positions)},
        {"buffer": 0, "byteOffset": len(positions), "byteLength": len(indices)},
    ]
    accessors = [
        {"bufferView": 0, "componentType": 5126, "count": len(vertices), "type": "VEC3"},
        {"bufferView": 1, "componentType": 5125, "count": np.size(faces), "type": "SCALAR"},
    ]
    tree = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "buffers": [{"byteLength": len(positions) + len(indices)}],
        "bufferViews": views,
        "accessors": accessors,
    }
    return tree, positions + indices


def gltf_accessor(tree: dict[str, Any], buffer: bytes, values: np.ndarray) -> bytes:
    """Append an accessor to a tree, of (n, 3), (n, 4) or (n, 16) values; the longer buffer."""
    stored = values.tobytes()
    tree["bufferViews"].append({"buffer": 0, "byteOffset": len(buffer), "byteLength": len(stored)})
    kind = {"|u1": 5121, "<f4": 5126}[values.dtype.str]
    tree["accessors"].append(
        {
            "bufferView": len(tree["bufferViews"]) - 1,
            "componentType": kind,
            "count": len(values),
            "type": {3: "VEC3", 4: "VEC4", 16: "MAT4"}[values.shape[1]],
        }
    )
    buffer += stored + b"\0" * (-len(stored) % 4)
    tree["buffers"][0]["byteLength"] = len(buffer)
    return buffer


def glb_of(tree: dict[str, Any], buffer: bytes) -> bytes:
    """GLB of a tree and its buffer."""
    text = json.dumps(tree).encode()
    text += b" " * (-len(text) % 4)
    buffer += b"\0" * (-len(buffer) % 4)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text
    chunks += struct.pack("<I4s", len(buffer), b"BIN\0") + buffer
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


def glb(vertices: FloatArray, faces: IntArray) -> bytes:
    """GLB with one mesh."""
    return glb_of(*gltf_tree(vertices, faces))


def file_of(mesh: TriangleMesh) -> bytes:
    """PLY of a mesh."""
    return ply(mesh.vertices, mesh.faces.tolist())
