"""Materials as OBJ names them: groups of faces of one texture and one material."""

import re
from dataclasses import dataclass

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.mesh.textures import Material, Paint, Wrap
from solver.transfer.files.names import distinct


@dataclass(frozen=True, eq=False)
class ObjMaterialGroup:
    """The faces of one material.

    Parameters
    ----------
    name
        That of the material, without what ends a name in OBJ; "texture0", ... or "plain" without.
    faces
        (n,) their numbers.
    texture
        Number of their texture, -1 for none.
    material
        What they have besides.
    """

    name: str
    faces: IntArray
    texture: int
    material: Material

    def definition(self, paint: Paint, image: str) -> str:
        """Return the lines of a material file.

        Parameters
        ----------
        paint
            Of all faces; those without a texture have their mean colour.
        image
            File of the texture; empty if there is none.
        """
        color: FloatArray = np.ones(3)
        if self.texture < 0:
            color = paint.colors[self.faces].mean(axis=0)
        lines = [f"newmtl {self.name}", f"Kd {' '.join(f'{one:.6g}' for one in color.tolist())}"]
        if (self.material.metallic, self.material.roughness) != (0.0, 1.0):
            lines += [f"Pr {self.material.roughness:.6g}", f"Pm {self.material.metallic:.6g}"]
        if image:
            clamped = paint.textures[self.texture].wrap[0] is Wrap.CLAMP
            lines.append(f"map_Kd {'-clamp on ' if clamped else ''}{image}")
        return "\n".join(lines)


def material_groups(paint: Paint) -> list[ObjMaterialGroup]:
    """Return the faces by texture and material."""
    besides = paint.material_of_face
    if besides is None:
        besides = np.full_like(paint.texture_of_face, -1)
    table = np.column_stack([paint.texture_of_face, besides])
    kinds, kind = np.unique(table, axis=0, return_inverse=True)
    order = np.argsort(kind.reshape(-1), kind="stable")
    chosen = np.split(order, np.cumsum(np.bincount(kind.reshape(-1)))[:-1])
    materials = [
        paint.materials[place] if place >= 0 else Material() for _, place in kinds.tolist()
    ]
    textures = [texture for texture, _ in kinds.tolist()]
    # Names are free text.
    named = [re.sub(r"[^\w.-]+", "_", one.name) for one in materials]
    names = distinct(
        name or (f"texture{texture}" if texture >= 0 else "plain")
        for name, texture in zip(named, textures, strict=True)
    )
    groups = zip(names, chosen, textures, materials, strict=True)
    return [ObjMaterialGroup(*group) for group in groups]
