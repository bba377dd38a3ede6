"""Image files as arrays of red, green and blue, decoded under limits.

PNG, JPEG, WebP and BMP are read. Files are not trusted: sizes are checked before anything is
decoded, and every exception of a decoder becomes a `MeshError`.
"""

import io
import re
import warnings
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from solver.errors import MeshError

Pixels = npt.NDArray[np.uint8]

MOST_PIXELS = 8192 * 8192
"""Pixels of all images of a shape: 192 MiB, twice that while one is decoded."""

MOST_IMAGES = 1000
"""Images of a shape."""

_MOST_BYTES = 512 * 2**20
"""Bytes of all image files of a shape; several may be the same part of a file."""

_MOST_SCANS = 24
"""Scans of a JPEG file: each may be a few bytes and goes over all pixels. Programs write ten."""

_FORMATS = ("PNG", "JPEG", "WEBP", "BMP")

_MARKER = re.compile(rb"\xff[^\x00\xff]")
_SCAN, _END = 0xDA, 0xD9
_ALONE = frozenset({0x01, *range(0xD0, 0xDA)})
"""Markers of JPEG without a segment, such as those within the data of a scan."""


@dataclass
class ImageBudget:
    """Limits of what may still be decoded.

    Parameters
    ----------
    pixels, images, octets
        Pixels, files, and bytes of files left.
    """

    pixels: int = MOST_PIXELS
    images: int = MOST_IMAGES
    octets: int = _MOST_BYTES

    def decode(self, data: bytes, name: str) -> Pixels:
        """Decode an image file.

        Parameters
        ----------
        data
            Bytes of the file.
        name
            Its name in messages.

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

        self._spend_file(len(data))
        with warnings.catch_warnings():
            # The decoder warns of sizes, which are checked here, or of damage.
            warnings.simplefilter("error")
            try:
                with Image.open(io.BytesIO(data), formats=_FORMATS) as image:
                    self._spend(image.size, name)
                    if image.format == "JPEG" and _scans(data) > _MOST_SCANS:
                        raise MeshError(
                            f"the image {name} has more than {_MOST_SCANS} scans; save it again, "
                            "as a JPEG that is not progressive"
                        )
                    if getattr(image, "n_frames", 1) > 1:
                        raise MeshError(f"the image {name} is animated; save a single frame")
                    return _red_green_blue(image)
            except (MeshError, MemoryError):
                raise
            except UnidentifiedImageError:
                raise MeshError(
                    f"the image {name} is damaged or not one of {', '.join(_FORMATS)}"
                ) from None
            except (Image.DecompressionBombError, Image.DecompressionBombWarning):
                raise _too_large(name) from None
            except Exception as error:  # decoders let any exception through for a damaged file
                reason = f"{type(error).__name__}: {error}".rstrip(": ")[:200]
                raise MeshError(
                    f"the image {name} cannot be decoded; it is damaged or cut off ({reason})"
                ) from error

    def _spend_file(self, size: int) -> None:
        self.images -= 1
        self.octets -= size
        if self.images < 0 or self.octets < 0:
            raise MeshError(
                f"the shape has more than {MOST_IMAGES} images, or more than "
                f"{_MOST_BYTES >> 20} MiB of them; save it with fewer"
            )

    def _spend(self, size: tuple[int, int], name: str) -> None:
        self.pixels -= size[0] * size[1]
        if self.pixels < 0:
            raise _too_large(name)


def _scans(data: bytes) -> int:
    """Number of scans of a JPEG file, to which the time for decoding is proportional."""
    scans, place = 0, 2
    while (found := _MARKER.search(data, place)) is not None:
        code, place = found.group()[-1], found.end()
        if code == _END:
            break
        if code == _SCAN:
            scans += 1
        if code not in _ALONE:
            place += int.from_bytes(data[place : place + 2])
    return scans


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
    if image.mode in ("P", "PA", "LA"):  # opacity in a palette is converted to RGB by way of RGBA
        image = image.convert("RGBA")
    pixels: Pixels = np.array(image.convert("RGB"), dtype=np.uint8)
    return pixels
