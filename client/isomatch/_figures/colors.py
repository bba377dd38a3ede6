"""Colours by position: neighbouring points of a surface have similar colours."""

from typing import Final, TypeAlias

import numpy as np
import numpy.typing as npt

Floats: TypeAlias = npt.NDArray[np.float64]
Indices: TypeAlias = npt.NDArray[np.int64]

COLOR_SCALE: Final = "Viridis"
"""Colour scale of matrices, the same in pictures of the service and on its page."""

MUTED: Final = "#6b7280"
"""Colour of captions and of lines without a value."""

_DARKEST: Final = 0.08
_RANGE: Final = 0.84
"""Channels of point colours lie between 0.08 and 0.92: neither black nor white."""

_WHITENING: Final = 0.4
"""Share of white in colours of surfaces, so that points stand out from them."""


def position_colors(points: Floats, vertices: Floats) -> Floats:
    """Colour points by their position in the bounding box of a shape.

    Parameters
    ----------
    points
        (n, 3).
    vertices
        (V, 3) vertices of the shape.

    Returns
    -------
    (n, 3) red, green and blue between 0 and 1.
    """
    if not len(points):
        return np.zeros((0, 3))
    lowest, size = vertices.min(axis=0), np.ptp(vertices, axis=0)
    shares = np.clip((points - lowest) / np.where(size > 0.0, size, 1.0), 0.0, 1.0)
    colors: Floats = _DARKEST + _RANGE * shares
    return colors


def surface_colors(vertices: Floats) -> Floats:
    """Colours of a surface's vertices, (V, 3): :func:`position_colors`, paler."""
    pale: Floats = _WHITENING + (1.0 - _WHITENING) * position_colors(vertices, vertices)
    return pale


def to_hex(colors: Floats) -> list[str]:
    """Colours between 0 and 1, (n, 3), as ``#rrggbb``."""
    rgb = np.rint(255.0 * colors).astype(np.uint8)
    return ["#" + row.tobytes().hex() for row in rgb]
