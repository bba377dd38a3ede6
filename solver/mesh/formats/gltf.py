"""glTF 2.0, binary (GLB) or JSON with its buffers inside or in companion files.

The meshes of the scene are transformed by their nodes, or by the joints of their skins as these are
placed in the file, and joined into one. A vertex of glTF has one normal and one pair of texture
coordinates, so files repeat vertices along seams and creases; vertices in the same position are
merged again.

Texture, COLOR_0 and base colour factor are multiplied in linear light, as the standard demands.
COLOR_0 itself, linear by the standard, is taken as sRGB like the texels of a texture: most programs
write it so, and a shape gets the same colours in every format.
"""

import json
import struct
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, TypeVar

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.errors import MeshError, SolverError
from solver.mesh.formats.companions import Companions
from solver.mesh.formats.contents import check_indices
from solver.mesh.formats.gltf_data import GltfData
from solver.mesh.formats.gltf_materials import GltfMaterial, GltfMaterials
from solver.mesh.formats.gltf_scene import MODES, Placement, check_tree, scene_of, vertex_set
from solver.mesh.formats.gltf_skins import GltfSkins, check_joints, influences, skinned
from solver.mesh.repair import TriangleSoup, merge_coincident
from solver.mesh.textures import Material, Paint, Texture, linear_light, painted_colors, tinted

T = TypeVar("T")

_SEAMS = "glTF repeats vertices along texture seams and creases"
_JSON, _BINARY = b"JSON", b"BIN\0"


def read_glb(data: bytes, companions: Companions | None = None) -> TriangleSoup:
    """Read a binary glTF file.

    Parameters
    ----------
    data
        Bytes of the file.
    companions
        The files that came with it, if any.

    Returns
    -------
    TriangleSoup
        `vertex_ids` number the positions of all primitives, in the order of meshes in the file and
        of primitives in a mesh, once for each node that shows it; primitives of a mesh with the
        same accessors have the same vertices, which count once.

    Raises
    ------
    MeshError
        The bytes are not a complete GLB file, or use features that are not supported.
    """
    return _opened(*_chunks(data), companions, "GLB", _surface)


def read_gltf(data: bytes, companions: Companions | None = None) -> TriangleSoup:
    """Read a glTF file in JSON, with buffers and images in data URIs or companion files.

    Parameters
    ----------
    data
        Bytes of the file.
    companions
        The files that came with it, if any.

    Returns
    -------
    TriangleSoup
        As :func:`read_glb`.

    Raises
    ------
    MeshError
        The bytes are not glTF, use features that are not supported, or a buffer is missing.
    """
    return _opened(data, None, companions, "GLTF", _surface)


def read_glb_with(data: bytes, read: Callable[[GltfData], T]) -> T:
    """Open a GLB file as :func:`read_glb` does, and read something else of it than its surface.

    Parameters
    ----------
    data
        Bytes of the file.
    read
        Reads the checked file; whatever it raises is reported as damage of the file.

    Raises
    ------
    MeshError
        The bytes are not a complete GLB file, or use features that are not supported.
    """
    return _opened(*_chunks(data), None, "GLB", read)


def _chunks(data: bytes) -> tuple[bytes, bytes | None]:
    """Return the JSON of a GLB file, and its binary chunk."""
    if len(data) < 20 or data[:4] != b"glTF":
        raise MeshError("not a GLB file: it does not begin with glTF")
    version, length, json_length, kind = struct.unpack_from("<4xIII4s", data)
    if version != 2:
        raise MeshError(f"GLB of version {version} is not supported; save it as glTF 2.0")
    if max(length, 20 + json_length) > len(data):
        promised = max(length, 20 + json_length)
        raise MeshError(
            f"the GLB file promises {promised} bytes and has {len(data)}; it is cut off"
        )
    if length < 20 + json_length or kind != _JSON:
        raise MeshError(
            "the GLB file is longer than its header says, or has no JSON chunk first; it is damaged"
        )
    return data[20 : 20 + json_length], _binary(data, 20 + json_length)


