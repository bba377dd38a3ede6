"""Textured mesh files made by hand, independent of the readers they test."""

import io
import zipfile
from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt
from PIL import Image

from solver.arrays import FloatArray, IntArray
from tests.solver.mesh import mesh_files

Pixels = npt.NDArray[np.uint8]


def image_file(pixels: Pixels, file_type: str = "PNG", **options: Any) -> bytes:
    """An image file of (height, width, 3) pixels."""
    stream = io.BytesIO()
    Image.fromarray(pixels).save(stream, format=file_type, **options)
    return stream.getvalue()


def ramp(width: int = 256, height: int = 256) -> Pixels:
    """Red grows with u, green with v downwards: the code is the number of the texel."""
    pixels = np.zeros((height, width, 3), dtype=np.uint8)
    pixels[..., 0] = np.arange(width)
    pixels[..., 1] = np.arange(height)[:, None]
    return pixels


def grid(count: int, jitter: float = 0.0) -> tuple[FloatArray, IntArray]:
    """The unit square, x and y in 0..1, of count² cells of two triangles, inner vertices moved."""
    x, y = np.meshgrid(np.linspace(0, 1, count + 1), np.linspace(0, 1, count + 1))
    vertices = np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], axis=1)
    inner = ((vertices[:, :2] > 0.0) & (vertices[:, :2] < 1.0)).all(axis=1)
    rng = np.random.default_rng(0)
    vertices[inner, :2] += jitter / count * rng.uniform(-1, 1, (int(inner.sum()), 2))
    a = (np.arange(count) + (count + 1) * np.arange(count)[:, None]).ravel()
    b, c, d = a + 1, a + count + 2, a + count + 1
    return vertices, np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])


def textured_tree(
    vertices: FloatArray,
    faces: IntArray,
    coordinates: FloatArray,
    image: bytes,
    material: Mapping[str, Any] | None = None,
    sampler: Mapping[str, int] | None = None,
) -> tuple[dict[str, Any], bytes]:
    """JSON of a glTF scene with a texture, and its buffer; v runs downwards.

    `coordinates` may be floats, or uint8 or uint16 for normalised ones.
    """
    tree, buffer = mesh_files.gltf_tree(vertices, faces)
    kinds = {"u1": 5121, "u2": 5123}
    kind = kinds.get(coordinates.dtype.str[1:], 5126)
    stored = coordinates if kind != 5126 else coordinates.astype("<f4")
    texels = stored.tobytes()
    texels += b"\0" * (-len(texels) % 4)
    start = len(buffer)
    tree["bufferViews"] += [
        {"buffer": 0, "byteOffset": start, "byteLength": len(texels)},
        {"buffer": 0, "byteOffset": start + len(texels), "byteLength": len(image)},
    ]
    tree["accessors"].append(
        {"bufferView": 2, "componentType": kind, "count": len(vertices), "type": "VEC2"}
        | ({"normalized": True} if kind != 5126 else {})
    )
    tree["images"] = [{"bufferView": 3, "mimeType": "image/png"}]
    tree["samplers"] = [dict(sampler or {})]
    tree["textures"] = [{"source": 0, "sampler": 0}]
    tree["materials"] = [
        {"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}, **(material or {})}}
    ]
    primitive = tree["meshes"][0]["primitives"][0]
    primitive["attributes"]["TEXCOORD_0"] = 2
    primitive["material"] = 0
    buffer += texels + image
    tree["buffers"][0]["byteLength"] = len(buffer)
    return tree, buffer


def textured_glb(*arguments: Any, **options: Any) -> bytes:
    """GLB of :func:`textured_tree`."""
    return mesh_files.glb_of(*textured_tree(*arguments, **options))


def textured_obj(vertices: FloatArray, faces: IntArray, coordinates: FloatArray) -> bytes:
    """OBJ with a texture coordinate a vertex, v upwards, and the material "skin" of skin.mtl."""
    lines = ["mtllib skin.mtl"]
    lines += ["v " + " ".join(map(repr, row)) for row in vertices.tolist()]
    lines += ["vt " + " ".join(map(repr, row)) for row in coordinates.tolist()]
    lines += ["usemtl skin"]
    lines += ["f " + " ".join(f"{corner + 1}/{corner + 1}" for corner in face) for face in faces]
    return ("\n".join(lines) + "\n").encode()


def zipped(files: Mapping[str, bytes], method: int = zipfile.ZIP_DEFLATED) -> bytes:
    """A ZIP archive."""
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", method) as archive:
        for name, data in files.items():
            archive.writestr(name, data)
    return stream.getvalue()


MTL = b"newmtl skin\nKa 0 0 0\nKd 0.8 0.8 0.8\nmap_Kd skin.png\n"


def zipped_obj(
    vertices: FloatArray, faces: IntArray, coordinates: FloatArray, image: bytes
) -> bytes:
    """The archive of :func:`textured_obj`, its material file and its image."""
    obj = textured_obj(vertices, faces, coordinates)
    return zipped({"skin.obj": obj, "skin.mtl": MTL, "skin.png": image})
