"""Array types of the solver, and archives of arrays."""

import io
import zipfile
from collections.abc import Mapping
from typing import Any, BinaryIO, TypeAlias

import numpy as np
import numpy.typing as npt

FloatArray: TypeAlias = npt.NDArray[np.float64]
"""float64 array; the docstring that uses it gives the shape."""

RealArray: TypeAlias = npt.NDArray[np.float32] | npt.NDArray[np.float64]
"""float32 or float64 array, where either precision will do; the docstring gives the shape."""

IntArray: TypeAlias = npt.NDArray[np.int64]
"""int64 array; the docstring that uses it gives the shape."""

IndexArray: TypeAlias = npt.NDArray[np.uint32]
"""uint32 array of indices in compiled loops, which need not look for negative ones."""

BoolArray: TypeAlias = npt.NDArray[np.bool_]
"""boolean array; the docstring that uses it gives the shape."""


def npz_bytes(
    arrays: Mapping[str, npt.NDArray[Any]], compression: int = zipfile.ZIP_DEFLATED
) -> bytes:
    """Return arrays as the bytes of an ``.npz`` file without pickled objects.

    Parameters
    ----------
    arrays
        By name. Unlike those of :func:`numpy.savez`, names may be ``file`` or ``allow_pickle``.
    compression
        As of :class:`zipfile.ZipFile`.

    Raises
    ------
    ValueError
        An array has Python objects.
    """
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", compression) as archive:
        for name, values in arrays.items():
            with archive.open(f"{name}.npy", "w", force_zip64=True) as member:
                np.lib.format.write_array(member, values, allow_pickle=False)
    return stream.getvalue()


def array_header(member: BinaryIO) -> tuple[tuple[int, ...], np.dtype[Any]]:
    """Return shape and type of an array by its header, which may promise more than there is.

    Parameters
    ----------
    member
        An ``.npy`` file, as of :meth:`zipfile.ZipFile.open`; it is read up to the values.

    Raises
    ------
    ValueError, TypeError, SyntaxError, RecursionError
        The header is damaged.
    """
    version = np.lib.format.read_magic(member)
    if version == (1, 0):
        shape, _, kind = np.lib.format.read_array_header_1_0(member)
    elif version == (2, 0):
        shape, _, kind = np.lib.format.read_array_header_2_0(member)
    else:
        raise ValueError(f"arrays of version {version} are not read")
    return shape, kind
