"""Rows of a binary PLY file with lists, each of which begins with its own length."""

from typing import Final

import numpy as np
import numpy.typing as npt

from solver.arrays import BoolArray, IntArray
from solver.kernel import kernel

Octets = npt.NDArray[np.uint8]

CUT_OFF: Final = -1
NEGATIVE: Final = -2


@kernel
def list_sizes(
    body: Octets,
    position: int,
    rows: int,
    widths: IntArray,
    lengths: IntArray,
    signed: BoolArray,
    big: bool,
) -> tuple[IntArray, int]:
    """Find the lengths of the lists in all rows.

    Parameters
    ----------
    body
        Bytes.
    position
        Offset of the first row.
    rows
        Number of rows; `body` has at least a byte for each.
    widths
        (P,) bytes of one value of each property.
    lengths
        (P,) bytes of the length of a list; 0 for a single value.
    signed
        (P,) whether that length has a sign.
    big
        Whether the byte order is big-endian.

    Returns
    -------
    sizes : (rows, lists) int64
    position : where the rows end; `CUT_OFF` if `body` ends before, `NEGATIVE` if a length is.
    """
    sizes = np.empty((rows, np.count_nonzero(lengths)), np.int64)
    for row in range(rows):
        column = 0
        for number in range(len(widths)):
            items = 1
            if lengths[number]:
                if position + lengths[number] > len(body):
                    return sizes, CUT_OFF
                items = _integer(body, position, lengths[number], signed[number], big)
                if items < 0:
                    return sizes, NEGATIVE
                if items > len(body):
                    return sizes, CUT_OFF
                position += lengths[number]
                sizes[row, column] = items
                column += 1
            position += items * widths[number]
            if position > len(body):
                return sizes, CUT_OFF
    return sizes, position


@kernel
def copy_values(
    body: Octets,
    position: int,
    sizes: IntArray,
    widths: IntArray,
    lengths: IntArray,
    starts: IntArray,
    values: Octets,
) -> None:
    """Gather the values of each property, which are scattered over the rows.

    Parameters
    ----------
    body, position, widths, lengths
        As for :func:`list_sizes`.
    sizes
        As returned by it.
    starts
        (P,) offset in `values` of those of each property; changed to where they end.
    values
        (n,) uint8, filled.
    """
    for row in range(len(sizes)):
        column = 0
        for number in range(len(widths)):
            items = 1
            if lengths[number]:
                items = sizes[row, column]
                position += lengths[number]
                column += 1
            count = items * widths[number]
            start = starts[number]
            for octet in range(count):
                values[start + octet] = body[position + octet]
            position += count
            starts[number] = start + count


@kernel
def _integer(body: Octets, position: int, width: int, signed: bool, big: bool) -> int:
    value = 0
    for octet in range(width):
        place = position + (octet if big else width - 1 - octet)
        value = value * 256 + int(body[place])
    if signed and width < 8 and value >= 1 << (8 * width - 1):
        value -= 1 << (8 * width)
    return value
