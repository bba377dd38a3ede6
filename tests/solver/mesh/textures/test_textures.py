"""Images, textures, and the colours they give to vertices: against closed forms."""

import io

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image

from solver.arrays import FloatArray, IntArray
from solver.errors import MeshError
from solver.mesh import triangle_areas
from solver.mesh.textures import (
    ImageBudget,
    Paint,
    Texture,
    Wrap,
    display_values,
    linear_light,
    painted_colors,
    tinted,
)
from tests.solver.mesh.textures.textured_files import grid, image_file, ramp


def painted(vertices: FloatArray, faces: IntArray, uv: FloatArray, texture: Texture) -> FloatArray:
    """Colours of vertices that carry texture coordinates."""
    number = np.zeros(len(faces), dtype=np.int64)
    return painted_colors(
        vertices, faces, Paint(uv[faces], np.zeros((len(faces), 3)), number, (texture,))
    )


# --- texture --------------------------------------------------------------------------------------


@pytest.mark.parametrize("wrap", Wrap)
def test_centres_of_texels_have_their_colours_and_between_them_it_is_linear(wrap: Wrap) -> None:
    pixels = np.random.default_rng(0).integers(0, 256, (5, 7, 3), dtype=np.uint8)
    texture = Texture(pixels, (wrap, wrap))
    row, column = (place.ravel() for place in np.mgrid[:5, :7])
    centres = np.stack([(column + 0.5) / 7, (row + 0.5) / 5], axis=1)
    np.testing.assert_allclose(texture.sample(centres), pixels[row, column] / 255.0, atol=1e-12)
    between = np.array([[2.25 / 7 + 0.5 / 7, 3.5 / 5]])
    expected = (0.75 * pixels[3, 2] + 0.25 * pixels[3, 3]) / 255.0
    np.testing.assert_allclose(texture.sample(between)[0], expected, atol=1e-12)


def test_beyond_the_border_the_image_is_repeated_mirrored_or_ends() -> None:
    texture = Texture(ramp(8, 8))
    inside = np.random.default_rng(1).uniform(0.1, 0.9, (50, 2))
    whole = np.random.default_rng(2).integers(-3, 4, (50, 2)) * 2
    np.testing.assert_allclose(texture.sample(inside + whole), texture.sample(inside), atol=1e-12)
    mirrored = Texture(texture.pixels, (Wrap.MIRROR, Wrap.MIRROR))
    np.testing.assert_allclose(mirrored.sample(-inside + whole), mirrored.sample(inside))
    clamped = Texture(texture.pixels, (Wrap.CLAMP, Wrap.CLAMP))
    corner = clamped.sample(np.array([[7.0, -2.0], [1.0, 0.0]]))
    np.testing.assert_array_equal(corner, np.array([[7 / 255, 0, 0], [7 / 255, 0, 0]]))
    # Across the border of a repeated image, the last texel is beside the first.
    seam = texture.sample(np.array([[0.0, 0.5 / 8]]))[0, 0]
    assert seam == pytest.approx(3.5 / 255)


def test_halved_images_are_means() -> None:
    pixels = np.random.default_rng(0).integers(0, 256, (32, 64, 3), dtype=np.uint8)
    texture = Texture(pixels)
    levels = [texture.level(number) for number in range(texture.last_level + 1)]
    assert [level.shape[:2] for level in levels] == [
        (32, 64), (16, 32), (8, 16), (4, 8), (2, 4), (1, 2), (1, 1)
    ]  # fmt: skip
    np.testing.assert_allclose(levels[-1][0, 0] / 257.0, pixels.mean(axis=(0, 1)), atol=0.01)
    odd = Texture(ramp(5, 3))
    assert odd.last_level == 3
    assert odd.level(1).shape[:2] == (2, 3)
    assert np.rint(odd.level(1)[0, :, 0] / 128.5).tolist() == [1, 5, 8]


