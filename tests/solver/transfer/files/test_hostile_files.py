"""Attribute files that are damaged, hostile or of something else are refused with the reason."""

import io
import json
import struct
import zipfile
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from solver.errors import TransferError
from solver.transfer import Attribute
from solver.transfer.files import (
    ATTRIBUTE_FORMATS,
    WrittenSurface,
    read_attributes,
)
from tests.solver import shapes
from tests.solver.transfer.files.written import write_attributes

MESH = shapes.icosphere(0)
ROWS = MESH.n_vertices
GOOD = [
    Attribute("a", np.arange(float(ROWS))),
    Attribute("colors", np.zeros((ROWS, 3))),
    Attribute("weights", np.full((ROWS, 2), 0.5), ("left", "right")),
]


def archive(**arrays: Any) -> bytes:
    stream = io.BytesIO()
    np.savez(stream, **arrays)
    return stream.getvalue()


def bomb() -> bytes:
    """A small archive that unpacks to more than is allowed."""
    stream = io.BytesIO()
    packed = zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED, compresslevel=1)
    with packed, packed.open("a.npy", "w") as member:
        np.lib.format.write_array_header_1_0(
            member, {"descr": "|u1", "fortran_order": False, "shape": (300 * 2**20,)}
        )
        for _ in range(300):
            member.write(bytes(2**20))
    return stream.getvalue()


def vast(shape: tuple[int, ...], descr: str = "<f8") -> bytes:
    """An archive whose header promises more than it has."""
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as packed, packed.open("a.npy", "w") as member:
        np.lib.format.write_array_header_1_0(
            member, {"descr": descr, "fortran_order": False, "shape": shape}
        )
    return stream.getvalue()


def header(text: bytes) -> bytes:
    """An archive of an array with this header, and without values."""
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as packed:
        packed.writestr("a.npy", b"\x93NUMPY\x01\x00" + struct.pack("<H", len(text)) + text)
    return stream.getvalue()


def changed_glb(change: Callable[[dict[str, Any]], None]) -> bytes:
    data = write_attributes(GOOD, "glb", WrittenSurface.of(MESH, GOOD))
    (length,) = struct.unpack_from("<I", data, 12)
    tree = json.loads(data[20 : 20 + length])
    change(tree)
    text = json.dumps(tree).encode()
    text += b" " * (-len(text) % 4)
    rest = data[20 + length :]
    head = struct.pack("<4sIIII", b"glTF", 2, 20 + len(text) + len(rest), len(text), 0x4E4F534A)
    return head + text + rest


def accessor_of(tree: dict[str, Any], name: str) -> dict[str, Any]:
    index = tree["meshes"][0]["primitives"][0]["attributes"][name]
    found: dict[str, Any] = tree["accessors"][index]
    return found


