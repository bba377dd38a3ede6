"""Materials and their images, written to binary glTF 2.0."""

import io
from typing import Any, Final

import numpy as np
from PIL import Image

from solver.arrays import FloatArray, IntArray
from solver.mesh.textures import Material, Paint, Texture, Wrap, linear_light
from solver.transfer.files.glb_file import GlbFile

_WRAPS: Final = {Wrap.REPEAT: 10497, Wrap.CLAMP: 33071, Wrap.MIRROR: 33648}
_LINEAR, _MIPMAPS = 9729, 9987


def write_materials(file: GlbFile, paint: Paint, mipmaps: bool) -> list[tuple[IntArray, int]]:
    """Write the materials of faces, with their images.

    Parameters
    ----------
    file
        Where they are written.
    paint
        Of the faces.
    mipmaps
        Whether images may be shown smaller: texels near one another are of one part of the surface.

    Returns
    -------
    Faces, and the index of their material, one by one.
    """
    light = np.ones_like(paint.colors) if paint.light is None else paint.light
    bare = (paint.texture_of_face < 0)[:, None]
    factors: FloatArray = np.where(bare, linear_light(paint.colors), light)
    besides = paint.material_of_face
    if besides is None:
        besides = np.full(len(factors), -1, dtype=np.int64)
    table = np.column_stack([paint.texture_of_face, besides, factors])
    kinds, kind = np.unique(table, axis=0, return_inverse=True)
    order = np.argsort(kind.reshape(-1), kind="stable")
    chosen = np.split(order, np.cumsum(np.bincount(kind.reshape(-1)))[:-1])
    images: dict[float, int] = {}
    found = []
    for faces, (number, place, *factor) in zip(chosen, kinds.tolist(), strict=True):
        material = paint.materials[int(place)] if place >= 0 else Material()
        shown: dict[str, Any] = {
            "metallicFactor": material.metallic,
            "roughnessFactor": material.roughness,
            "baseColorFactor": [*factor, 1.0],
        }
        if 0 <= number < len(paint.textures):
            if number not in images:
                images[number] = _write_texture(file, paint.textures[int(number)], mipmaps)
            shown["baseColorTexture"] = {"index": images[number]}
        named = {"name": material.name} if material.name else {}
        found.append((faces, file.append("materials", named | {"pbrMetallicRoughness": shown})))
    return found


def png_of(texture: Texture) -> bytes:
    """Return the image of a texture as PNG."""
    stream = io.BytesIO()
    Image.fromarray(texture.pixels).save(stream, format="PNG")
    return stream.getvalue()


def _write_texture(file: GlbFile, texture: Texture, mipmaps: bool) -> int:
    """Write a texture with its image, and return its index."""
    view = file.view(png_of(texture))
    image = file.append("images", {"bufferView": view, "mimeType": "image/png"})
    across, down = (_WRAPS[wrap] for wrap in texture.wrap)
    sampler = {
        "magFilter": _LINEAR,
        "minFilter": _MIPMAPS if mipmaps else _LINEAR,
        "wrapS": across,
        "wrapT": down,
    }
    return file.append("textures", {"source": image, "sampler": file.append("samplers", sampler)})