def _binary(data: bytes, start: int) -> bytes | None:
    """Return the binary chunk of a GLB file, which follows its JSON."""
    if len(data) < start + 8:
        return None
    length, kind = struct.unpack_from("<I4s", data, start)
    if kind != _BINARY:
        return None
    if start + 8 + length > len(data):
        raise MeshError("the GLB file promises more bytes than it has; it is cut off")
    return data[start + 8 : start + 8 + length]


def _surface(data: GltfData) -> TriangleSoup:
    materials = GltfMaterials(data)
    parts = _parts(data, materials)
    if not parts:
        raise MeshError("the glTF scene shows no triangles")
    return _joined(parts).noting(*materials.notes)


def _opened(
    text: bytes,
    binary: bytes | None,
    companions: Companions | None,
    kind: str,
    read: Callable[[GltfData], T],
) -> T:
    """Check a file before anything is read, and report whatever is raised then as damage."""
    try:
        tree = json.loads(text.decode("utf-8"))
        size = len(text) + len(binary or b"")
        if companions is not None and isinstance(tree, dict):
            uris = {buffer.get("uri", "data:") for buffer in tree.get("buffers", [])}
            files = [companions.find(uri) for uri in uris if not uri.startswith("data:")]
            size += sum(len(file or b"") for file in files)
        check_tree(tree, size)
        return read(GltfData(tree, binary, companions))
    except (SolverError, MemoryError):
        raise
    except Exception as error:  # the JSON may have anything anywhere
        raise MeshError(
            f"the {kind} file cannot be read; it is damaged or cut off: {_reason(error)[:200]}"
        ) from error


def _reason(error: Exception) -> str:
    """Return what is wrong with a file by what was raised when its JSON was used."""
    match error:
        case json.JSONDecodeError():
            return f"its JSON ends early or is none: {error}"
        case UnicodeDecodeError():
            return "its JSON is not UTF-8"
        case RecursionError():
            return "its JSON is nested too deeply"
        case KeyError():
            return f"{error} is missing in its JSON, or unknown"
        case AttributeError() | TypeError() | IndexError():
            return "a value in its JSON is not of the kind that glTF has there"
    return str(error) or type(error).__name__


@dataclass(frozen=True, eq=False)
class _Part:
    """The triangles of one primitive, placed by one node or not yet.

    Attributes
    ----------
    vertices, faces
        (V, 3) and (F, 3).
    colors
        (V, 3) in 0..1, of COLOR_0; ``None`` without.
    coordinates
        (V, 2) texture coordinates, transformed by the material; ``None`` without.
    material
        Base colour.
    influences
        (V, k) joints and weights of a mesh with a skin; ``None`` without.
    start
        Number of its first vertex.
    repeated
        Whether its vertices are those of an earlier part.
    """

    vertices: FloatArray
    faces: IntArray
    colors: FloatArray | None
    coordinates: FloatArray | None
    material: GltfMaterial
    influences: tuple[IntArray, FloatArray] | None = None
    start: int = 0
    repeated: bool = False


def _parts(data: GltfData, materials: GltfMaterials) -> list[_Part]:
    parts: list[_Part] = []
    count = 0
    meshes = data.tree.get("meshes", [])
    scene = scene_of(data.tree)
    skins = GltfSkins(data, scene)
    for mesh, placements in scene.meshes:
        starts: dict[frozenset[tuple[str, int]], int] = {}
        for primitive in meshes[mesh]["primitives"]:
            if primitive.get("mode", 4) in MODES:
                part, own = _part(data, materials, primitive), vertex_set(primitive)
                if any(one.skin is not None for one in placements):
                    part = replace(part, influences=influences(data, primitive["attributes"]))
                part = replace(part, start=starts.get(own, count), repeated=own in starts)
                rows = len(part.vertices)
                parts.extend(
                    replace(_placed(part, one, skins), start=part.start + place * rows)
                    for place, one in enumerate(placements)
                )
                if own not in starts:
                    starts[own] = count
                    count += rows * len(placements)
    return parts


