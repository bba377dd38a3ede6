"""Attributes of the vertices of binary glTF 2.0: COLOR_0, JOINTS_n and WEIGHTS_n, ``_NAME``."""

from collections.abc import Sequence
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from solver.errors import MeshError, TransferError
from solver.mesh.formats import MODES, GltfData, read_glb_with, scene_of
from solver.transfer.attributes import COLORS_NAME, WEIGHTS_NAME, Attribute
from solver.transfer.files.columns import CHANNELS
from solver.transfer.files.limits import check_size
from solver.transfer.files.npz import dense_weights

WHOLE: Final = 2.0**24
"""Whole numbers up to this are exact in single precision."""


def read_glb_attributes(data: bytes) -> list[Attribute]:
    """Read the attributes of the vertices, numbered as :func:`solver.mesh.read_mesh` numbers them.

    Numbers that are all whole become labels. Joints have the names of their nodes.

    Raises
    ------
    TransferError
        The bytes are not a complete GLB file, or a joint does not exist.
    """
    try:
        return read_glb_with(data, _attributes)
    except MeshError as error:
        raise TransferError(str(error)) from error


def _attributes(data: GltfData) -> list[Attribute]:
    parts: list[dict[str, npt.NDArray[Any]]] = []
    joints: tuple[str, ...] = ()
    for mesh, placements in scene_of(data.tree).meshes:
        joints = joints or _joint_names(data, mesh)
        for primitive in data.tree["meshes"][mesh]["primitives"]:
            if primitive.get("mode", 4) in MODES:
                part = _values(data, primitive["attributes"])
                parts += [part] * len(placements)
    shared = set.intersection(*(set(part) for part in parts)) if parts else set()
    names = [name for name in parts[0] if name in shared] if parts else []
    return [_joined(name, [part[name] for part in parts], joints) for name in names]


def _values(data: GltfData, attributes: dict[str, int]) -> dict[str, npt.NDArray[Any]]:
    """Values by the name of the attribute; of skinning weights, joints and weights side by side."""
    found: dict[str, npt.NDArray[Any]] = {}
    rows = data.entry("accessors", attributes["POSITION"])["count"]
    if "COLOR_0" in attributes:
        found[COLORS_NAME] = data.normalised(attributes["COLOR_0"])
    sets = [name.removeprefix("JOINTS_") for name in attributes if name.startswith("JOINTS_")]
    if sets:
        joints = np.hstack([data.values(attributes[f"JOINTS_{one}"]) for one in sets])
        weights = np.hstack([data.normalised(attributes[f"WEIGHTS_{one}"]) for one in sets])
        found[WEIGHTS_NAME] = np.hstack([joints.astype(np.float64), weights])
    for name, index in attributes.items():
        if name.startswith("_") and len(name) > 1:
            scaled = data.entry("accessors", index).get("normalized", False)
            values = data.normalised(index) if scaled else data.values(index).astype(np.float64)
            found[name[1:]] = values[:, 0] if values.shape[1] == 1 else values
    for name, values in found.items():
        if len(values) != rows:
            raise MeshError(f"{name[:40]} of the glTF file does not have a value for every vertex")
        check_size(values.size // max(len(values), 1), len(values))
    return found


def _joint_names(data: GltfData, mesh: int) -> tuple[str, ...]:
    for node in data.tree.get("nodes", []):
        if node.get("mesh") == mesh and "skin" in node:
            places = data.entry("skins", node["skin"])["joints"]
            names = [
                str(data.entry("nodes", place).get("name", f"joint{number}"))
                for number, place in enumerate(places)
            ]
            return tuple(names) if len(set(names)) == len(names) else numbered_joints(len(names))
    return ()


def numbered_joints(count: int) -> tuple[str, ...]:
    """Return names of joints that have none."""
    return tuple(f"joint{number}" for number in range(count))


def _joined(name: str, parts: Sequence[npt.NDArray[Any]], joints: tuple[str, ...]) -> Attribute:
    if any(part.shape[1:] != parts[0].shape[1:] for part in parts):
        raise MeshError(f"{name[:40]} differs in width between the meshes of the glTF file")
    values = np.concatenate(parts)
    if name == COLORS_NAME:
        return Attribute(name, values, CHANNELS[: values.shape[1]])
    if name == WEIGHTS_NAME:
        half = values.shape[1] // 2
        numbers, weights = values[:, :half].astype(np.int64), values[:, half:]
        table = dense_weights(numbers, weights, len(joints) or None)
        return Attribute(name, table, joints or numbered_joints(table.shape[1]))
    whole = values.ndim == 1 and bool((np.abs(values) <= WHOLE).all())
    if whole and bool((values == np.rint(values)).all()):
        return Attribute(name, values.astype(np.int64))
    return Attribute(name, values)
