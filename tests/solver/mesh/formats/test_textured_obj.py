"""Textured OBJ with its companions in an archive: colours of vertices, or a refusal, or a word."""

import io
import struct
import time
import zipfile

import numpy as np
import pytest

from solver.errors import MeshError
from solver.mesh import read_mesh
from tests.solver.mesh.formats.painted_square import (
    FACES,
    INNER,
    OBJ,
    RAMP,
    UV,
    VERTICES,
    colors_of,
    on_ramp,
)
from tests.solver.mesh.textures.textured_files import (
    MTL,
    image_file,
    textured_glb,
    textured_obj,
    zipped,
    zipped_obj,
)


def test_obj_with_its_materials_has_v_upwards_and_keeps_its_numbers() -> None:
    order = np.random.default_rng(0).permutation(len(VERTICES))
    vertices = np.empty_like(VERTICES)
    vertices[order] = VERTICES
    mesh = read_mesh(zipped_obj(vertices, order[FACES], vertices[:, :2], RAMP), "zip")
    np.testing.assert_array_equal(mesh.vertices, vertices)
    np.testing.assert_array_equal(mesh.vertex_ids, np.arange(len(vertices)))
    assert mesh.warnings == ()
    uv = np.stack([vertices[:, 0], 1.0 - vertices[:, 1]], axis=1)
    inner = INNER[np.argsort(order)]
    np.testing.assert_allclose(colors_of(mesh)[inner, :2], on_ramp(uv[inner]), atol=1e-5)


def test_a_material_file_that_is_named_thousands_of_times_is_read_once() -> None:
    """Read as often as it is named, it would keep a worker busy for minutes."""
    text = b"mtllib m.mtl\n" * 5000 + b"mtllib " + b"m.mtl ./m.mtl " * 5000 + b"\n"
    text += b"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nusemtl a\nf 1 2 3\nusemtl b7\nf 1 2 4\n"
    others = b"".join(b"newmtl b%d\nKd 0 0 1\n" % number for number in range(2000))
    data = zipped({"a.obj": text, "m.mtl": b"newmtl a\nKd 1 0 0\n" + others})
    started = time.thread_time()
    mesh = read_mesh(data, "zip")
    assert time.thread_time() - started < 10.0
    np.testing.assert_allclose(colors_of(mesh)[[2, 3]], [[1, 0, 0], [0, 0, 1]])


def test_obj_and_glb_of_the_same_shape_have_the_same_colors() -> None:
    pixels = np.random.default_rng(5).integers(0, 256, (64, 64, 3), dtype=np.uint8)
    data = image_file(pixels)
    upwards = np.stack([UV[:, 0], 1.0 - UV[:, 1]], axis=1)
    glb = read_mesh(textured_glb(VERTICES, FACES, UV, data), "glb")
    obj = read_mesh(zipped_obj(VERTICES, FACES, upwards, data), "zip")
    np.testing.assert_allclose(colors_of(glb), colors_of(obj), atol=1e-5)


def test_obj_polygons_seams_and_several_materials() -> None:
    """A cube's side of two quadrilaterals, each of its own material; coordinates from the end."""
    obj = b"""mtllib  two materials.mtl
v 0 0 0\nv 1 0 0\nv 2 0 0\nv 0 1 0\nv 1 1 0\nv 2 1 0
vt 0.25 0.75\nvt 0.75 0.25
usemtl red
f 1/1 2/1/7 5/1 4/1
usemtl map
f -5/-1 -4/-1 -1/-1 -2/-1
"""
    pixels = np.zeros((2, 2, 3), np.uint8)
    pixels[1, 1] = 0, 0, 255  # at u = v = 3/4 downwards: v = 1/4 upwards
    mtl = b"newmtl red\nKd 1 0 0\nnewmtl map\nKd 0 0 0\nmap_Kd -clamp on -s 1 1 1 maps\\a b.png\n"
    files = {"x/two materials.mtl": mtl, "x/maps/a b.png": image_file(pixels), "x/y.obj": obj}
    mesh = read_mesh(zipped(files | {"__MACOSX/x/._y.obj": b"\0", "x/readme.txt": b""}), "zip")
    assert mesh.n_faces == 4
    colors = colors_of(mesh)
    np.testing.assert_allclose(colors[[0, 3]], np.tile([1, 0, 0], (2, 1)))
    np.testing.assert_allclose(colors[[2, 5]], np.tile([0, 0, 1], (2, 1)), atol=1e-9)
    assert ((colors[[1, 4], 0] > 0.2) & (colors[[1, 4], 2] > 0.2)).all()


def test_obj_colors_of_materials_alone() -> None:
    obj = textured_obj(VERTICES[:, :3], FACES, UV).replace(b"usemtl skin\n", b"usemtl a\n")
    lines = obj.split(b"\n")
    lines.insert(len(lines) - 20, b"usemtl b")
    two = b"newmtl a\nKd 1 0.5 0\nnewmtl b\nKd 0 0.25 1\n"
    mesh = read_mesh(zipped({"a.obj": b"\n".join(lines), "skin.mtl": two}), "zip")
    np.testing.assert_allclose(colors_of(mesh)[0], [1.0, 0.5, 0.0])
    one = read_mesh(zipped({"a.obj": obj, "skin.mtl": two}), "zip")
    assert one.colors is None  # one colour all over says nothing