def test_light_adds_up_as_the_standard_says() -> None:
    values = np.linspace(0.0, 1.0, 1001)
    np.testing.assert_allclose(display_values(linear_light(values)), values, atol=1e-9)
    assert (np.diff(linear_light(values)) > 0.0).all()
    assert linear_light(np.array([0.5]))[0] == pytest.approx(0.21404, abs=1e-5)
    np.testing.assert_array_equal(tinted(values[:, None], np.ones(3)), values[:, None])
    half = tinted(np.ones(3), np.array([1.0, 0.21586, 0.0]))
    np.testing.assert_allclose(half, [1.0, 128 / 255, 0.0], atol=1e-5)


# --- vertices -------------------------------------------------------------------------------------


@pytest.mark.parametrize("size", [32, 256, 1024])
def test_a_linear_ramp_gives_exact_values(size: int) -> None:
    """Inner vertices of a grid are in the middle of what they stand for."""
    vertices, faces = grid(10)
    pixels = (ramp(size, size) // max(size // 256, 1)).astype(np.uint8)
    if size > 256:
        pixels[..., 0], pixels[..., 1] = np.indices((size, size))[::-1] * 256 // size
    colors = painted(vertices, faces, vertices[:, :2], Texture(pixels))
    inner = ((vertices[:, :2] > 0.05) & (vertices[:, :2] < 0.95)).all(axis=1)
    texels = min(size, 256)
    expected = (vertices[inner, :2] * texels - 0.5) / 255.0
    # Halved images are rounded to 16 bits; the largest has a ramp of steps.
    tolerance = {32: 1e-9, 256: 1e-5, 1024: 1.0 / 255.0}[size]
    np.testing.assert_allclose(colors[inner, :2], expected, atol=tolerance)
    assert (colors[:, 2] == 0.0).all()


@pytest.mark.parametrize("cells", [1, 2, 4])
def test_a_fine_checkerboard_gives_its_mean(cells: int) -> None:
    board = (np.indices((512, 512)) // cells).sum(axis=0) % 2 * 255
    texture = Texture(np.repeat(board[:, :, None], 3, axis=2).astype(np.uint8))
    vertices, faces = grid(7, jitter=0.3)
    colors = painted(vertices, faces, vertices[:, :2], texture)
    np.testing.assert_allclose(colors, 0.5, atol=0.02)
    point = texture.sample(vertices[:, :2])
    assert point.std() > 0.05  # which looking up the vertices alone would not give


def test_colors_keep_the_integral_of_the_texture() -> None:
    vertices, faces = grid(9, jitter=0.4)
    pixels = np.random.default_rng(3).integers(0, 256, (16, 16, 3), dtype=np.uint8)
    texture = Texture(np.kron(pixels, np.ones((16, 16, 1), np.uint8)), (Wrap.CLAMP, Wrap.CLAMP))
    colors = painted(vertices, faces, vertices[:, :2], texture)
    areas = triangle_areas(vertices, faces)
    shares = np.bincount(faces.ravel(), np.repeat(areas / 3.0, 3))
    np.testing.assert_allclose(shares @ colors, pixels.mean(axis=(0, 1)) / 255.0, atol=3e-3)


def test_vertices_on_a_seam_take_both_sides_by_their_areas() -> None:
    vertices = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, -3, 0]])
    faces = np.array([[0, 1, 2], [0, 3, 1]])  # areas 1/2 and 3/2
    white, black = np.full((1, 1, 3), 255, np.uint8), np.zeros((1, 1, 3), np.uint8)
    paint = Paint(
        np.zeros((2, 3, 2)), np.zeros((2, 3)), np.array([0, 1]), (Texture(white), Texture(black))
    )
    colors = painted_colors(vertices, faces, paint)
    np.testing.assert_allclose(colors[:, 0], [0.25, 0.25, 1.0, 0.0])
    plain = Paint(np.zeros((2, 3, 2)), np.eye(3)[:2], np.array([-1, -1]), ())
    np.testing.assert_allclose(
        painted_colors(vertices, faces, plain)[0], [0.25, 0.75, 0.0], atol=1e-8
    )


