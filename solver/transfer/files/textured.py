"""Surfaces with texture coordinates: GLB, or OBJ in a zip, with the images, and OBJ without."""

import io
import re
import zipfile
from typing import Any, Final

import numpy as np
from PIL import Image

from solver.arrays import FloatArray, IntArray
from solver.mesh import TriangleMesh, vertex_normals
from solver.mesh.textures import Material, Paint, Texture, Wrap, linear_light
from solver.transfer.files.glb_file import INDICES, VERTEX_DATA, GlbFile, for_single_precision
from solver.transfer.files.obj_images import baked_for_obj
from solver.transfer.files.surface import WrittenSurface

_WRAPS: Final = {Wrap.REPEAT: 10497, Wrap.CLAMP: 33071, Wrap.MIRROR: 33648}
_LINEAR, _MIPMAPS = 9729, 9987


def write_textured_glb(name: str, mesh: TriangleMesh, paint: Paint, mipmaps: bool = False) -> bytes:
    """Return a surface with its textures as a binary glTF file.

    Vertices are repeated where triangles round them have other texture coordinates.

    Parameters
    ----------
    name
        Name of the surface.
    mesh
        The surface.
    paint
        Texture coordinates, textures and colours of its faces.
    mipmaps
        Whether images may be shown smaller: texels near one another are of one part of the surface.
    """
    file = GlbFile()
    corners = mesh.faces.ravel()
    table = np.column_stack([corners, paint.coordinates.reshape(-1, 2)])
    _, first, inverse = np.unique(table, axis=0, return_index=True, return_inverse=True)
    faces = inverse.reshape(-1, 3)
    vertices, placed = for_single_precision(mesh.vertices)
    position = vertices[corners[first]].astype("<f4")
    normals = vertex_normals(mesh.vertices, mesh.faces)[corners[first]]
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    upright = np.where(lengths > 0.0, normals / np.maximum(lengths, 1e-300), [0.0, 0.0, 1.0])
    bounds = {"min": position.min(axis=0).tolist(), "max": position.max(axis=0).tolist()}
    attributes = {
        "POSITION": file.accessor(position, VERTEX_DATA, **bounds),
        "NORMAL": file.accessor(upright.astype("<f4"), VERTEX_DATA),
        "TEXCOORD_0": file.accessor(table[first, 1:].astype("<f4"), VERTEX_DATA),
    }
    primitives = [
        {
            "attributes": attributes,
            "indices": file.accessor(faces[chosen].astype("<u4").ravel(), INDICES),
            "material": material,
        }
        for chosen, material in _materials(file, paint, mipmaps)
    ]
    mesh_index = file.append("meshes", {"name": name, "primitives": primitives})
    node = file.append("nodes", {"name": name, "mesh": mesh_index, **placed})
    file.tree["scenes"][0]["nodes"].append(node)
    return file.to_bytes()


def write_textured_obj(surface: WrittenSurface, paint: Paint, library: str = "") -> bytes:
    """Return a surface as OBJ with texture coordinates (``vt``), v upwards.

    Parameters
    ----------
    surface
        The surface, with the vertices of the user's file.
    paint
        Texture coordinates of its faces; those of each texture follow ``usemtl texture0``, and so
        on, if there are several or there is a library.
    library
        Name of the material file; empty if there is none.
    """
    text = [f"mtllib {library}"] if library else []
    text += [f"o {'_'.join(surface.name.split()) or 'surface'}"]
    text += [f"v {' '.join(map(repr, row))}" for row in surface.vertices.tolist()]
    textured = paint.texture_of_face >= 0
    upwards = paint.coordinates[textured].reshape(-1, 2) * [1.0, -1.0] + [0.0, 1.0]
    places, inverse = np.unique(upwards, axis=0, return_inverse=True)
    text += [f"vt {u!r} {v!r}" for u, v in places.tolist()]
    numbers = np.zeros_like(surface.faces)
    numbers[textured] = inverse.reshape(-1, 3) + 1
    for texture in np.unique(paint.texture_of_face).tolist():
        if library or len(paint.textures) > 1:
            text.append(f"usemtl texture{texture}" if texture >= 0 else "usemtl plain")
        own = paint.texture_of_face == texture
        for face, place in zip(
            (surface.faces[own] + 1).tolist(), numbers[own].tolist(), strict=True
        ):
            pairs = zip(face, place, strict=True)
            text.append("f " + " ".join(f"{v}/{vt}" if vt else f"{v}" for v, vt in pairs))
    return ("\n".join(text) + "\n").encode()


