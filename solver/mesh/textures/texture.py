"""Textures: images as functions of texture coordinates, interpolated bilinearly, with mipmaps."""

from dataclasses import dataclass
from enum import Enum
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from solver.arrays import FloatArray, IntArray
from solver.mesh.textures.images import Pixels

DeepPixels = npt.NDArray[np.uint16]


class Wrap(Enum):
    """Continuation of an image beyond its edge along an axis."""

    REPEAT = "repeat"
    MIRROR = "mirror"
    CLAMP = "clamp"


@dataclass(frozen=True, eq=False)
class Texture:
    """An image on the unit square.

    Parameters
    ----------
    pixels
        (height, width, 3) uint8, display values. Texel (row i, column j) has its centre at
        u = (j + 1/2) / width, v = (i + 1/2) / height: v runs downwards, from the first row on.
    wrap
        Along u and along v.
    """

    pixels: Pixels
    wrap: tuple[Wrap, Wrap] = (Wrap.REPEAT, Wrap.REPEAT)

    @property
    def size(self) -> tuple[int, int]:
        """Width and height in texels."""
        return self.pixels.shape[1], self.pixels.shape[0]

    @property
    def last_level(self) -> int:
        """Number of times that both sides can be halved, until one texel is left."""
        return (max(self.size) - 1).bit_length()

    def level(self, number: int) -> Pixels | DeepPixels:
        """Return the image with both sides halved so many times: means of 2 x 2 texels each time.

        Means have 16 bits, since rounding to 8 would brighten each level.
        """
        while len(self._levels) <= number:
            self._levels.append(_halved(self._levels[-1]))
        return self._levels[number]

    @cached_property
    def _levels(self) -> list[Pixels | DeepPixels]:
        return [self.pixels]

    def sample(self, coordinates: FloatArray, level: int = 0) -> FloatArray:
        """Interpolate bilinearly between the centres of texels.

        Parameters
        ----------
        coordinates
            (n, 2) finite u, v.
        level
            Mipmap level: sides of texels are ``2**level`` times longer. Levels beyond the last
            count as the last.

        Returns
        -------
        (n, 3) in 0..1.
        """
        level = min(level, self.last_level)
        pixels = self.level(level)
        columns, across = self._neighbours(coordinates[:, 0], 0, level)
        rows, down = self._neighbours(coordinates[:, 1], 1, level)
        found = np.zeros((len(coordinates), 3))
        for row, of_row in zip(rows, (1.0 - down, down), strict=True):
            for column, of_column in zip(columns, (1.0 - across, across), strict=True):
                found += (of_row * of_column)[:, None] * pixels[row, column]
        return found / np.iinfo(pixels.dtype).max

    def _neighbours(
        self, coordinate: FloatArray, axis: int, level: int
    ) -> tuple[tuple[IntArray, IntArray], FloatArray]:
        """Indices of the texels on both sides of points, and weights of the second."""
        wrap, size = self.wrap[axis], self.size[axis]
        count = self.level(level).shape[1 - axis]
        if wrap is Wrap.CLAMP:
            inside = np.clip(coordinate, 0.0, 1.0)
        elif wrap is Wrap.REPEAT:
            inside = coordinate % 1.0
        else:
            inside = 1.0 - np.abs(coordinate % 2.0 - 1.0)
        place = inside * size / 2.0**level - 0.5
        low = np.floor(place).astype(np.int64)
        share: FloatArray = place - low
        if wrap is Wrap.REPEAT:
            return (low % count, (low + 1) % count), share
        return (low.clip(0, count - 1), (low + 1).clip(0, count - 1)), share


def _halved(pixels: Pixels | DeepPixels) -> DeepPixels:
    """Means of 2 x 2 texels; an odd last row or column is doubled."""
    height, width = pixels.shape[:2]
    even: npt.NDArray[Any] = pixels
    if height % 2 or width % 2:
        even = np.pad(pixels, ((0, height % 2), (0, width % 2), (0, 0)), mode="edge")
    rows = np.add(even[0::2], even[1::2], dtype=np.uint32)
    if pixels.dtype == np.uint8:
        rows *= 257  # 255 is 65535 then
    halved: DeepPixels = np.empty((rows.shape[0], rows.shape[1] // 2, 3), dtype=np.uint16)
    for channel in range(3):  # one by one: NumPy is slow along an axis of length 3
        sums = rows[:, 0::2, channel] + rows[:, 1::2, channel]
        halved[..., channel] = (sums + 2) >> 2
    return halved
