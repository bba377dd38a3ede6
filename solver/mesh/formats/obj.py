"""Wavefront OBJ: positions, faces, vertex colours, materials, textures.

Texture coordinates and normals have their own indices in a face's corners; a vertex here is a
``v`` line, whatever seams the texture has.
"""

import re
from dataclasses import dataclass, field, replace

import numpy as np

from solver.arrays import BoolArray, FloatArray, IntArray
from solver.errors import MeshError
from solver.mesh.formats.companions import Companions
from solver.mesh.formats.contents import colors_in_unit_range, polygon_contents
from solver.mesh.formats.materials import ObjMaterial, read_materials
from solver.mesh.formats.text import (
    check_digits,
    decode,
    float_table,
    last_line_note,
    lines_of,
    plain_reason,
)
from solver.mesh.repair import TriangleSoup, triangulated
from solver.mesh.textures import ImageBudget, Material, Paint, Texture, painted_colors

_OTHER_INDICES = re.compile(r"/\S*")

_NO_VERTEX = re.compile(r"(?<!\S)/")
"""The beginning of a corner that names no vertex."""

_CONTINUED = re.compile(r"(#.*|^[ \t]*(?:g|o|usemtl)[ \t].*)|\\\n", re.MULTILINE)
"""A backslash before a line break, or what keeps one that ends it: comments and names, which may be
paths of Windows."""


@dataclass
class _Lines:
    """The lines of the file by keyword.

    Attributes
    ----------
    faces
        Corners as written: "1/2/3 ...".
    known
        Numbers of ``v`` and of ``vt`` lines before each face: negative indices count from there.
    material
        Of each face, as an index into `materials`.
    group, object
        Name of each face's group (``g``) and object (``o``), empty before the first.
    """

    positions: list[str] = field(default_factory=list)
    coordinates: list[str] = field(default_factory=list)
    faces: list[str] = field(default_factory=list)
    known: list[tuple[int, int]] = field(default_factory=list)
    material: list[int] = field(default_factory=list)
    materials: list[str] = field(default_factory=lambda: [""])
    group: list[str] = field(default_factory=list)
    object: list[str] = field(default_factory=list)
    libraries: list[str] = field(default_factory=list)


def read_obj(data: bytes, companions: Companions | None = None) -> TriangleSoup:
    """Read a Wavefront OBJ file.

    Parameters
    ----------
    data
        Bytes of the file.
    companions
        The files that came with it, if any.

    Returns
    -------
    TriangleSoup
        Vertices are the ``v`` lines in the order of the file. Colours are those of the textures;
        without any, those of the vertices; without these, those of materials, if they differ.

    Raises
    ------
    MeshError
        The bytes are not a complete OBJ file, or a file that it refers to is missing among its
        companions or cannot be read.
    """
    contents, lines, sizes, corners = _contents(data)
    if companions is None:
        return _noting_missing_materials(contents, lines)
    return _Painter(lines, companions, sizes, corners).painted(contents)


def read_obj_coordinates(data: bytes) -> TriangleSoup:
    """Read a Wavefront OBJ file with its texture coordinates, and without materials.

    Parameters
    ----------
    data
        Bytes of the file.

    Returns
    -------
    TriangleSoup
        As of :func:`read_obj`; `paint` has coordinates and no textures.

    Raises
    ------
    MeshError
        The bytes are not a complete OBJ file.
    """
    contents, lines, sizes, corners = _contents(data)
    none = Companions((), "", lambda name: b"")
    return _Painter(lines, none, sizes, corners).mapped(contents)


def read_obj_parts(data: bytes) -> dict[str, list[str]]:
    """Read which group, object and material each face of a Wavefront OBJ file belongs to.

    Parameters
    ----------
    data
        Bytes of the file.

    Returns
    -------
    Names by "group" (``g``), "object" (``o``) and "material" (``usemtl``), one for each ``f`` line,
    empty before the first; only those that differ from face to face.
    """
    lines = _sorted_lines(decode(data))
    materials = [lines.materials[number] for number in lines.material]
    parts = {"group": lines.group, "object": lines.object, "material": materials}
    return {what: names for what, names in parts.items() if len(set(names)) > 1}


def _contents(data: bytes) -> tuple[TriangleSoup, _Lines, IntArray, IntArray]:
    """The surface, the lines, and the polygons: their numbers of corners, and all corners."""
    text = decode(data)
    lines = _sorted_lines(text)
    if not lines.positions:
        raise MeshError("not an OBJ file, or one without vertices: it has no line beginning with v")
    vertices, colors = _vertices(lines.positions)
    if _NO_VERTEX.search("\n".join(lines.faces)):
        raise MeshError(
            "a corner of a face of the OBJ file has no vertex before its slash; the file is damaged"
        )
    sizes = np.array([len(face.split()) for face in lines.faces], dtype=np.int64)
    before = np.array([v for v, _ in lines.known], dtype=np.int64)
    words = _OTHER_INDICES.sub("", "\n".join(lines.faces)).split()
    corners = _indices(words, np.repeat(before, sizes))
    contents = polygon_contents(vertices, sizes, corners, colors, last_line_note(text))
    return contents, lines, sizes, corners


