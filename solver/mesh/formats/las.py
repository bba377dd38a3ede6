"""Point clouds of laser scanners: LAS, and LAZ, which is compressed."""

import io
from typing import Any, Final

import laspy
import numpy as np
from lazrs import LazrsError

from solver.arrays import FloatArray
from solver.errors import MeshError
from solver.mesh.repair import TriangleSoup

_MOST_BYTES: Final = 512 * 2**20
"""Bytes of all points, uncompressed; a damaged header promises more."""

_NORMALS: Final = ("normalx", "normaly", "normalz"), ("nx", "ny", "nz")
"""Names of the extra dimensions that programs write normals to, in lower case."""

_CHANNELS: Final = ("red", "green", "blue")

_BYTE, _WORD = 255.0, 65535.0
"""Greatest values of colours: of bytes, which many programs write, and as the standard has it."""


def read_las(data: bytes) -> TriangleSoup:
    """Read a point cloud from LAS 1.2 to 1.4 or LAZ.

    Parameters
    ----------
    data
        Bytes of the file.

    Returns
    -------
    TriangleSoup
        Without faces, in the units of the file: scales and offsets are applied. With colours, and
        with normals if it has extra dimensions of that name.

    Raises
    ------
    MeshError
        The bytes are not a complete LAS or LAZ file, or it has no points or too many.
    """
    try:
        with laspy.open(io.BytesIO(data)) as reader:
            promised, size = reader.header.point_count, reader.header.point_format.size
            if promised * size > _MOST_BYTES:
                raise MeshError(
                    f"the file promises {promised} points, more than the"
                    f" {_MOST_BYTES // size} that are read; thin them out"
                )
            points: Any = reader.read()
            places = np.ascontiguousarray(points.xyz, dtype=np.float64)
    except (laspy.LaspyException, LazrsError, ValueError, OverflowError) as error:
        raise MeshError(f"not a LAS file, or a damaged one: {error}") from error
    if len(places) != promised:
        raise MeshError(
            f"the file promises {promised} points and has {len(places)}; it is cut off or damaged"
        )
    if not promised:
        raise MeshError("the file has no points")
    return TriangleSoup(
        places,
        np.zeros((0, 3), dtype=np.int64),
        _colors(points),
        np.arange(promised, dtype=np.int64),
        None,
        normals=_normals(points),
        is_cloud=True,
    )


def _colors(points: Any) -> FloatArray | None:
    if not set(_CHANNELS) <= set(points.point_format.dimension_names):
        return None
    table = np.stack([np.asarray(points[name], dtype=np.float64) for name in _CHANNELS], axis=1)
    if not table.any():  # formats with colours are used for points that have none
        return None
    return table / (_BYTE if table.max() <= _BYTE else _WORD)


def _normals(points: Any) -> FloatArray | None:
    names = {name.lower(): name for name in points.point_format.extra_dimension_names}
    for axes in _NORMALS:
        if set(axes) <= set(names):
            columns = [np.asarray(points[names[axis]], dtype=np.float64) for axis in axes]
            return np.stack(columns, axis=1)
    return None