def _part(data: GltfData, materials: GltfMaterials, primitive: Any) -> _Part:
    attributes = primitive["attributes"]
    vertices = data.values(attributes["POSITION"]).astype(np.float64)
    if "indices" in primitive:
        indices = data.values(primitive["indices"]).reshape(-1).astype(np.int64)
    else:
        indices = np.arange(len(vertices))
    check_indices(indices, len(vertices))
    colors = coordinates = None
    if "COLOR_0" in attributes:
        colors = data.normalised(attributes["COLOR_0"])[:, :3]
        if colors.shape != vertices.shape or not np.isfinite(colors).all():
            raise MeshError("COLOR_0 of the glTF file is not a colour for every vertex")
        colors = colors.clip(0.0, 1.0)
    material = materials.material(primitive.get("material"))
    name = f"TEXCOORD_{material.coordinates}"
    if material.texture is not None and name in attributes:
        written = data.normalised(attributes[name])
        if written.shape != (len(vertices), 2):
            raise MeshError(f"{name} of the glTF file is not a pair for every vertex")
        coordinates = written @ material.matrix[:, :2].T + material.matrix[:, 2]
    faces = MODES[primitive.get("mode", 4)](indices)
    return _Part(vertices, faces, colors, coordinates, material)


def _placed(part: _Part, placement: Placement, skins: GltfSkins) -> _Part:
    matrix = placement.matrix
    if placement.skin is None or part.influences is None:
        vertices = part.vertices @ matrix[:3, :3].T + matrix[:3, 3]
    else:
        joints, weights = part.influences
        matrices = skins.matrices(placement.skin)
        check_joints(joints, len(matrices))
        vertices, matrix = skinned(part.vertices, joints, weights, matrices), matrices[0]
    # A reflection reverses the winding.
    faces = part.faces[:, ::-1] if np.linalg.det(matrix[:3, :3]) < 0.0 else part.faces
    return replace(part, vertices=vertices, faces=faces)


def _joined(parts: Sequence[_Part]) -> TriangleSoup:
    apart = [part for part in parts if not part.repeated]
    notes = (f"{len(apart)} meshes of the scene were joined",) if len(apart) > 1 else ()
    colors = None
    if any(part.colors is not None for part in apart):
        colors = np.concatenate(
            [np.ones_like(p.vertices) if p.colors is None else p.colors for p in apart]
        )
    vertices = np.concatenate([part.vertices for part in apart])
    faces = np.concatenate([part.faces + part.start for part in parts])
    merged = merge_coincident(
        TriangleSoup(
            vertices,
            faces,
            colors,
            np.arange(len(vertices), dtype=np.int64),
            np.arange(len(faces), dtype=np.int64),
            notes,
        ),
        _SEAMS,
    )
    lights = np.array([part.material.light for part in parts])
    textured = any(part.coordinates is not None for part in parts)
    # One colour all over does not distinguish points.
    plain = (lights == 1.0 if colors is not None else lights == lights[:1]).all()
    if plain and not textured:
        return merged
    paint = _paint(parts)
    painted = painted_colors(merged.vertices, merged.faces, paint)
    if merged.colors is not None:
        painted = tinted(painted, linear_light(merged.colors))
    return replace(merged, colors=painted, paint=paint)


def _paint(parts: Sequence[_Part]) -> Paint:
    """Colours and textures of all triangles, part after part."""
    textures: dict[Texture, int] = {}
    materials: dict[Material, int] = {}
    coordinates, colors, numbers, lights, besides = [], [], [], [], []
    for part in parts:
        number, texture = -1, part.material.texture
        placed = np.zeros((len(part.faces), 3, 2))
        if texture is not None and part.coordinates is not None:
            number = textures.setdefault(texture, len(textures))
            placed = part.coordinates[part.faces]
        coordinates.append(placed)
        colors.append(np.broadcast_to(part.material.color, (len(part.faces), 3)))
        numbers.append(np.full(len(part.faces), number, dtype=np.int64))
        lights.append(np.broadcast_to(part.material.light, (len(part.faces), 3)))
        material = materials.setdefault(part.material.besides, len(materials))
        besides.append(np.full(len(part.faces), material, dtype=np.int64))
    return Paint(
        np.concatenate(coordinates),
        np.concatenate(colors),
        np.concatenate(numbers),
        tuple(textures),
        np.concatenate(lights),
        np.concatenate(besides),
        tuple(materials),
    )