def _sorted_lines(text: str) -> _Lines:
    lines = _Lines()
    numbers = {"": 0}
    current = 0
    named = {"g": "", "o": ""}
    for line in _joined_lines(text):
        keyword, rest = [*line.split(maxsplit=1), "", ""][:2]
        if keyword == "v":
            lines.positions.append(rest.partition("#")[0])
        elif keyword == "vt":
            lines.coordinates.append(rest.partition("#")[0])
        elif keyword == "f":
            lines.faces.append(rest.partition("#")[0])
            lines.known.append((len(lines.positions), len(lines.coordinates)))
            lines.material.append(current)
            lines.group.append(named["g"])
            lines.object.append(named["o"])
        elif keyword in named:
            named[keyword] = rest.strip()
        elif keyword == "usemtl":
            current = numbers.setdefault(rest.strip(), len(numbers))
        elif keyword == "mtllib":
            lines.libraries.append(rest.strip())
    lines.materials = list(numbers)
    return lines


def _joined_lines(text: str) -> list[str]:
    """Lines, each with those that continue it."""
    broken = lines_of(text)
    if not any(line.endswith("\\") for line in broken):
        return broken
    return _CONTINUED.sub(lambda found: found[1] or " ", "\n".join(broken)).split("\n")


def _noting_missing_materials(contents: TriangleSoup, lines: _Lines) -> TriangleSoup:
    if not lines.libraries:
        return contents
    return contents.noting(
        f"the file refers to the material file {lines.libraries[0][:100]!r}, which is missing: "
        "colours of materials and textures were not read; to include them, upload the OBJ file, "
        "its material file and its images together as one .zip"
    )


def _vertices(lines: list[str]) -> tuple[FloatArray, FloatArray | None]:
    table = float_table(lines, "vertex")
    columns = table.shape[1]
    if columns < 3:
        raise MeshError("a vertex line of the OBJ file has fewer than three coordinates")
    colors = None
    if columns in (6, 7):  # x y z r g b, an extension most programs know
        colors = colors_in_unit_range(np.ascontiguousarray(table[:, 3:6]))
    return np.ascontiguousarray(table[:, :3]), colors


def _indices(words: list[str], before: IntArray, what: str = "vertex") -> IntArray:
    """Convert OBJ's indices, which start at 1 or count back from -1, to indices from 0."""
    try:
        check_digits(" ".join(words))
        written = np.array([int(word) for word in words], dtype=np.int64)
    except (ValueError, OverflowError) as error:
        raise MeshError(
            f"a face line of the OBJ file cannot be read: {plain_reason(error)}"
        ) from error
    if (written == 0).any():
        raise MeshError(
            f"a face of the OBJ file refers to {what} 0, but OBJ counts from 1; "
            "the program that wrote the file counted from 0"
        )
    places = np.where(written > 0, written - 1, before + written)
    if (places < 0).any():
        first = int(np.argmax(places < 0))
        raise MeshError(
            f"a face of the OBJ file refers to {what} {written[first]}, counted back, but"
            f" {before[first]} come before it; the file is cut off or damaged"
        )
    return places


