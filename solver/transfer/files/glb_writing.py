"""Surfaces written as binary glTF 2.0, with attributes of their vertices."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from solver.arrays import IntArray
from solver.errors import TransferError
from solver.mesh import vertex_normals
from solver.mesh.textures import Paint
from solver.transfer.attributes import COLORS_NAME, WEIGHTS_NAME, Attribute
from solver.transfer.files.columns import color_bytes
from solver.transfer.files.glb import WHOLE, numbered_joints
from solver.transfer.files.glb_file import INDICES, VERTEX_DATA, GlbFile, for_single_precision
from solver.transfer.files.glb_materials import write_materials
from solver.transfer.files.surface import WrittenSurface
from solver.transfer.overlap import FACES
from solver.transfer.skinning import normalised_weights

_INFLUENCES: Final = 4
"""Joints of a vertex in a set of glTF, and greatest number of columns of an attribute."""


_LIMITS: Final = {"f": float(np.finfo(np.float32).max), "i": WHOLE}
"""Greatest numbers of an attribute, by the kind of its type."""


def write_glb(surfaces: Sequence[WrittenSurface], mipmaps: bool = False) -> bytes:
    """Return surfaces as a binary glTF file, a node each.

    Vertices are repeated where triangles round them have other texture coordinates. `mipmaps` says
    whether images may be shown smaller: texels near one another are of one part of the surface.

    Colours are COLOR_0, as bytes. Skinning weights are JOINTS_n and WEIGHTS_n, in sets of four, the
    greatest first, and a skin whose joints, below their parents, lie in the middle of what they
    move. All others are ``_NAME``, in single precision; those of text are numbers, and `extras` of
    the primitive has the texts. Vertices of no face have zeros where they have no value. With
    attributes of faces, which glTF has not, each triangle has vertices of its own. A shape that is
    far from the origin, very large or very small is placed by its node, or by that of its joints.
    Normals are smooth.

    Raises
    ------
    TransferError
        An attribute has more than four columns, a vertex of a face without a value, which glTF
        cannot say, or numbers that single precision cannot hold.
    """
    file = GlbFile()
    for surface in surfaces:
        node = _write_surface(file, surface, mipmaps)
        file.tree["scenes"][0]["nodes"].append(file.append("nodes", node))
    return file.to_bytes()


def _write_surface(file: GlbFile, surface: WrittenSurface, mipmaps: bool) -> dict[str, Any]:
    """Return the node of a surface whose mesh, materials and joints are written."""
    normals, paint = _normals(surface), surface.paint
    coordinates: dict[str, int] = {}
    if paint is not None or any(one.on == FACES for one in surface.attributes):
        corners = surface.faces.ravel()
        surface, of_vertex = surface.cut()
        normals = normals[corners[of_vertex]]
        if paint is not None:
            places = paint.coordinates.reshape(-1, 2)[of_vertex]
            # Where there is no texture they are not read, and may be anything.
            places = np.nan_to_num(places, posinf=0.0, neginf=0.0).astype("<f4")
            coordinates["TEXCOORD_0"] = file.accessor(places, VERTEX_DATA)
    vertices, placed = for_single_precision(surface.vertices)
    surface = replace(surface, vertices=vertices)
    position = vertices.astype("<f4")
    bounds = {"min": position.min(axis=0).tolist(), "max": position.max(axis=0).tolist()}
    primitive: dict[str, Any] = {
        "attributes": {
            "POSITION": file.accessor(position, VERTEX_DATA, **bounds),
            "NORMAL": file.accessor(normals, VERTEX_DATA),
            **coordinates,
        }
    }
    node: dict[str, Any] = {"name": surface.name}
    for one in surface.attributes:
        if one.name == WEIGHTS_NAME and one.width:
            node["skin"] = _write_skin(file, primitive, one, surface, placed)
        else:
            _write_attribute(file, primitive, one, surface)
    if "skin" not in node:  # whose joints would place the mesh alone
        node |= placed
    primitives = [
        {**primitive, "indices": _indices(file, surface.faces[faces]), **material}
        for faces, material in _parts(file, primitive, paint, mipmaps)
    ]
    node["mesh"] = file.append("meshes", {"name": surface.name, "primitives": primitives})
    return node


def _parts(
    file: GlbFile, primitive: dict[str, Any], paint: Paint | None, mipmaps: bool
) -> list[tuple[IntArray | slice, dict[str, int]]]:
    """Faces, and the entry of their material, one by one."""
    if paint is not None:
        parts = write_materials(file, paint, mipmaps)
        return [(faces, {"material": index}) for faces, index in parts]
    if "COLOR_0" in primitive["attributes"]:
        # Some programs, as trimesh, show the colours of vertices only where there is no material.
        return [(np.s_[:], {})]
    # Without one it would be of metal.
    return [(np.s_[:], {"material": _matte(file)})]


def _indices(file: GlbFile, faces: IntArray) -> int:
    return file.accessor(faces.astype("<u4").ravel(), INDICES)


def _normals(surface: WrittenSurface) -> npt.NDArray[np.float32]:
    """(W, 3) unit normals; upwards where triangles cancel out, or where there are none."""
    normals = vertex_normals(surface.vertices, surface.faces)
    normals[~normals.any(axis=1)] = [0.0, 0.0, 1.0]
    return normals.astype("<f4")


def _matte(file: GlbFile) -> int:
    """Return the index of the material that is no metal, the same for all surfaces."""
    matte = {"pbrMetallicRoughness": {"metallicFactor": 0.0}}
    there = file.tree.get("materials", [])
    return there.index(matte) if matte in there else file.append("materials", matte)


def _write_attribute(
    file: GlbFile, primitive: dict[str, Any], attribute: Attribute, surface: WrittenSurface
) -> None:
    values, attributes = attribute.values, primitive["attributes"]
    if attribute.name == COLORS_NAME and attribute.width in (3, 4):
        octets = np.full((len(values), 4), 255, dtype=np.uint8)
        octets[:, : attribute.width] = color_bytes(values)
        attributes["COLOR_0"] = file.accessor(octets, VERTEX_DATA, normalized=True)
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
    _check_numbers(attribute.name, values[surface.faces])
    numbers = np.nan_to_num(values.astype("<f4"), nan=0.0)
    attributes[f"_{attribute.name}"] = file.accessor(numbers, VERTEX_DATA)


def _check_numbers(name: str, values: npt.NDArray[Any]) -> None:
    """Refuse values that would be others in the file."""
    limit = _LIMITS[values.dtype.kind]
    if np.isnan(values).any():
        reason, others = "has vertices without a value", "PLY, CSV or NPZ"
    elif values.max(initial=0) > limit or values.min(initial=0) < -limit:
        reason, others = f"has numbers beyond {limit:.8g}", "CSV or NPZ"
    else:
        return
    raise TransferError(f"GLB cannot hold {name[:40]!r}, which {reason}; choose {others}")


def _write_skin(
    file: GlbFile,
    primitive: dict[str, Any],
    attribute: Attribute,
    surface: WrittenSurface,
    placed: dict[str, list[float]],
) -> int:
    weights = np.nan_to_num(attribute.values, nan=0.0)
    shares = normalised_weights(weights)
    most = int((shares > 0.0).sum(axis=1).max(initial=1))
    # The greatest come first, for programs that read one set.
    joints = np.argsort(-shares, axis=1, kind="stable")[:, :most]
    shares = np.take_along_axis(shares, joints, axis=1)
    # A joint without a weight at a vertex is written as 0.
    joints = np.where(shares > 0.0, joints, 0)
    padding = ((0, 0), (0, -joints.shape[1] % _INFLUENCES))
    joints, shares = np.pad(joints, padding), np.pad(shares, padding)
    kind = "u1" if weights.shape[1] <= 256 else "<u2"
    for number in range(joints.shape[1] // _INFLUENCES):
        part = np.s_[:, _INFLUENCES * number : _INFLUENCES * (number + 1)]
        primitive["attributes"] |= {
            f"JOINTS_{number}": file.accessor(joints[part].astype(kind), VERTEX_DATA),
            f"WEIGHTS_{number}": file.accessor(shares[part].astype("<f4"), VERTEX_DATA),
        }
    totals = weights.sum(axis=0)
    middles = weights.T @ surface.vertices / np.where(totals > 0.0, totals, 1.0)[:, None]
    middles[totals <= 0.0] = surface.vertices.mean(axis=0)
    names = attribute.columns or numbered_joints(attribute.width)
    parents = attribute.parents or (-1,) * len(names)
    first = len(file.tree["nodes"])
    children: dict[int, list[int]] = {}
    for joint, parent in enumerate(parents):
        children.setdefault(parent, []).append(first + joint)
    for joint, (name, parent) in enumerate(zip(names, parents, strict=True)):
        # Places of nodes are relative to their parents.
        place = middles[joint] - (middles[parent] if parent >= 0 else 0.0)
        below = {"children": children[joint]} if joint in children else {}
        file.append("nodes", {"name": name, "translation": place.tolist(), **below})
    nodes = list(range(first, first + len(names)))
    root = file.append("nodes", {"name": "joints", "children": children[-1], **placed})
    file.tree["scenes"][0]["nodes"].append(root)
    inverse = np.tile(np.eye(4, dtype="<f4"), (len(nodes), 1, 1))
    inverse[:, 3, :3] = -middles  # column by column, so this is the last column
    matrices = file.accessor(inverse.reshape(-1, 16))
    return file.append(
        "skins", {"joints": nodes, "inverseBindMatrices": matrices, "skeleton": root}
    )
