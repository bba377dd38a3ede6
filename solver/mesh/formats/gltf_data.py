"""Buffers, buffer views and accessors of a glTF file, checked before they are read."""

import base64
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any
from urllib.parse import unquote_to_bytes

import numpy as np
import numpy.typing as npt

from solver.errors import MeshError
from solver.mesh.formats.companions import Companions

FLOAT = 5126
ITEMS: Mapping[str, int] = {
    "SCALAR": 1,
    "VEC2": 2,
    "VEC3": 3,
    "VEC4": 4,
    "MAT2": 4,
    "MAT3": 9,
    "MAT4": 16,
}
"""Components of an accessor's entry, by its type."""

_KINDS = {5120: "i1", 5121: "u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", FLOAT: "<f4"}
"""NumPy's code of each component type."""

_GREATEST = {"u1": 255.0, "<u2": 65535.0}
"""Normalised integers that mean 1."""


@dataclass
class GltfData:
    """The JSON of a glTF file and the bytes that it refers to.

    Parameters
    ----------
    tree
        The JSON of the file.
    binary
        The binary chunk of a GLB file, which is its first buffer; ``None`` without one.
    companions
        Files that came with it, if any.
    """

    tree: dict[str, Any]
    binary: bytes | None
    companions: Companions | None = None
    buffers: dict[int, bytes] = field(default_factory=dict)

    def entry(self, kind: str, index: Any) -> Any:
        """Return one of the "accessors", "images", ...

        Raises
        ------
        MeshError
            The index is out of range.
        """
        return entry(self.tree.get(kind, []), index, kind.rstrip("s"))

    def resource(self, uri: str) -> bytes | None:
        """Return the bytes a URI names, in itself or in a companion file; ``None`` if missing."""
        if uri.startswith("data:"):
            head, _, body = uri.partition(",")
            if head.endswith(";base64"):
                return base64.b64decode(body, validate=True)
            return unquote_to_bytes(body)
        return None if self.companions is None else self.companions.find(uri)

    def view(self, index: Any) -> memoryview:
        """Return the bytes of a buffer view.

        Raises
        ------
        MeshError
            It reaches beyond its buffer.
        """
        known = self.entry("bufferViews", index)
        buffer = self._buffer(known["buffer"])
        start, length = _whole(known.get("byteOffset", 0)), _whole(known["byteLength"])
        if start + length > len(buffer):
            raise MeshError("the glTF file promises more data than it has; it is cut off")
        return memoryview(buffer)[start : start + length]

    def values(self, index: Any) -> npt.NDArray[Any]:
        """Return the entries of an accessor, (count, items), as they are stored."""
        accessor = self.entry("accessors", index)
        if "bufferView" not in accessor or "sparse" in accessor:
            raise MeshError("sparse or compressed glTF data is not supported; save it uncompressed")
        view = self.view(accessor["bufferView"])
        kind = np.dtype(_KINDS[accessor["componentType"]])
        count, items = _whole(accessor["count"]), ITEMS[accessor["type"]]
        row = kind.itemsize * items
        stride = _whole(self.entry("bufferViews", accessor["bufferView"]).get("byteStride", 0))
        stride = stride or row
        offset = _whole(accessor.get("byteOffset", 0))
        if stride < row or offset + stride * (count - 1) + row > len(view):
            raise MeshError("the glTF file promises more values than it has; it is cut off")
        return np.ndarray(
            (count, items), kind, buffer=view, offset=offset, strides=(stride, kind.itemsize)
        ).copy()

    def normalised(self, index: Any) -> npt.NDArray[np.float64]:
        """Return the entries of an accessor of floats, or of bytes or shorts that mean 0 to 1."""
        values = self.values(index)
        if values.dtype.kind == "f":
            return values.astype(np.float64)
        return values / _GREATEST[values.dtype.str.lstrip("|")]

    def _buffer(self, index: Any) -> bytes:
        known = self.entry("buffers", index)
        if index not in self.buffers:
            if "uri" in known:
                found = self.resource(known["uri"])
            else:
                found = self.binary if index == 0 else None
            if found is None and "extensions" in known:  # a fallback of compressed data
                raise MeshError(
                    "sparse or compressed glTF data is not supported; save it uncompressed"
                )
            if found is None:
                name = str(known.get("uri", "a binary chunk"))[:100]
                raise MeshError(
                    f"the glTF file keeps its data in {name!r}, which is missing; save it as GLB, "
                    "or upload all its files in one .zip"
                )
            if len(found) < _whole(known["byteLength"]):
                raise MeshError("the glTF file promises more data than it has; it is cut off")
            self.buffers[index] = found
        return self.buffers[index]


def entry(entries: Any, index: Any, what: str) -> Any:
    """Return an entry of a list in the JSON.

    Raises
    ------
    MeshError
        The index is out of range.
    """
    if type(index) is not int or not 0 <= index < len(entries):
        raise MeshError(
            f"the glTF file refers to {what} {str(index)[:20]}, which does not exist; it is damaged"
        )
    return entries[index]


def _whole(number: Any) -> int:
    if type(number) is not int or number < 0:
        raise MeshError(
            "the glTF file has a length or offset that is not a whole number; it is damaged"
        )
    return number