def write_obj_archive(surface: WrittenSurface, paint: Paint) -> bytes:
    """Return a surface as a zip of an OBJ file, its material file, and the images as PNG.

    The files are named after the surface.

    Parameters
    ----------
    surface, paint
        As for :func:`write_textured_obj`. Faces without a texture have their mean colour. Tints,
        and wraps that differ from axis to axis or are mirrored, become part of the images
        (:func:`.baked_for_obj`).

    Raises
    ------
    TransferError
        The images would be too large.
    """
    paint = baked_for_obj(paint)
    # Names of shapes are free text: nothing of a path, and no space, which ends a name in OBJ.
    stem = re.sub(r"[^\w-]+", "_", surface.name).strip("_") or "surface"
    stream = io.BytesIO()
    bare = paint.texture_of_face < 0
    plain = paint.colors[bare].mean(axis=0) if bare.any() else np.ones(3)
    materials = [f"newmtl plain\nKd {' '.join(f'{one:.6g}' for one in plain.tolist())}"]
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as archive:
        # A file with texture coordinates alone has a number without an image.
        for number in range(int(paint.texture_of_face.max(initial=-1)) + 1):
            materials.append(f"newmtl texture{number}\nKd 1 1 1")
            if number < len(paint.textures):
                texture, name = paint.textures[number], f"texture{number}.png"
                clamp = "-clamp on " if texture.wrap[0] is Wrap.CLAMP else ""
                materials[-1] += f"\nmap_Kd {clamp}{name}"
                archive.writestr(name, _png(texture))
        archive.writestr(f"{stem}.mtl", "\n\n".join(materials) + "\n")
        archive.writestr(f"{stem}.obj", write_textured_obj(surface, paint, f"{stem}.mtl"))
    return stream.getvalue()


def _png(texture: Texture) -> bytes:
    stream = io.BytesIO()
    Image.fromarray(texture.pixels).save(stream, format="PNG")
    return stream.getvalue()


def _materials(file: GlbFile, paint: Paint, mipmaps: bool) -> list[tuple[IntArray, int]]:
    """Faces, and the index of their material, one by one."""
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
    images: dict[int, int] = {}
    found = []
    for faces, (number, place, *factor) in zip(chosen, kinds.tolist(), strict=True):
        material = paint.materials[int(place)] if place >= 0 else Material()
        shown: dict[str, Any] = {
            "metallicFactor": material.metallic,
            "roughnessFactor": material.roughness,
            "baseColorFactor": [*factor, 1.0],
        }
        if 0 <= number < len(paint.textures):
            texture = paint.textures[int(number)]
            index = images.setdefault(int(number), len(images))
            if index == len(file.tree.get("textures", [])):
                _write_texture(file, texture, mipmaps)
            shown["baseColorTexture"] = {"index": index}
        named = {"name": material.name} if material.name else {}
        found.append((faces, file.append("materials", named | {"pbrMetallicRoughness": shown})))
    return found


def _write_texture(file: GlbFile, texture: Texture, mipmaps: bool) -> None:
    view = file.view(_png(texture))
    image = file.append("images", {"bufferView": view, "mimeType": "image/png"})
    across, down = (_WRAPS[wrap] for wrap in texture.wrap)
    sampler = {
        "magFilter": _LINEAR,
        "minFilter": _MIPMAPS if mipmaps else _LINEAR,
        "wrapS": across,
        "wrapT": down,
    }
    file.append("textures", {"source": image, "sampler": file.append("samplers", sampler)})
