"""Surfaces written as binary glTF 2.0, with attributes of their vertices."""

import io
import json
import struct
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np
import numpy.typing as npt
from PIL import Image

from solver.errors import TransferError
from solver.mesh import TriangleMesh, vertex_normals
from solver.transfer.attributes import COLORS_NAME, WEIGHTS_NAME, Attribute
from solver.transfer.files.columns import color_bytes
from solver.transfer.files.glb import numbered_joints
from solver.transfer.files.surface import WrittenSurface
from solver.transfer.overlap import FACES
from solver.transfer.skinning import normalised_weights, strongest_weights
from solver.transfer.texture import BakedTexture

_KINDS: Final = {"u1": 5121, "<u2": 5123, "<u4": 5125, "<f4": 5126}
"""Component types, by NumPy's code."""

_ITEMS: Final = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4", 16: "MAT4"}
_VERTICES, _INDICES = 34962, 34963
_INFLUENCES: Final = 4
"""Joints of a vertex in a set of glTF, and greatest number of columns of an attribute."""


@dataclass
class _File:
    """A glTF file as it is written: its JSON, and the binary chunk.

    It has no materials: some programs show the colours of vertices only where there is none.
    """

    tree: dict[str, Any] = field(
        default_factory=lambda: {
            "asset": {"version": "2.0", "generator": "isomatch"},
            "scene": 0,
            "scenes": [{"nodes": []}],
            "nodes": [],
            "meshes": [],
            "accessors": [],
            "bufferViews": [],
            "buffers": [],
        }
    )
    binary: bytearray = field(default_factory=bytearray)

    def append(self, kind: str, entry: dict[str, Any]) -> int:
        """Append an entry, and return its index."""
        entries: list[dict[str, Any]] = self.tree.setdefault(kind, [])
        entries.append(entry)
        return len(entries) - 1

    def view(self, data: bytes, target: int | None = None) -> int:
        """Append bytes to the binary chunk, and return the index of their view."""
        view = {"buffer": 0, "byteOffset": len(self.binary), "byteLength": len(data)}
        if target is not None:
            view["target"] = target
        self.binary += data
        self.binary += bytes(-len(self.binary) % 4)
        return self.append("bufferViews", view)

    def accessor(self, values: npt.NDArray[Any], target: int | None = None, **more: Any) -> int:
        """Append values, (n,) or (n, k) of a type of glTF, and return the accessor's index."""
        table = values.reshape(len(values), -1)
        entry = {
            "bufferView": self.view(table.tobytes(), target),
            "componentType": _KINDS[table.dtype.str.lstrip("|")],
            "count": len(table),
            "type": _ITEMS[table.shape[1]],
        }
        return self.append("accessors", entry | more)

    def to_bytes(self) -> bytes:
        """Return the file."""
        self.tree["buffers"] = [{"byteLength": len(self.binary)}]
        text = json.dumps(self.tree, separators=(",", ":")).encode()
        text += b" " * (-len(text) % 4)
        length = 12 + 8 + len(text) + 8 + len(self.binary)
        head = struct.pack("<4sIIII", b"glTF", 2, length, len(text), 0x4E4F534A)
        return head + text + struct.pack("<II", len(self.binary), 0x004E4942) + self.binary


def write_glb(surfaces: Sequence[WrittenSurface]) -> bytes:
    """Return surfaces as a binary glTF file, a node each.

    Colours are COLOR_0, as bytes. Skinning weights are JOINTS_0 and WEIGHTS_0, the four greatest of
    each vertex, and a skin whose joints lie in the middle of what they move. All others are
    ``_NAME``, in single precision; those of text are numbers, and `extras` of the primitive has
    the texts. Vertices without a value have zeros. With attributes of faces, which glTF has not,
    each triangle has vertices of its own.

    Raises
    ------
    TransferError
        An attribute has more than four columns.
    """
    file = _File()
    for surface in surfaces:
        if any(one.on == FACES for one in surface.attributes):
            surface = surface.with_corners_apart()
        position = surface.vertices.astype("<f4")
        bounds = {"min": position.min(axis=0).tolist(), "max": position.max(axis=0).tolist()}
        primitive: dict[str, Any] = {
            "attributes": {"POSITION": file.accessor(position, _VERTICES, **bounds)},
            "indices": file.accessor(surface.faces.astype("<u4").ravel(), _INDICES),
        }
        node: dict[str, Any] = {"name": surface.name}
        for one in surface.attributes:
            if one.name == WEIGHTS_NAME and one.width:
                node["skin"] = _write_skin(file, primitive, one, surface)
            else:
                _write_attribute(file, primitive, one)
        node["mesh"] = file.append("meshes", {"name": surface.name, "primitives": [primitive]})
        file.tree["scenes"][0]["nodes"].append(file.append("nodes", node))
    return file.to_bytes()