def test_texture_coordinates_far_out_are_told_or_endured() -> None:
    vertices, faces = grid(2)
    texture = Texture(ramp(16, 16))
    assert np.isfinite(painted(vertices, faces, vertices[:, :2] * 1e300, texture)).all()
    with pytest.raises(MeshError, match="not a finite number"):
        painted(vertices, faces, vertices[:, :2] * np.nan, texture)


# --- images ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("file_type", ["PNG", "BMP", "WEBP"])
def test_images_come_back_exactly(file_type: str) -> None:
    pixels = ramp(20, 30)
    options = {"lossless": True, "exact": True} if file_type == "WEBP" else {}
    found = ImageBudget().decode(image_file(pixels, file_type, **options), "a")
    np.testing.assert_array_equal(found, pixels)


def saved(image: Image.Image, file_type: str = "PNG", **options: object) -> bytes:
    stream = io.BytesIO()
    image.save(stream, format=file_type, **options)
    return stream.getvalue()


def test_images_of_every_kind_become_red_green_and_blue() -> None:
    solid = Image.new("RGB", (8, 8), (200, 100, 50))
    palette = solid.quantize(4)
    kinds = {
        "palette": saved(palette),
        "transparent palette": saved(palette, transparency=b"\x00\xff"),
        "opacity": saved(Image.new("RGBA", (8, 8), (200, 100, 50, 3))),
        "CMYK": saved(solid.convert("CMYK"), "JPEG", quality=100),
        "YCbCr": saved(solid, "JPEG", quality=100),
    }
    for name, data in kinds.items():
        found = ImageBudget().decode(data, name)
        assert found.shape == (8, 8, 3)
        np.testing.assert_allclose(found, np.tile([200, 100, 50], (8, 8, 1)), atol=3, err_msg=name)
    grey = np.arange(0, 65536, 257, dtype=np.uint16).reshape(16, 16)
    deep = ImageBudget().decode(saved(Image.fromarray(grey)), "16 bits of grey")
    np.testing.assert_array_equal(deep, np.repeat((grey // 257)[:, :, None], 3, axis=2))
    bilevel = ImageBudget().decode(saved(Image.new("1", (3, 3), 1)), "one bit")
    assert (bilevel == 255).all()


def test_images_that_are_refused() -> None:
    frames = [Image.new("RGB", (4, 4), (shade, 0, 0)) for shade in (0, 200)]
    moving = saved(frames[0], save_all=True, append_images=frames[1:])
    bomb = saved(Image.new("1", (9000, 9000)))
    huge = saved(Image.new("1", (20_000, 20_000)))
    whole = image_file(ramp())
    for data, reason in (
        (moving, "animated"),
        (bomb, "too large"),
        (huge, "too large"),
        (whole[: len(whole) // 2], "damaged or cut off"),
        (b"GIF89a" + bytes(100), "not one of PNG, JPEG, WEBP, BMP"),
        (b"", "not one of"),
    ):
        with pytest.raises(MeshError, match=reason):
            ImageBudget().decode(data, "a.png")
    budget = ImageBudget(100 * 100)
    budget.decode(image_file(ramp(100, 60)), "first")
    with pytest.raises(MeshError, match="second is too large: all images"):
        budget.decode(image_file(ramp(100, 60)), "second")


IMAGES = {kind: image_file(ramp(24, 24), kind) for kind in ("PNG", "JPEG", "WEBP", "BMP")}


@settings(max_examples=200)
@given(
    st.sampled_from(sorted(IMAGES)),
    st.floats(0.0, 1.0),
    st.integers(0, 40),
    st.binary(max_size=12),
)
def test_damaged_images_are_decoded_or_refused(
    kind: str, place: float, removed: int, inserted: bytes
) -> None:
    data = IMAGES[kind]
    start = int(place * len(data))
    try:
        found = ImageBudget().decode(data[:start] + inserted + data[start + removed :], "a")
    except MeshError:
        return
    assert found.ndim == 3
    assert found.shape[2] == 3
