"""Material libraries of Wavefront OBJ (MTL): diffuse colours and images."""

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from solver.arrays import FloatArray
from solver.errors import MeshError
from solver.mesh.formats.companions import Companions
from solver.mesh.formats.text import check_digits, decode, lines_of
from solver.mesh.textures import ImageBudget, Texture, Wrap

_SWITCHES = frozenset({"-blendu", "-blendv", "-cc", "-clamp"})
_ONE_WORD = frozenset({"-boost", "-texres", "-bm", "-imfchan", "-type", "-colorspace"})
_VECTORS = frozenset({"-o", "-s", "-t"})
_MOST_WORDS = 100
"""Words of the options of an image; all options together have about thirty."""


@dataclass(frozen=True, eq=False)
class ObjMaterial:
    """The diffuse colour of a material.

    Parameters
    ----------
    color
        (3,) diffuse colour in 0..1, taken as display values (sRGB).
    image
        File of the diffuse texture, which replaces `color`; "" for none.
    clamped
        Whether the image ends at its border; it is repeated otherwise.
    scale, offset
        (2,) texture coordinates are multiplied by `scale`, then `offset` is added.
    """

    color: FloatArray = field(default_factory=lambda: np.ones(3))
    image: str = ""
    clamped: bool = False
    scale: FloatArray = field(default_factory=lambda: np.ones(2))
    offset: FloatArray = field(default_factory=lambda: np.zeros(2))

    def image_file(self, companions: Companions) -> bytes | None:
        """Return the bytes of the image; None without one.

        Raises
        ------
        MeshError
            The image is missing.
        """
        if not self.image:
            return None
        data = companions.find(self.image)
        if data is None:
            raise MeshError(
                f"a material refers to the image {self.image[:100]!r}, which is not in the archive"
            )
        return data

    def texture(self, data: bytes, budget: ImageBudget) -> Texture:
        """Decode the image.

        Raises
        ------
        MeshError
            It cannot be decoded.
        """
        wrap = Wrap.CLAMP if self.clamped else Wrap.REPEAT
        return Texture(budget.decode(data, self.image[:100]), (wrap, wrap))


def read_materials(data: bytes, used: Collection[str]) -> dict[str, ObjMaterial]:
    """Read a material library.

    Parameters
    ----------
    data
        Bytes of the file.
    used
        Names of the materials that are read: libraries may have very many others.

    Returns
    -------
    The materials by name.

    Raises
    ------
    MeshError
        A diffuse colour or the options of an image cannot be read.
    """
    # The last line of a keyword counts, and only that is parsed.
    written: dict[str, dict[str, str]] = {}
    said: dict[str, str] | None = None
    for line in lines_of(decode(data)):
        keyword, rest = [*line.split(maxsplit=1), "", ""][:2]
        if keyword == "newmtl":
            said = written[rest.strip()] = {}
        elif said is not None and keyword.lower() in ("kd", "map_kd"):
            said[keyword.lower()] = rest.strip()
    return {name: _material(said) for name, said in written.items() if name in used}


def _material(said: Mapping[str, str]) -> ObjMaterial:
    material = ObjMaterial()
    if "kd" in said:
        material = replace(material, color=_color(said["kd"]))
    return _with_image(material, said["map_kd"]) if "map_kd" in said else material


def _color(rest: str) -> FloatArray:
    words = rest.partition("#")[0].split()
    if words[:1] in (["spectral"], ["xyz"]):
        return np.ones(3)
    values = _numbers(words, "Kd")
    if len(values) not in (1, 3):
        raise MeshError(f"a colour of the material file cannot be read: Kd {rest[:80]!r}")
    found: FloatArray = np.broadcast_to(values, (3,)).clip(0.0, 1.0)
    return found


def _with_image(material: ObjMaterial, rest: str) -> ObjMaterial:
    """Parse options and the file name after them, which may have spaces."""
    words = rest.split()
    place = 0
    while place < len(words) and words[place].startswith("-"):
        if place > _MOST_WORDS:
            raise MeshError("an image of the material file has more options than there are")
        option = words[place].lower()
        place += 1
        if option in _SWITCHES or option in _ONE_WORD:
            value = words[place] if place < len(words) else ""
            if option == "-clamp":
                material = replace(material, clamped=value.lower() == "on")
            place += 1
        elif option == "-mm":
            place += 2
        elif option in _VECTORS:
            values = [word for word in words[place : place + 3] if _is_number(word)]
            place += len(values)
            pair = _numbers(values, option)[:2]
            if option == "-o":
                material = replace(material, offset=np.pad(pair, (0, 2 - len(pair))))
            elif option == "-s":
                ones = np.pad(pair, (0, 2 - len(pair)), constant_values=1.0)
                material = replace(material, scale=ones)
        else:
            place -= 1
            break
    return replace(material, image=" ".join(words[place:]))


def _is_number(word: str) -> bool:
    try:
        check_digits(word)
        float(word)
    except ValueError:
        return False
    return True


def _numbers(words: list[str], what: str) -> FloatArray:
    try:
        check_digits(" ".join(words))
        values = np.array([float(word) for word in words])
    except ValueError as error:
        raise MeshError(
            f"a number of {what} in the material file cannot be read: {error}"
        ) from None
    if not np.isfinite(values).all():
        raise MeshError(f"{what} in the material file has a number that is not finite")
    return values
