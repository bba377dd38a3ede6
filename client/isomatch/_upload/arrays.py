"""Validation of arrays before they are uploaded as a mesh."""

from typing import Any, Final

import numpy as np
import numpy.typing as npt

_MOST_VERTICES: Final = np.iinfo(np.int32).max
"""Vertices that the int32 indices of a PLY file can address."""


_UNIT: Final = 0.01
"""Tolerance of the length of a normal, as in text files that the service reads."""


def checked_arrays(
    vertices: npt.ArrayLike, faces: npt.ArrayLike
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.int32]]:
    """Return valid vertices (V, 3), float64, and faces (F, 3), int32.

    Raises
    ------
    ValueError
        An array has the wrong shape or type, a vertex index is out of range, or a coordinate of a
        vertex that is used is not finite.
    """
    given = _table("vertices", vertices)
    if not np.can_cast(given.dtype, np.float64, "same_kind"):
        raise ValueError(f"vertices must be real numbers, not {given.dtype}")
    points = given.astype(np.float64)
    if faces is None:
        raise ValueError("faces are missing; for a point cloud, give the points alone")
    triangles = _table("faces", faces)
    if not triangles.size:
        raise ValueError("faces must have at least one triangle")
    if not np.issubdtype(triangles.dtype, np.integer):
        raise ValueError(f"faces must be integers, not {triangles.dtype}; use faces.astype(int)")
    if len(points) > _MOST_VERTICES:
        raise ValueError(f"{len(points)} vertices exceed the limit of {_MOST_VERTICES}")
    wrong = (triangles < 0) | (triangles >= len(points))
    if wrong.any():
        row, column = np.argwhere(wrong)[0]
        raise ValueError(
            f"faces[{row}, {column}] is {triangles[row, column]}, but vertices count from 0 to "
            f"{len(points) - 1}"
        )
    # The service ignores unused vertices, whose coordinates may be NaN.
    used = np.zeros(len(points), dtype=bool)
    used[triangles] = True
    not_finite = used & ~np.isfinite(points).all(axis=1)
    if not_finite.any():
        row = int(np.argmax(not_finite))
        raise ValueError(f"vertices[{row}] is {points[row].tolist()}; coordinates must be finite")
    return points, triangles.astype(np.int32)


def checked_points(points: npt.ArrayLike) -> npt.NDArray[np.float64]:
    """Return the points of a cloud, (V, 3) or with normals (V, 6), float64.

    Raises
    ------
    ValueError
        The array has another shape, is not of real numbers, or has normals whose length is not 1.
        Normals of 0 or nan are missing ones.
    """
    table = np.asarray(points, dtype=np.float64)
    if table.ndim != 2 or table.shape[1] not in (3, 6):
        raise ValueError(f"points must have the shape (V, 3) or (V, 6), not {table.shape}")
    lengths = np.linalg.norm(table[:, 3:], axis=1)
    wrong = (lengths > 0.0) & (np.abs(lengths - 1.0) > _UNIT)
    if wrong.any():
        row = int(np.argmax(wrong))
        raise ValueError(
            f"points[{row}, 3:] is {table[row, 3:].tolist()}, but a normal has the length 1: divide"
            " normals by their lengths; give colours as (points, None, colors)"
        )
    return table


def checked_colors(colors: npt.ArrayLike, count: int) -> npt.NDArray[np.uint8]:
    """Return colours of `count` vertices as RGB, (V, 3) uint8.

    Raises
    ------
    ValueError
        Their number or range is wrong, or they are neither RGB nor RGBA.
    """
    given = np.asarray(colors)
    if given.ndim != 2 or given.shape[0] != count or given.shape[1] not in (3, 4):
        raise ValueError(
            f"colors must have the shape ({count}, 3) or ({count}, 4), not {given.shape}"
        )
    if np.issubdtype(given.dtype, np.floating):
        scale, most = 255.0, 1.0
    elif np.issubdtype(given.dtype, np.integer):
        scale, most = 1.0, 255
    else:
        raise ValueError(f"colors must be integers or floats, not {given.dtype}")
    rgb = given[:, :3]
    if rgb.size and not ((rgb >= 0) & (rgb <= most)).all():
        raise ValueError(f"colors of type {given.dtype} must be between 0 and {most}")
    return np.rint(rgb * scale).astype(np.uint8)


def _table(name: str, values: npt.ArrayLike) -> npt.NDArray[Any]:
    try:
        array = np.asarray(values)
    except ValueError as error:
        raise ValueError(f"{name} must be an array of the shape (n, 3): {error}") from error
    if array.ndim != 2 or array.shape[1] != 3:
        raise ValueError(f"{name} must have the shape (n, 3), not {array.shape}")
    return array
