"""Base colours, textures, metalness and roughness of glTF's materials."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from solver.arrays import FloatArray
from solver.errors import MeshError
from solver.mesh.formats.gltf_data import GltfData
from solver.mesh.textures import ImageBudget, Material, Texture, Wrap, display_values

_WRAPS = {33071: Wrap.CLAMP, 33648: Wrap.MIRROR, 10497: Wrap.REPEAT}
_TRANSFORM = "KHR_texture_transform"
_SPECULAR = "KHR_materials_pbrSpecularGlossiness"


@dataclass(frozen=True, eq=False)
class GltfMaterial:
    """The base colour of a material, and what it has besides.

    Parameters
    ----------
    light
        (3,) base colour factor, of linear light.
    besides
        Its name, metalness and roughness.
    texture
        The texture that it multiplies; ``None`` for none.
    coordinates
        n of TEXCOORD_n, the texture coordinates to be used.
    matrix
        (2, 3) affine transformation of these.
    """

    light: FloatArray
    besides: Material = field(default_factory=Material)
    texture: Texture | None = None
    coordinates: int = 0
    matrix: FloatArray = field(default_factory=lambda: np.eye(2, 3))

    @property
    def color(self) -> FloatArray:
        """(3,) display values where there is no texture."""
        return display_values(self.light)


@dataclass
class GltfMaterials:
    """The materials of a file, each read once.

    Parameters
    ----------
    data
        The file.
    """

    data: GltfData
    notes: list[str] = field(default_factory=list)
    budget: ImageBudget = field(default_factory=ImageBudget)
    textures: dict[tuple[int, tuple[Wrap, Wrap]], Texture | None] = field(default_factory=dict)
    known: dict[int | None, GltfMaterial] = field(default_factory=dict)

    def material(self, index: Any) -> GltfMaterial:
        """Return a material, the default one for ``None``.

        Raises
        ------
        MeshError
            The index is out of range, or the image cannot be decoded.
        """
        if index not in self.known:
            tree = {} if index is None else self.data.entry("materials", index)
            self.known[index] = self._read(tree)
        return self.known[index]

    def _read(self, tree: Any) -> GltfMaterial:
        older = tree.get("extensions", {}).get(_SPECULAR)
        if older is not None:
            factor, place = older.get("diffuseFactor", 4 * [1.0]), older.get("diffuseTexture")
        else:
            metallic = tree.get("pbrMetallicRoughness", {})
            factor = metallic.get("baseColorFactor", 4 * [1.0])
            place = metallic.get("baseColorTexture")
        light = np.array(factor[:3], dtype=np.float64)
        if light.shape != (3,) or not np.isfinite(light).all():
            raise MeshError("a base colour of the glTF file is not three numbers; it is damaged")
        light = light.clip(0.0, 1.0)
        besides = _besides(tree)
        if place is None:
            return GltfMaterial(light, besides)
        texture = self._texture(self.data.entry("textures", place["index"]))
        transform = place.get("extensions", {}).get(_TRANSFORM, {})
        return GltfMaterial(
            light,
            besides,
            texture,
            int(transform.get("texCoord", place.get("texCoord", 0))),
            _matrix(transform),
        )

    def _texture(self, tree: Any) -> Texture | None:
        wrap = (Wrap.REPEAT, Wrap.REPEAT)
        if "sampler" in tree:
            sampler = self.data.entry("samplers", tree["sampler"])
            s, t = (_WRAPS[sampler.get(axis, 10497)] for axis in ("wrapS", "wrapT"))
            wrap = s, t
        webp = tree.get("extensions", {}).get("EXT_texture_webp", {})
        source = tree.get("source", webp.get("source"))
        if source is None:
            self._note("a texture of the glTF file has no PNG, JPEG or WebP image: it was not read")
            return None
        if (source, wrap) not in self.textures:
            self.textures[source, wrap] = self._decoded(source, wrap)
        return self.textures[source, wrap]

    def _decoded(self, index: Any, wrap: tuple[Wrap, Wrap]) -> Texture | None:
        image = self.data.entry("images", index)
        name = f"{index} of the glTF file"
        if "bufferView" in image:
            return Texture(
                self.budget.decode(bytes(self.data.view(image["bufferView"])), name), wrap
            )
        found = self.data.resource(image["uri"])
        if found is not None:
            return Texture(self.budget.decode(found, name), wrap)
        if self.data.companions is not None:
            raise MeshError(
                f"the glTF file refers to the image {image['uri'][:100]!r}, which is not in the "
                "archive"
            )
        self._note(
            f"the texture image {image['uri'][:100]!r} is missing: its colours were not read; save"
            " as GLB, or upload all files together as one .zip"
        )
        return None

    def _note(self, note: str) -> None:
        if note not in self.notes:
            self.notes.append(note)


def _besides(tree: Any) -> Material:
    """Name and factors; those of an image, which is not read, and of other models are left out."""
    name = str(tree.get("name", ""))
    metallic = tree.get("pbrMetallicRoughness", {})
    if (
        not tree
        or "metallicRoughnessTexture" in metallic
        or _SPECULAR in tree.get("extensions", {})
    ):
        return Material(name)
    factors = [float(metallic.get(f"{one}Factor", 1.0)) for one in ("metallic", "roughness")]
    if not np.isfinite(factors).all():
        raise MeshError("a factor of a material of the glTF file is not finite; it is damaged")
    return Material(name, *np.clip(factors, 0.0, 1.0).tolist())


def _matrix(transform: Any) -> FloatArray:
    """(2, 3) of KHR_texture_transform: scale first, then rotate, then move."""
    x, y = transform.get("offset", (0.0, 0.0))
    width, height = transform.get("scale", (1.0, 1.0))
    angle = float(transform.get("rotation", 0.0))
    if not np.isfinite([x, y, width, height, angle]).all():
        raise MeshError("a texture transformation of the glTF file is not finite; it is damaged")
    cos, sin = np.cos(angle), np.sin(angle)
    return np.array([[cos * width, sin * height, x], [-sin * width, cos * height, y]])