def test_an_obj_alone_says_what_did_not_come() -> None:
    mesh = read_mesh(textured_obj(VERTICES, FACES, UV), "obj")
    assert mesh.colors is None
    assert len(mesh.warnings) == 1
    for word in ("skin.mtl", "is missing", ".zip"):
        assert word in mesh.warnings[0]


def encrypted() -> bytes:
    data = bytearray(zipped({"skin.obj": OBJ}, zipfile.ZIP_STORED))
    data[data.index(b"PK\1\2") + 8] |= 1
    data[6] |= 1
    return bytes(data)


def lying(size: int) -> bytes:
    """An archive whose directory promises a file of that size."""
    data = bytearray(zipped({"skin.obj": OBJ}))
    start = data.index(b"PK\1\2")
    struct.pack_into("<I", data, start + 24, size)
    return bytes(data)


@pytest.mark.parametrize(
    ("data", "reason"),
    [
        (zipped({"a.txt": b"x"}), "no mesh file; one ending in .off, .obj"),
        (zipped({}), "no mesh file"),
        (zipped({"a.obj": OBJ, "b/c.OBJ": OBJ}), r"2 mesh files \(a.obj, b/c.OBJ\)"),
        (zipped({"skin.obj": OBJ}), "material file 'skin.mtl', which is not in the archive"),
        (zipped({"skin.obj": OBJ, "skin.mtl": MTL}), "image 'skin.png', which is not in the"),
        (
            zipped({"skin.obj": OBJ, "skin.mtl": MTL, "skin.png": RAMP[:300]}),
            "image skin.png cannot be decoded",
        ),
        (
            zipped({"skin.obj": OBJ, "skin.mtl": b"newmtl skin\nKd red\n"}),
            "Kd in the material file cannot be read",
        ),
        (zipped({"../skin.obj": OBJ}), "leads out of the archive"),
        (zipped({"/skin.obj": OBJ}), "leads out of the archive"),
        (zipped({"a\\..\\..\\skin.obj": OBJ}), "leads out of the archive"),
        (zipped({f"{n}.txt": b"" for n in range(1001)}), "more than 1000 files"),
        (encrypted(), "encrypted"),
        (lying(10), "damaged"),
        (lying(2**31), "larger than 8 MiB when unpacked, which is far too much"),
        (b"PK\3\4", "not a ZIP archive"),
        (zipped({"skin.obj": OBJ})[:-30], "not a ZIP archive"),
    ],
    ids=range(16),
)
def test_archives_that_are_refused(data: bytes, reason: str) -> None:
    with pytest.raises(MeshError, match=reason):
        read_mesh(data, "zip")


@pytest.mark.parametrize(
    ("stored", "referred"),
    [
        ("images\\skin.png", "images/skin.png"),
        ("images\\skin.png", "images\\skin.png"),
        ("a%20b.png", "a%20b.png"),
        ("a b.png", "a%20b.png"),
        ("haut/u\u0308ber.png", "haut/\u00fcber.png"),
        ("haut/\u00fcber.png", "elsewhere/U\u0308BER.PNG"),
    ],
)
def test_files_are_found_however_their_names_are_written(stored: str, referred: str) -> None:
    mtl = f"newmtl skin\nmap_Kd {referred}\n".encode()
    data = zipped({"x\\skin.obj": OBJ, "x\\skin.mtl": mtl, f"x\\{stored}": RAMP})
    expected = read_mesh(zipped({"skin.obj": OBJ, "skin.mtl": MTL, "skin.png": RAMP}), "zip")
    found = read_mesh(data, "zip")
    assert found.colors is not None
    assert expected.colors is not None
    np.testing.assert_array_equal(found.colors, expected.colors)


def test_names_in_utf8_that_are_not_declared_so() -> None:
    mtl = "newmtl skin\nmap_Kd h\u00e4ut.png\n".encode()
    data = zipped({"skin.obj": OBJ, "skin.mtl": mtl, "h\u00e4ut.png": RAMP})
    for flag_bits, signature in ((8, b"PK\1\2"), (6, b"PK\3\4")):
        at = data.rfind(signature) + flag_bits
        flags = int.from_bytes(data[at : at + 2], "little") & ~0x800
        data = data[:at] + flags.to_bytes(2, "little") + data[at + 2 :]
    assert read_mesh(data, "zip").colors is not None


def test_members_without_a_name_are_ignored() -> None:
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as archive:
        archive.writestr("plain.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
        archive.writestr(zipfile.ZipInfo(""), b"x")
        archive.writestr("folder\\", b"")
    assert read_mesh(stream.getvalue(), "zip").n_faces == 1


def test_a_face_that_names_no_texture_coordinate() -> None:
    for bad in (b"f 1/900 2/1 3/1\n", b"f 1/0 2/1 3/1\n", b"f 1/x 2/1 3/1\n", b"vt 1 a\n"):
        files = {"skin.obj": OBJ + bad, "skin.mtl": MTL, "skin.png": RAMP}
        with pytest.raises(MeshError, match=r"texture coordinate|face line"):
            read_mesh(zipped(files), "zip")
    # Faces without any are of the material's colour.
    files = {"skin.obj": OBJ + b"f 1 2 3\n", "skin.mtl": MTL, "skin.png": RAMP}
    assert read_mesh(zipped(files), "zip").colors is not None