HOSTILE: dict[str, tuple[str, bytes, str]] = {
    "no archive": ("npz", b"a,b\n1,2\n", "not an archive"),
    "pickle": ("npz", b"cos\nsystem\n(S'touch /tmp/owned'\ntR.", "not an archive"),
    "objects": ("npz", archive(a=np.array([{}, []], dtype=object)), "Python objects"),
    "columns of objects": (
        "npz",
        archive(a=np.array(["head"] * 300, dtype=object)),
        "'a.npy' has Python objects; save arrays",
    ),
    "no name": ("npz", archive(**{"": np.zeros(9)}), "has no name"),
    "surrogates": ("npz", archive(a=np.array(["\ud800"] * 9)), r"U\+D800, which is no character"),
    "beyond 64 bits": ("npz", archive(a=np.array([2**63], dtype=np.uint64)), "beyond 2"),
    "bomb": ("npz", bomb(), "too large when unpacked"),
    "vast": ("npz", vast((2**45,)), "promises more values"),
    "vast, overflowing": ("npz", vast((2**62, 2**62)), "promises more values"),
    "vast, of nothing": ("npz", vast((2**40,), "|S0"), "promises more values"),
    "too many values": (
        "npz",
        archive(a=np.zeros(2**26 + 1, np.uint8)),
        "more than 67108864 values",
    ),
    "codes that are no characters": (
        "npz",
        archive(a=np.full(3, 0xFFFFFFFF, np.uint32).view("<U1")),
        "'a' has text with codes that are no characters",
    ),
    "a header that is none": (
        "npz",
        header(b"{'descr': '<f8', 'fortran_order': False, 'shape': (9**9,)}"),
        "the header of 'a.npy' is damaged",
    ),
    "cut off": ("npz", archive(a=np.zeros(9))[:-40], "cannot be read"),
    "bytes that are no text": (
        "npz",
        archive(a=np.array([b"arm", b"\xff"])),
        "'a' is text that is not UTF-8",
    ),
    "complex": ("npz", archive(a=np.zeros(9, dtype=complex)), "give numbers"),
    "cube": ("npz", archive(a=np.zeros((9, 2, 2))), "has the shape"),
    "scalar": ("npz", archive(a=3.0), "has the shape"),
    "lengths": ("npz", archive(a=np.zeros(9), b=np.zeros(8)), "'a' has 9 rows, and 'b' has 8"),
    "nothing": ("npz", archive(), "no attributes"),
    "too wide": ("npz", archive(a=np.zeros((2, 2000))), "more than 1024"),
    "colours": ("npz", archive(colors=np.full((9, 3), 1.5)), "from 0 to 255"),
    "dark colours": ("npz", archive(colors=np.full((9, 3), -1)), "from 0 to 255"),
    "infinite colours": ("npz", archive(colors=np.full((9, 3), np.inf)), "from 0 to 255"),
    "negative joints": (
        "npz",
        archive(joints=np.full((9, 4), -1), weights=np.ones((9, 4))),
        "joint -1 does not exist",
    ),
    "huge joints": (
        "npz",
        archive(joints=np.full((9, 4), 2**60), weights=np.ones((9, 4))),
        "does not exist",
    ),
    "joints of another shape": (
        "npz",
        archive(joints=np.zeros((9, 3), dtype=int), weights=np.ones((9, 4))),
        "as many of each vertex",
    ),
    "names of joints": (
        "npz",
        archive(joint_names=np.array(["a", "a"]), weights=np.ones((9, 2))),
        "different name",
    ),
    "empty": ("csv", b"", "no rows"),
    "names alone": ("csv", b"a,b\n", "no rows"),
    "bytes": ("csv", b"\xff\xfe\x00a\n1\n", "UTF-8"),
    "text in numbers": ("csv", b"a\n1.5\n2.x\n", "row 1 is '2.x'"),
    "numbers in text": ("csv", b"a\nhead\n7\n", "row 1 is '7'"),
    "infinity in digits": ("csv", b"a\n1.5\n1e400\n", "infinite numbers.*row 1 is '1e400'"),
    "infinity": ("csv", b"a\n1.5\ninf\n", "row 1 is 'inf'"),
    "underscores": ("csv", b"a\n1.5\n1_0\n", "row 1 is '1_0'"),
    "gaps": ("csv", b"a,b\n ,1\n ,2\n", "'a' has no value in any row"),
    "infinite alone": ("csv", b"a\ninf\n-Infinity\n", "infinite numbers.*row 0 is 'inf'"),
    "infinite and none": ("csv", b'a\n""\ninf\n', "infinite numbers.*row 1 is 'inf'"),
    "text after a gap": ("csv", b"a,b\n,1\n2,1\nhead,1\n4,1\n", "row 2 is 'head'"),
    "a number after a gap": ("csv", b"a,b\n,1\nhead,1\narm,1\n4,1\n", "row 3 is '4'"),
    "semicolons": ("csv", b"a;b\n1,5;2,5\n", "separated by commas"),
    "tabs": ("csv", b"vertex\tseg\n0\thead\n", "separated by commas"),
    "index of pandas": ("csv", b",seg\n0,7\n", "no name.*call it vertex or face"),
    "ragged": ("csv", b"a,b\n1,2\n3\n", "row 1 has 1 values"),
    "twice": ("csv", b"a,a\n1,2\n", "different name"),
    "vertices": ("csv", b"vertex,a\n0,1\n0,2\n", "each number from 0 once"),
    "no quote": ("csv", b'a\n"1\n', "cannot be read"),
    "long name": ("csv", b"a" * 300 + b"\n1\n", "longer than 100"),
    "no ply": ("ply", b"solid", "not a PLY file"),
    "positions alone": (
        "ply",
        b"ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n1\n",
        "no attributes",
    ),
    "ply label that is none": (
        "ply",
        b"ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty int label\n"
        b"end_header\n0 1\n0 nan\n",
        "label of the PLY file is declared as integers, and has the value nan",
    ),
    "ply label between two": (
        "ply",
        b"ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty int label\n"
        b"end_header\n0 1\n0 2.7\n",
        "has the value 2.7",
    ),
    "ply label that is too large": (
        "ply",
        b"ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty int64 label\n"
        b"end_header\n0 99999999999999999999\n",
        "has the value 1e\\+20",
    ),
    "huge ply": (
        "ply",
        b"ply\nformat binary_little_endian 1.0\nelement vertex 99999999999999\n"
        b"property float a\nend_header\n",
        "promises",
    ),
    "no colours": ("obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "no attributes"),
    "no obj": ("obj", b"PK\x03\x04", "not an OBJ file"),
    "no glb": ("glb", b"glTF", "not a GLB file"),
    "beyond the buffer": (
        "glb",
        changed_glb(lambda tree: accessor_of(tree, "_a").update(count=10**6)),
        "glTF",
    ),
    "fewer values": (
        "glb",
        changed_glb(lambda tree: accessor_of(tree, "_a").update(count=ROWS - 1)),
        "value for every vertex",
    ),
    "few joints": (
        "glb",
        changed_glb(lambda tree: tree["skins"][0].update(joints=[1])),
        "joint 1 does not exist",
    ),
    "no weights": (
        "glb",
        changed_glb(lambda tree: tree["meshes"][0]["primitives"][0]["attributes"].pop("WEIGHTS_0")),
        "damaged",
    ),
    "vertices and faces": ("csv", b"vertex,face,a\n0,0,1\n", "leave out one of the two columns"),
    "faces": ("csv", b"face,a\n0,1\n2,2\n", "'face' must have each number from 0 once"),
    "an empty list": ("seg", b"\n \n", "is empty"),
    "a list of bytes": ("seg", b"\xff\xfe1\n", "UTF-8"),
    "a list of infinity": ("txt", b"1\ninf\n", "row 1 is 'inf'"),
    "two labels a line": ("seg", b"1 2\n3 4\n5\n", "both numbers and text"),
    "unknown": ("off", b"OFF", "no attributes that are read"),
}


@pytest.mark.parametrize("what", HOSTILE)
def test_files_are_refused_with_the_reason(what: str) -> None:
    file_type, data, message = HOSTILE[what]
    with pytest.raises(TransferError, match=message):
        read_attributes(data, file_type)


@given(st.sampled_from(ATTRIBUTE_FORMATS), st.binary(max_size=200))
def test_any_bytes_are_read_or_refused(file_type: str, data: bytes) -> None:
    try:
        found = read_attributes(data, file_type)
    except TransferError:
        return
    assert len({(one.on, len(one.values)) for one in found}) == len({one.on for one in found})


@given(st.sampled_from(ATTRIBUTE_FORMATS), st.data())
def test_damaged_files_are_read_or_refused(file_type: str, data: st.DataObject) -> None:
    attributes = GOOD if file_type != "obj" else GOOD[1:2]
    good = write_attributes(attributes, file_type, WrittenSurface.of(MESH, attributes))
    place = data.draw(st.integers(0, len(good) - 1))
    change = data.draw(st.binary(max_size=4))
    damaged = good[:place] + change + good[place + data.draw(st.integers(0, 40)) :]
    try:
        found = read_attributes(damaged, file_type)
    except TransferError:
        return
    assert len({(one.on, len(one.values)) for one in found}) == len({one.on for one in found})
