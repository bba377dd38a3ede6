"""Binary glTF 2.0 as it is written: the JSON, and the binary chunk."""

import json
import struct
from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from solver.arrays import FloatArray

_KINDS: Final = {"u1": 5121, "<u2": 5123, "<u4": 5125, "<f4": 5126}
"""Component types, by NumPy's code."""

_ITEMS: Final = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4", 16: "MAT4"}
VERTEX_DATA, INDICES = 34962, 34963
"""Targets of views."""

_FAR: Final = 16.0
"""Largest coordinate, in extents, up to which single precision resolves a millionth of a shape."""

_SMALLEST, _LARGEST = 1e-30, 1e30
"""Extents that single precision (1e±38) resolves as well."""


@dataclass
class GlbFile:
    """A glTF file as it is written: its JSON, and the binary chunk.

    It has no materials at first: some programs show the colours of vertices only where there is
    none.
    """

    tree: dict[str, Any] = field(
        default_factory=lambda: {
            "asset": {"version": "2.0", "generator": "isomatch"},
            "scene": 0,
            "scenes": [{"nodes": []}],
            "nodes": [],
            "meshes": [],
            "accessors": [],
            "bufferViews": [],
            "buffers": [],
        }
    )
    binary: bytearray = field(default_factory=bytearray)

    def append(self, kind: str, entry: dict[str, Any]) -> int:
        """Append an entry, and return its index."""
        entries: list[dict[str, Any]] = self.tree.setdefault(kind, [])
        entries.append(entry)
        return len(entries) - 1

    def view(self, data: bytes, target: int | None = None) -> int:
        """Append bytes to the binary chunk, and return the index of their view."""
        view = {"buffer": 0, "byteOffset": len(self.binary), "byteLength": len(data)}
        if target is not None:
            view["target"] = target
        self.binary += data
        self.binary += bytes(-len(self.binary) % 4)
        return self.append("bufferViews", view)

    def accessor(self, values: npt.NDArray[Any], target: int | None = None, **more: Any) -> int:
        """Append values, (n,) or (n, k) of a type of glTF, and return the accessor's index."""
        table = values.reshape(len(values), -1)
        entry = {
            "bufferView": self.view(table.tobytes(), target),
            "componentType": _KINDS[table.dtype.str.lstrip("|")],
            "count": len(table),
            "type": _ITEMS[table.shape[1]],
        }
        return self.append("accessors", entry | more)

    def to_bytes(self) -> bytes:
        """Return the file."""
        self.tree["buffers"] = [{"byteLength": len(self.binary)}]
        text = json.dumps(self.tree, separators=(",", ":")).encode()
        text += b" " * (-len(text) % 4)
        length = 12 + 8 + len(text) + 8 + len(self.binary)
        head = struct.pack("<4sIIII", b"glTF", 2, length, len(text), 0x4E4F534A)
        return head + text + struct.pack("<II", len(self.binary), 0x004E4942) + self.binary


def for_single_precision(vertices: FloatArray) -> tuple[FloatArray, dict[str, list[float]]]:
    """Place a shape so that single precision, the only one of glTF, keeps its details.

    Parameters
    ----------
    vertices
        (V, 3).

    Returns
    -------
    (V, 3) positions, and the transformation of a node, in double precision, that takes them to
    where the vertices are: empty for shapes that are near the origin and of ordinary size, whose
    positions are the vertices.
    """
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    extent = float((high - low).max())
    fits = extent == 0.0 or _SMALLEST < extent < _LARGEST
    if fits and float(np.abs(vertices).max()) <= _FAR * extent:
        return vertices, {}
    centre = 0.5 * low + 0.5 * high
    placed: dict[str, list[float]] = {"translation": centre.tolist()}
    scale = 1.0
    if not fits:
        scale = float(2.0 ** np.rint(np.log2(extent)))
        placed["scale"] = [scale] * 3
    return (vertices - centre) / scale, placed
