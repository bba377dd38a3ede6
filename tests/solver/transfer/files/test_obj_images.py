"""Images in a zip with OBJ show what the source shows: tints and wraps are part of them."""

import io
import zipfile
from dataclasses import replace

import numpy as np
import pytest

from solver.arrays import FloatArray
from solver.errors import TransferError
from solver.mesh import read_mesh, textured_surface, triangle_mesh
from solver.mesh.textures import Material, Paint, Texture, Wrap
from solver.transfer.files import WrittenSurface, obj_images, write_obj_archive, write_textured_glb

CORNERS = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
MESH = triangle_mesh(CORNERS, np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]))
WRAPS = [(one, other) for one in Wrap for other in Wrap]
PIXELS = np.random.default_rng(5).integers(0, 256, size=(8, 12, 3), dtype=np.uint8)
LIGHT = np.array([[1.0, 0.2, 0.0], [1.0, 0.2, 0.0], [1.0, 1.0, 1.0], [0.5, 0.5, 0.5]])


def paint_of(wrap: tuple[Wrap, Wrap], light: bool = False) -> Paint:
    coordinates = np.random.default_rng(7).uniform(-1.7, 2.6, size=(4, 3, 2))
    texture = Texture(PIXELS, wrap)
    number = np.zeros(4, dtype=np.int64)
    return Paint(coordinates, np.ones((4, 3)), number, (texture,), LIGHT if light else None)


def archive(paint: Paint) -> bytes:
    return write_obj_archive(WrittenSurface.of(MESH, [], "t"), paint)


def samples(paint: Paint) -> list[FloatArray]:
    """Colours at random points of each triangle."""
    shares = np.random.default_rng(9).dirichlet(np.ones(3), size=50)
    return [
        paint.textures[number].sample(shares @ coordinates)
        for number, coordinates in zip(paint.texture_of_face, paint.coordinates, strict=True)
    ]


@pytest.mark.parametrize("wrap", WRAPS)
def test_images_continue_beyond_their_edges_as_those_of_the_source(wrap: tuple[Wrap, Wrap]) -> None:
    paint = paint_of(wrap)
    read = textured_surface(archive(paint), "zip")
    assert read is not None
    np.testing.assert_allclose(samples(read[1]), samples(paint), atol=1e-9)


@pytest.mark.parametrize("wrap", [(Wrap.REPEAT, Wrap.REPEAT), (Wrap.MIRROR, Wrap.CLAMP)])
def test_tints_are_those_of_glb(wrap: tuple[Wrap, Wrap]) -> None:
    plain = Texture(np.full_like(PIXELS, [200, 120, 40]), wrap)
    paint = replace(paint_of(wrap, light=True), textures=(plain,))
    found = read_mesh(archive(paint), "zip").colors
    expected = read_mesh(write_textured_glb("t", MESH, paint), "glb").colors
    assert found is not None
    assert expected is not None
    np.testing.assert_allclose(found, expected, atol=0.003)


def test_an_image_without_tint_is_written_as_it_is() -> None:
    with zipfile.ZipFile(io.BytesIO(archive(paint_of((Wrap.CLAMP, Wrap.CLAMP))))) as packed:
        assert packed.namelist() == ["texture0.png", "t.mtl", "t.obj"]
        assert b"map_Kd -clamp on texture0.png" in packed.read("t.mtl")
    with zipfile.ZipFile(io.BytesIO(archive(paint_of((Wrap.REPEAT, Wrap.REPEAT), True)))) as packed:
        names = [f"texture{number}.png" for number in range(3)]
        assert packed.namelist() == [*names, "t.mtl", "t.obj"]


@pytest.mark.parametrize("limit", ["MOST_PIXELS", "MOST_IMAGES"])
def test_images_that_become_too_large_are_refused(
    limit: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    paint = paint_of((Wrap.MIRROR, Wrap.REPEAT), light=True)
    monkeypatch.setattr(obj_images, limit, {"MOST_PIXELS": 8 * 24 * 2, "MOST_IMAGES": 2}[limit])
    with pytest.raises(TransferError, match=r"too large.*choose GLB"):
        archive(paint)


def test_coordinates_without_images_stay() -> None:
    paint = paint_of((Wrap.MIRROR, Wrap.CLAMP))
    bare = Paint(paint.coordinates, paint.colors, paint.texture_of_face, ())
    assert obj_images.baked_for_obj(bare) is bare


def test_materials_keep_their_names_and_share_an_image() -> None:
    materials = (Material("left arm"), Material("gold", 1.0, 0.25), Material("left arm", 0.5))
    paint = replace(
        paint_of((Wrap.REPEAT, Wrap.REPEAT)),
        material_of_face=np.array([2, 0, 1, -1]),
        materials=materials,
    )
    with zipfile.ZipFile(io.BytesIO(archive(paint))) as packed:
        assert packed.namelist() == ["texture0.png", "t.mtl", "t.obj"]
        library, text = packed.read("t.mtl").decode(), packed.read("t.obj").decode()
    names = ["texture0", "left_arm", "gold", "left_arm_3"]
    assert [line for line in library.split("\n") if "newmtl" in line] == [
        f"newmtl {name}" for name in names
    ]
    assert "newmtl gold\nKd 1 1 1\nPr 0.25\nPm 1\nmap_Kd texture0.png" in library
    assert [line for line in text.split("\n") if "usemtl" in line] == [
        f"usemtl {name}" for name in names
    ]
    read = textured_surface(archive(paint), "zip")
    assert read is not None
    assert read[1].material_of_face is not None
    known = [read[1].materials[place].name for place in read[1].material_of_face.tolist()]
    assert known == names
