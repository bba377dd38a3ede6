"""Surfaces with texture coordinates: GLB, or OBJ in a zip, with the images, and OBJ without."""

import io
import re
import zipfile

import numpy as np

from solver.mesh import TriangleMesh
from solver.mesh.textures import Paint
from solver.transfer.files.glb_materials import png_of
from solver.transfer.files.glb_writing import write_glb
from solver.transfer.files.obj_images import baked_for_obj
from solver.transfer.files.obj_materials import material_groups
from solver.transfer.files.surface import WrittenSurface


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
    surface = WrittenSurface(name, mesh.vertices, mesh.faces, (), paint)
    return write_glb([surface], mipmaps)


def write_textured_obj(surface: WrittenSurface, paint: Paint, library: str = "") -> bytes:
    """Return a surface as OBJ with texture coordinates (``vt``), v upwards.

    Parameters
    ----------
    surface
        The surface, with the vertices of the user's file.
    paint
        Texture coordinates of its faces; those of each texture and material follow ``usemtl`` with
        the name of the material, or ``texture0`` and so on, if there are several or a library.
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
    groups = material_groups(paint)
    for group in groups:
        if library or len(groups) > 1:
            text.append(f"usemtl {group.name}")
        own = group.faces
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
    materials: list[str] = []
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as archive:
        for number, texture in enumerate(paint.textures):
            archive.writestr(f"texture{number}.png", png_of(texture))
        for group in material_groups(paint):
            # A file with texture coordinates alone has a number without an image.
            shown = 0 <= group.texture < len(paint.textures)
            materials.append(
                group.definition(paint, f"texture{group.texture}.png" if shown else "")
            )
        archive.writestr(f"{stem}.mtl", "\n\n".join(materials) + "\n")
        archive.writestr(f"{stem}.obj", write_textured_obj(surface, paint, f"{stem}.mtl"))
    return stream.getvalue()
