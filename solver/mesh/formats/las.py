"""Point clouds of laser scanners: LAS, and LAZ, which is compressed."""

import io
import struct
from typing import Any, Final

import laspy
import numpy as np
from lazrs import LazrsError

from solver.arrays import FloatArray
from solver.errors import MeshError
from solver.mesh.repair import TriangleSoup

_MOST_BYTES: Final = 512 * 2**20
"""Bytes of all points, uncompressed; a damaged header promises more."""

_RECORDS: Final = struct.Struct("<25xB68xHxxxxI"), struct.Struct("<235xQI")
"""Minor version, size of the header and number of records; start and number of the extended ones.
"""

_LEAST_BYTES: Final = 54, 60
"""Bytes of a record without data, and of an extended one."""

_COMPRESSED: Final = struct.Struct("<96xI4xB")
"""Start of the points, and their format, whose highest two bits are 10 if they are compressed."""

_LEAST_POINT: Final = 20
"""Bytes of the smallest record of a point, with which every chunk of LAZ begins."""

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
    _check_records(data)
    _check_chunks(data)
    try:
        # The parallel reader panics, or aborts the process, where sizes of chunks are damaged.
        with laspy.open(io.BytesIO(data), laz_backend=laspy.LazBackend.Lazrs) as reader:
            promised, size = reader.header.point_count, reader.header.point_format.size
            if promised * size > _MOST_BYTES:
                raise MeshError(
                    f"the file promises {promised} points, more than the"
                    f" {_MOST_BYTES // size} that are read; thin them out"
                )
            points: Any = reader.read()
            places = np.ascontiguousarray(points.xyz, dtype=np.float64)
    except (laspy.LaspyException, LazrsError, ValueError, OverflowError, struct.error) as error:
        raise MeshError(f"not a LAS file, or a damaged one: {error}") from error
    except BaseException as error:
        # A panic of Rust, which has no class that can be imported, nor is an Exception.
        if type(error).__name__ != "PanicException":
            raise
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
        fixed_point=True,
    )


def _check_records(data: bytes) -> None:
    """Refuse more variable length records than the file has room for: laspy reads them one by one.

    Raises
    ------
    MeshError
        The header promises them.
    """
    table, extended = _RECORDS
    header = data[: extended.size].ljust(extended.size, b"\0")
    minor, start, count = table.unpack_from(header)
    promised = [(start, count)]
    if minor >= 4:  # the fields are of LAS 1.4
        promised.append(extended.unpack_from(header))
    for (first, records), least in zip(promised, _LEAST_BYTES, strict=False):
        if records and first + records * least > len(data):
            raise MeshError(
                f"not a LAS file, or a damaged one: the header promises {records} variable length"
                f" records, more than its {len(data)} bytes can hold"
            )


def _check_chunks(data: bytes) -> None:
    """Refuse more chunks of LAZ than the file has room for: lazrs aborts where memory is short.

    Raises
    ------
    MeshError
        The table of chunks promises them.
    """
    start, kind = _COMPRESSED.unpack_from(data.ljust(_COMPRESSED.size, b"\0"))
    if kind & 0xC0 != 0x80 or start + 8 > len(data):
        return
    table = int.from_bytes(data[start : start + 8], "little", signed=True)
    if table == -1:  # where the writer could not go back, the place is at the end
        table = int.from_bytes(data[-8:], "little", signed=True)
    if not 0 <= table <= len(data) - 8:
        return
    chunks = int.from_bytes(data[table + 4 : table + 8], "little")
    if chunks * _LEAST_POINT > len(data):
        raise MeshError(
            f"not a LAS file, or a damaged one: it promises {chunks} chunks, more than its"
            f" {len(data)} bytes can hold"
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
