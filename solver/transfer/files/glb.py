"""Attributes of the vertices of binary glTF 2.0: COLOR_0, JOINTS_n and WEIGHTS_n, ``_NAME``."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.errors import MeshError, TransferError
from solver.mesh.formats import (
    MODES,
    GltfData,
    check_joints,
    influences,
    joint_nodes,
    read_glb_with,
    scene_of,
    vertex_set,
)
from solver.transfer.attributes import COLORS_NAME, WEIGHTS_NAME, Attribute
from solver.transfer.files.columns import CHANNELS
from solver.transfer.files.limits import check_size, text_column
from solver.transfer.files.names import distinct
from solver.transfer.files.npz import dense_weights
from solver.transfer.skinning import parents_among

WHOLE: Final = 2.0**24
"""Whole numbers up to this are exact in single precision."""


def read_glb_attributes(data: bytes) -> list[Attribute]:
    """Read the attributes of the vertices, numbered as :func:`solver.mesh.read_mesh` numbers them.

    Numbers that are all whole become labels, and text if every primitive that has them has a text
    for each in its `extras`, as :func:`.write_glb` writes them. Joints have the names and the
    parents of their nodes, and are one where skins share a node. Vertices of meshes without an
    attribute have no value (nan, or no text), and no weights (0).

    Raises
    ------
    TransferError
        The bytes are not a complete GLB file, or a joint does not exist.
    """
    try:
        return read_glb_with(data, _attributes)
    except MeshError as error:
        raise TransferError(str(error)) from error


@dataclass(frozen=True, eq=False)
class _Part:
    """Attributes of the vertices of one primitive, as one node shows it.

    Parameters
    ----------
    rows
        Number V of vertices.
    values
        (V, n) by the name of the attribute.
    texts
        Texts that the numbers of an attribute stand for, by its name.
    influences
        (V, k) joints, by the numbers of the skin, and their weights; ``None`` without.
    skin
        Index of the skin; ``None`` without.
    """

    rows: int
    values: dict[str, FloatArray]
    texts: dict[str, list[str]]
    influences: tuple[IntArray, FloatArray] | None
    skin: int | None = None


def _attributes(data: GltfData) -> list[Attribute]:
    parts: list[_Part] = []
    values = 0
    for mesh, placements in scene_of(data.tree).meshes:
        known: set[frozenset[tuple[str, int]]] = set()
        for primitive in data.tree["meshes"][mesh]["primitives"]:
            if primitive.get("mode", 4) in MODES and vertex_set(primitive) not in known:
                known.add(vertex_set(primitive))
                part = _part(data, primitive)
                values += sum(one.size for one in part.values.values())
                check_size(1, values)
                parts += [replace(part, skin=one.skin) for one in placements]
    names = dict.fromkeys(name for part in parts for name in part.values)
    rows = [part.rows for part in parts]
    check_size(len({*names} - {COLORS_NAME}), sum(rows))
    tables = {name: [part.values.get(name) for part in parts] for name in names}
    widest = [
        max(one.shape[1] for one in some if one is not None)
        for name, some in tables.items()
        if name != COLORS_NAME
    ]
    check_size(sum(widest), sum(rows))
    found = [
        _joined_text(name, parts) or _joined(name, some, rows) for name, some in tables.items()
    ]
    if all(part.influences is None for part in parts):
        return found
    return [_skin(data, parts), *(one for one in found if one.name != WEIGHTS_NAME)]


def _part(data: GltfData, primitive: Any) -> _Part:
    attributes = primitive["attributes"]
    found: dict[str, FloatArray] = {}
    rows = data.entry("accessors", attributes["POSITION"])["count"]
    check_size(sum(name.startswith("_") for name in attributes), rows)
    check_size(4 * sum(name.startswith("JOINTS_") for name in attributes), rows)
    if "COLOR_0" in attributes:
        found[COLORS_NAME] = data.normalised(attributes["COLOR_0"])
    for name, index in attributes.items():
        if name.startswith("_") and name[1:] not in ("", *found):
            scaled = data.entry("accessors", index).get("normalized", False)
            values = data.normalised(index) if scaled else data.values(index).astype(np.float64)
            found[name[1:]] = values
    for name, values in found.items():
        if len(values) != rows:
            raise MeshError(f"{name[:40]} of the glTF file does not have a value for every vertex")
    return _Part(rows, found, _labels(primitive), influences(data, attributes))


def _labels(primitive: Any) -> dict[str, list[str]]:
    """Return the texts in the `extras` of a primitive, which may be of another program."""
    extras = primitive.get("extras")
    labels = extras.get("labels") if isinstance(extras, dict) else None
    if not isinstance(labels, dict):
        return {}
    return {
        name: texts
        for name, texts in labels.items()
        if isinstance(texts, list) and all(isinstance(text, str) for text in texts)
    }


def _joined_text(name: str, parts: Sequence[_Part]) -> Attribute | None:
    """Texts of all primitives, if each has one for every number; empty for those without."""
    texts, places = [""], []
    starts: dict[int, int] = {}  # primitives may be shown often
    for part in parts:
        values, own = part.values.get(name), part.texts.get(name, [])
        if values is None:
            places.append(np.zeros(part.rows, dtype=np.int64))
            continue
        if values.shape[1] != 1 or not np.isin(values, np.arange(len(own))).all():
            return None
        start = starts.setdefault(id(own), len(texts))
        if start == len(texts):
            texts += own
        places.append(start + values[:, 0].astype(np.int64))
    return Attribute(name, text_column(texts, np.concatenate(places)))


def numbered_joints(count: int) -> tuple[str, ...]:
    """Return names of joints that have none."""
    return tuple(f"joint{number}" for number in range(count))


def _skin(data: GltfData, parts: Sequence[_Part]) -> Attribute:
    """Weights of the joints of all skins, each joint once, by its node."""
    rows = [part.rows for part in parts]
    nodes = _joints_by_skin(data, parts)
    column = {node: 0 for joints in nodes.values() for node in joints}
    column = {node: number for number, node in enumerate(column)}
    check_size(len(column), sum(rows))
    columns = {
        skin: np.array([column[node] for node in joints], dtype=np.int64)
        for skin, joints in nodes.items()
    }
    table = np.zeros((sum(rows), len(column)))
    for part, end in zip(parts, np.cumsum(rows).tolist(), strict=True):
        if part.influences is not None and part.skin in columns:
            joints, weights = part.influences
            own = columns[part.skin]
            check_joints(joints, len(own))
            table[end - part.rows : end] = dense_weights(own[joints], weights, len(column))
    numbers = numbered_joints(len(column))
    if None in nodes:
        return Attribute(WEIGHTS_NAME, table, numbers)
    known = [data.entry("nodes", node).get("name") for node in column]
    names = distinct(str(one or other) for one, other in zip(known, numbers, strict=True))
    above = dict.fromkeys(range(len(data.tree["nodes"])), -1)
    for number, node in enumerate(data.tree["nodes"]):
        above |= dict.fromkeys(node.get("children", ()), number)
    parents = parents_among(above, list(column))
    return Attribute(WEIGHTS_NAME, table, names, parents=parents)


def _joints_by_skin(data: GltfData, parts: Sequence[_Part]) -> dict[int | None, Sequence[int]]:
    """Nodes of the joints of each skin; where no mesh has one, joints by number, of skin None.

    Beside meshes with a skin, the joints of one without it move nothing.
    """
    weighted = [part for part in parts if part.influences is not None]
    skins = dict.fromkeys(part.skin for part in weighted if part.skin is not None)
    if skins:
        return {skin: joint_nodes(data, skin) for skin in skins}
    greatest = max(int(part.influences[0].max(initial=0)) for part in weighted if part.influences)
    check_size(greatest + 1, sum(part.rows for part in parts))
    return {None: range(greatest + 1)}


def _joined(name: str, tables: Sequence[FloatArray | None], rows: Sequence[int]) -> Attribute:
    """One table of the values of all primitives, nan for those without."""
    widths = {table.shape[1] for table in tables if table is not None}
    width = max(widths)
    if len(widths) > 1 and name != COLORS_NAME:
        raise MeshError(f"{name[:40]} differs in width between the meshes of the glTF file")
    values = np.full((sum(rows), width), np.nan)
    for table, count, end in zip(tables, rows, np.cumsum(rows).tolist(), strict=True):
        if table is not None:
            # Colours without transparency beside others are opaque.
            values[end - count : end, table.shape[1] :] = 1.0
            values[end - count : end, : table.shape[1]] = table
    if name == COLORS_NAME and width in (3, 4):
        return Attribute(name, values, CHANNELS[:width])
    if width > 1:
        return Attribute(name, values)
    (numbers,) = values.T
    whole = bool((np.abs(numbers) <= WHOLE).all())
    if whole and bool((numbers == np.rint(numbers)).all()):
        return Attribute(name, numbers.astype(np.int64))
    return Attribute(name, numbers)
