"""Image files as arrays of red, green and blue, decoded under limits.

PNG, JPEG, WebP and BMP are read. Their contents are somebody else's: sizes are checked before
anything is decoded, and whatever a decoder does not like is a `MeshError`.
"""

import io
import warnings
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from solver.errors import MeshError

Pixels = npt.NDArray[np.uint8]

MOST_PIXELS = 8192 * 8192
"""Of all images of a shape together: 192 MiB, and once more while one is decoded."""

_FORMATS = ("PNG", "JPEG", "WEBP", "BMP")


@dataclass
class ImageBudget:
    """How many pixels may be decoded yet.

    Parameters
    ----------
    pixels
        What is left.
    """

    pixels: int = MOST_PIXELS

    def decode(self, data: bytes, name: str) -> Pixels:
        """Decode an image file.

        Parameters
        ----------
        data
            Bytes of the file.
        name
            What messages call it.

        Returns
        -------
        (height, width, 3) uint8, the first row at the top. Grey values become three equal ones,
        opacity is left out, 16 bits are rounded to 8, CMYK is converted without colour profiles.

        Raises
        ------
        MeshError
            The file is cut off, damaged, animated, of another format, or too large.
        """
        # Imported here: most meshes have no images.
        from PIL import Image, UnidentifiedImageError

        with warnings.catch_warnings():
            # Warnings of the decoder are about sizes, which are checked here, or about damage.
            warnings.simplefilter("error")
            try:
                with Image.open(io.BytesIO(data), formats=_FORMATS) as image:
                    self._spend(image.size, name)
                    if getattr(image, "n_frames", 1) > 1:
                        raise MeshError(f"the image {name} is animated; save one picture of it")
                    return _red_green_blue(image)
            except (MeshError, MemoryError):
                raise
            except UnidentifiedImageError:
                raise MeshError(
                    f"the image {name} is none of {', '.join(_FORMATS)}, or it is damaged"
                ) from None
            except (Image.DecompressionBombError, Image.DecompressionBombWarning):
                raise _too_large(name) from None
            except Exception as error:  # decoders let any exception through for a damaged file
                reason = f"{type(error).__name__}: {error}".rstrip(": ")[:200]
                raise MeshError(
                    f"the image {name} cannot be decoded; it is damaged or cut off ({reason})"
                ) from error

    def _spend(self, size: tuple[int, int], name: str) -> None:
        self.pixels -= size[0] * size[1]
        if self.pixels < 0:
            raise _too_large(name)


def _too_large(name: str) -> MeshError:
    return MeshError(
        f"the image {name} is too large: all images of a shape may have {MOST_PIXELS // 2**20} "
        "million pixels; save it smaller"
    )


def _red_green_blue(image: Any) -> Pixels:
    if image.mode.startswith("I"):  # 16 bits of grey, which the decoder would clip at 255
        grey = np.asarray(image, dtype=np.float64) * (255.0 / 65535.0)
        levels = np.clip(np.rint(grey), 0.0, 255.0).astype(np.uint8)
        return np.repeat(levels[:, :, None], 3, axis=2)
    if image.mode in ("P", "PA", "LA"):  # opacity in a palette has no way to RGB but over RGBA
        image = image.convert("RGBA")
    pixels: Pixels = np.array(image.convert("RGB"), dtype=np.uint8)
    return pixels