def write_textured_glb(name: str, mesh: TriangleMesh, texture: BakedTexture) -> bytes:
    """Return a surface with a texture as a binary glTF file; its triangles share no vertices.

    Parameters
    ----------
    name
        Name of the surface.
    mesh
        The surface.
    texture
        Its texture.
    """
    file = _File()
    position = mesh.vertices[mesh.faces].reshape(-1, 3).astype("<f4")
    normals = vertex_normals(mesh.vertices, mesh.faces)[mesh.faces].reshape(-1, 3)
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    upright = np.where(lengths > 0.0, normals / np.maximum(lengths, 1e-300), [0.0, 0.0, 1.0])
    bounds = {"min": position.min(axis=0).tolist(), "max": position.max(axis=0).tolist()}
    attributes = {
        "POSITION": file.accessor(position, _VERTICES, **bounds),
        "NORMAL": file.accessor(upright.astype("<f4"), _VERTICES),
        "TEXCOORD_0": file.accessor(texture.coordinates.reshape(-1, 2).astype("<f4"), _VERTICES),
    }
    stream = io.BytesIO()
    Image.fromarray(texture.pixels).save(stream, format="PNG")
    image = file.append(
        "images", {"bufferView": file.view(stream.getvalue()), "mimeType": "image/png"}
    )
    # No mipmaps, which would mix neighbouring triangles.
    sampler = {"magFilter": 9729, "minFilter": 9729, "wrapS": 33071, "wrapT": 33071}
    shown = {"source": image, "sampler": file.append("samplers", sampler)}
    surface = {"baseColorTexture": {"index": file.append("textures", shown)}, "metallicFactor": 0.0}
    material = file.append("materials", {"pbrMetallicRoughness": surface})
    primitive = {"attributes": attributes, "material": material}
    mesh_index = file.append("meshes", {"name": name, "primitives": [primitive]})
    node = file.append("nodes", {"name": name, "mesh": mesh_index})
    file.tree["scenes"][0]["nodes"].append(node)
    return file.to_bytes()


def _write_attribute(file: _File, primitive: dict[str, Any], attribute: Attribute) -> None:
    values, attributes = attribute.values, primitive["attributes"]
    if attribute.name == COLORS_NAME and attribute.width in (3, 4):
        octets = np.full((len(values), 4), 255, dtype=np.uint8)
        octets[:, : attribute.width] = color_bytes(values)
        attributes["COLOR_0"] = file.accessor(octets, _VERTICES, normalized=True)
        return
    if attribute.width > _INFLUENCES:
        raise TransferError(
            f"GLB cannot hold {attribute.name[:40]!r} of {attribute.width} columns; choose PLY,"
            " CSV or NPZ"
        )
    if attribute.is_text:
        texts, values = np.unique(values, return_inverse=True)
        labels = primitive.setdefault("extras", {}).setdefault("labels", {})
        labels[attribute.name] = texts.tolist()
    numbers = np.nan_to_num(values.astype("<f4"), nan=0.0)
    attributes[f"_{attribute.name}"] = file.accessor(numbers, _VERTICES)


def _write_skin(
    file: _File, primitive: dict[str, Any], attribute: Attribute, surface: WrittenSurface
) -> int:
    weights = np.nan_to_num(attribute.values, nan=0.0)
    few = normalised_weights(strongest_weights(weights, _INFLUENCES))
    joints = np.argsort(-few, axis=1, kind="stable")[:, :_INFLUENCES]
    shares = np.take_along_axis(few, joints, axis=1)
    # A joint without a weight at a vertex is written as 0.
    joints = np.where(shares > 0.0, joints, 0)
    padding = ((0, 0), (0, _INFLUENCES - joints.shape[1]))
    kind = "u1" if weights.shape[1] <= 256 else "<u2"
    primitive["attributes"]["JOINTS_0"] = file.accessor(
        np.pad(joints, padding).astype(kind), _VERTICES
    )
    primitive["attributes"]["WEIGHTS_0"] = file.accessor(
        np.pad(shares, padding).astype("<f4"), _VERTICES
    )
    totals = weights.sum(axis=0)
    middles = weights.T @ surface.vertices / np.where(totals > 0.0, totals, 1.0)[:, None]
    middles[totals <= 0.0] = surface.vertices.mean(axis=0)
    names = attribute.columns or numbered_joints(attribute.width)
    nodes = [
        file.append("nodes", {"name": name, "translation": middle})
        for name, middle in zip(names, middles.tolist(), strict=True)
    ]
    root = file.append("nodes", {"name": "joints", "children": nodes})
    file.tree["scenes"][0]["nodes"].append(root)
    inverse = np.tile(np.eye(4, dtype="<f4"), (len(nodes), 1, 1))
    inverse[:, 3, :3] = -middles  # column by column, so this is the last column
    matrices = file.accessor(inverse.reshape(-1, 16))
    return file.append(
        "skins", {"joints": nodes, "inverseBindMatrices": matrices, "skeleton": root}
    )
