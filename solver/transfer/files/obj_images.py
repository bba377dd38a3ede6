"""Images as material files of OBJ can use them: without tints, and with one wrap for both axes."""

from dataclasses import replace
from typing import Final

import numpy as np

from solver.arrays import FloatArray
from solver.errors import TransferError
from solver.mesh.textures import MOST_IMAGES, MOST_PIXELS, Paint, Pixels, Texture, Wrap, tinted

_LEVELS: Final = np.arange(256) / 255.0


def baked_for_obj(paint: Paint) -> Paint:
    """Bake into the images what a material file cannot say.

    An image is tinted for each factor of `light` that faces with it have. Where an axis is
    mirrored, the image is doubled along it. Where one axis alone is clamped, the image is continued
    along it as far as the coordinates go.

    Parameters
    ----------
    paint
        Any.

    Returns
    -------
    Paint
        Without `light`; each texture is repeated along both axes or clamped along both. What a
        face shows is the same, up to the rounding of colours to bytes.

    Raises
    ------
    TransferError
        The images would be too large or too many to be read again.
    """
    if not paint.textures:
        return paint
    light = np.ones_like(paint.colors) if paint.light is None else paint.light
    textured = np.flatnonzero(paint.texture_of_face >= 0)
    table = np.column_stack([paint.texture_of_face, light])[textured]
    kinds, kind = np.unique(table, axis=0, return_inverse=True)
    coordinates, numbers = paint.coordinates.copy(), paint.texture_of_face.copy()
    textures: list[Texture] = []
    for place, (number, *factors) in enumerate(kinds.tolist()):
        own = textured[kind.reshape(-1) == place]
        texture = paint.textures[int(number)]
        left = MOST_PIXELS - sum(one.pixels[..., 0].size for one in textures)
        if len(textures) >= MOST_IMAGES:
            raise _too_large()
        wrapped, coordinates[own] = _with_one_wrap(texture, paint.coordinates[own], left)
        textures.append(replace(wrapped, pixels=_tinted(wrapped.pixels, factors)))
        numbers[own] = place
    return replace(
        paint,
        coordinates=coordinates,
        texture_of_face=numbers,
        textures=tuple(textures),
        light=None,
    )


def _tinted(pixels: Pixels, factors: list[float]) -> Pixels:
    if all(factor == 1.0 for factor in factors):
        return pixels
    shown = tinted(np.repeat(_LEVELS[:, None], 3, axis=1), np.array(factors))
    table = np.rint(255.0 * shown).astype(np.uint8)
    channels = [table[:, channel][pixels[..., channel]] for channel in range(3)]
    return np.stack(channels, axis=2)


def _with_one_wrap(
    texture: Texture, coordinates: FloatArray, most: int
) -> tuple[Texture, FloatArray]:
    """Return a texture that is repeated or clamped, and the coordinates of (n, 3, 2) on it."""
    clamped = texture.wrap == (Wrap.CLAMP, Wrap.CLAMP)
    found, placed = texture.pixels, coordinates
    for axis, wrap in enumerate(texture.wrap):
        # Texels to be added before and after the image.
        before, after, size = 0.0, 0.0, texture.size[axis]
        if wrap is Wrap.MIRROR:
            after = size
        elif wrap is Wrap.CLAMP and not clamped:
            # One more, as texels are interpolated.
            before = max(np.ceil(-size * coordinates[..., axis].min()), 0.0) + 1.0
            after = max(np.ceil(size * (coordinates[..., axis].max() - 1.0)), 0.0) + 1.0
        if before + after == 0.0:
            continue
        total = size + before + after
        if total * found.shape[axis] > most:
            raise _too_large()
        added = [(0, 0), (0, 0), (0, 0)]
        added[1 - axis] = int(before), int(after)
        found = np.pad(found, added, mode="symmetric" if wrap is Wrap.MIRROR else "edge")
        placed = placed.copy()
        placed[..., axis] = (placed[..., axis] * size + before) / total
    wrap = Wrap.CLAMP if clamped else Wrap.REPEAT
    return Texture(found, (wrap, wrap)), placed


def _too_large() -> TransferError:
    return TransferError(
        "the images for OBJ are too large, as tints and wraps of the source become part of them;"
        " choose GLB"
    )