@dataclass(frozen=True, eq=False)
class _Painter:
    """Puts the materials of an OBJ file on its triangles.

    Parameters
    ----------
    lines
        Of the file.
    companions
        Files that came with it.
    sizes, corners
        Polygons: their numbers of corners, and all their vertex indices.
    """

    lines: _Lines
    companions: Companions
    sizes: IntArray
    corners: IntArray
    decoded: dict[tuple[bytes, bool], Texture] = field(default_factory=dict)

    def painted(self, contents: TriangleSoup) -> TriangleSoup:
        """Return the triangles with the colours of their materials."""
        materials, notes = self._materials()
        used = sorted(set(self.lines.material))
        budget = ImageBudget()
        textures: dict[tuple[str, bool], Texture | None] = {}
        for material in (materials[number] for number in used):
            key = material.image, material.clamped
            if key not in textures:
                textures[key] = self._texture(material, budget)
        contents = contents.noting(*notes)
        if not any(textures.values()):
            colors = np.array([materials[number].color for number in used]).reshape(-1, 3)
            if contents.colors is not None or not (colors != colors[:1]).any():
                return contents
        paint = self._paint(contents, materials, textures)
        colors = painted_colors(contents.vertices, contents.faces, paint)
        return replace(contents, colors=colors, paint=paint)

    def mapped(self, contents: TriangleSoup) -> TriangleSoup:
        """Return the triangles with texture coordinates alone."""
        cut = self._cut(contents)
        of_corner, known = self._coordinates()
        coordinates = of_corner[cut]
        if not np.isfinite(coordinates).all():
            raise MeshError("a texture coordinate is not a finite number")
        coordinates[:, :, 1] = 1.0 - coordinates[:, :, 1]
        number = np.where(known[cut].all(axis=1), 0, -1)
        paint = Paint(coordinates, np.ones((len(cut), 3)), number, ())
        return replace(contents, paint=paint)

    def _cut(self, contents: TriangleSoup) -> IntArray:
        """(F, 3) corners of the polygons, as numbered one after the other, of all triangles."""
        # The same triangles as those of the faces: they depend on positions alone.
        places = contents.vertices[self.corners]
        return triangulated(places, self.sizes, np.arange(len(self.corners))).triangles

    def _texture(self, material: ObjMaterial, budget: ImageBudget) -> Texture | None:
        """Decode the image of a material, once however it is named."""
        data = material.image_file(self.companions)
        if data is None:
            return None
        key = data, material.clamped
        if key not in self.decoded:
            self.decoded[key] = material.texture(data, budget)
        return self.decoded[key]

    def _materials(self) -> tuple[list[ObjMaterial], list[str]]:
        """Materials by the index that faces use, and notes."""
        known: dict[str, ObjMaterial] = {}
        seen: set[bytes] = set()  # a file may be named on every line
        used = {*self.lines.materials}
        for library in dict.fromkeys(self.lines.libraries):
            files = [self.companions.find(name) for name in (library, *library.split())]
            found = files[:1] if files[0] is not None else files[1:]
            for data in found:
                if data is None:
                    raise MeshError(
                        f"the OBJ file refers to the material file {library[:100]!r}, which is "
                        "not in the archive"
                    )
                if data not in seen:
                    seen.add(data)
                    known |= read_materials(data, used)
        missing = [name for name in self.lines.materials[1:] if name not in known]
        notes = (
            [f"the material {missing[0][:100]!r} is not defined; it was taken as white"]
            if missing
            else []
        )
        return [known.get(name, ObjMaterial()) for name in self.lines.materials], notes

    def _paint(
        self,
        contents: TriangleSoup,
        materials: list[ObjMaterial],
        textures: dict[tuple[str, bool], Texture | None],
    ) -> Paint:
        cut = self._cut(contents)
        polygon = np.repeat(np.arange(len(self.sizes)), self.sizes)[cut[:, 0]]
        material = np.array(self.lines.material, dtype=np.int64)[polygon]
        of_corner, known = self._coordinates()
        scale, offset = (
            np.array([getattr(m, what) for m in materials]) for what in ("scale", "offset")
        )
        coordinates = of_corner[cut] * scale[material][:, None] + offset[material][:, None]
        has: BoolArray = np.all(known[cut], axis=1)
        present = list(dict.fromkeys(texture for texture in textures.values() if texture))
        place = {texture: number for number, texture in enumerate(present)}
        of_material = np.full(len(materials), -1, dtype=np.int64)
        for index in np.unique(material).tolist():
            texture = textures[materials[index].image, materials[index].clamped]
            of_material[index] = -1 if texture is None else place[texture]
        number = np.where(has, of_material[material], -1)
        coordinates[:, :, 1] = 1.0 - coordinates[:, :, 1]  # OBJ counts v from the last row upwards
        colors = np.array([one.color for one in materials])[material]
        named = tuple(map(Material, self.lines.materials))
        return Paint(coordinates, colors, number, tuple(present), None, material, named)

    def _coordinates(self) -> tuple[FloatArray, BoolArray]:
        """(corners, 2) texture coordinates of polygons' corners, and (corners,) which have any."""
        table = float_table(self.lines.coordinates, "texture coordinate")
        found = np.zeros((len(self.corners), 2))
        parts = [word.split("/") for face in self.lines.faces for word in face.split()]
        words = [part[1] if len(part) > 1 else "" for part in parts]
        has = np.array([bool(word) for word in words], dtype=np.bool_)
        before = np.array([vt for _, vt in self.lines.known], dtype=np.int64)
        before = np.repeat(before, self.sizes)[has]
        index = _indices([word for word in words if word], before, "texture coordinate")
        if len(index) and (index.min() < 0 or index.max() >= len(table)):
            raise MeshError(
                "a face of the OBJ file refers to a texture coordinate that does not exist; "
                "the file is cut off or damaged"
            )
        if len(index):
            width = min(table.shape[1], 2)
            found[has, :width] = table[index, :width]
        return found, has
