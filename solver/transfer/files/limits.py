"""Limits of attribute files, and checks that all formats share."""

from collections.abc import Sequence
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from solver.arrays import FloatArray, IntArray
from solver.errors import TransferError
from solver.transfer.attributes import COLORS_NAME, Attribute

MOST_COLUMNS: Final = 1024
"""Columns of a file, besides colours and numbers of rows; skeletons have some hundred joints."""

MOST_VALUES: Final = 2**25
"""Values of a file: what a worker may hold several times."""

_MOST_TEXT: Final = 2**28
"""Bytes of the texts of an attribute as NumPy holds them, each as long as the longest."""

LONGEST_NAME: Final = 100
"""Characters of the name of an attribute or a column."""


def checked(attributes: Sequence[Attribute]) -> tuple[Attribute, ...]:
    """Return the attributes of a file, if there are any, of the same lengths and not too many.

    Raises
    ------
    TransferError
        There are none, or too many; lengths differ among those of vertices or of faces; one has no
        name, or text that no file can hold.
    """
    if not attributes:
        raise TransferError("the file has no attributes of vertices or faces")
    for one in attributes:
        first = next(other for other in attributes if other.on == one.on)
        if len(one.values) != len(first.values):
            raise TransferError(
                f"{first.name!r} has {len(first.values)} rows, and {one.name!r} has"
                f" {len(one.values)}; give a row for every vertex, or for every face"
            )
        _check_names(one)
    columns = sum(max(one.width, 1) for one in attributes if one.name != COLORS_NAME)
    check_size(columns, max(len(one.values) for one in attributes))
    return tuple(attributes)


def _check_names(one: Attribute) -> None:
    names = (one.name, *one.columns)
    if not all(names):
        raise TransferError("an attribute, or a column of one, has no name")
    if any(len(name) > LONGEST_NAME for name in names):
        raise TransferError(f"a name is longer than {LONGEST_NAME} characters")
    texts = np.unique(one.values).tolist() if one.is_text else []
    try:
        "".join([*names, *texts]).encode()
    except UnicodeEncodeError as error:
        # A surrogate alone: its name would be no text, either.
        code = f"U+{ord(error.object[error.start]):04X}"
        raise TransferError(f"names or labels have {code}, which is no character") from error


def check_size(columns: int, rows: int) -> None:
    """Refuse tables that are too large.

    Raises
    ------
    TransferError
        There are too many columns or values.
    """
    if columns > MOST_COLUMNS:
        raise TransferError(f"the file has {columns} columns, more than {MOST_COLUMNS}")
    if columns * rows > MOST_VALUES:
        raise TransferError(
            f"the file has {columns * rows} values, more than {MOST_VALUES}; carry some at a time"
        )


def text_column(texts: Sequence[str], places: IntArray | None = None) -> npt.NDArray[np.str_]:
    """Return texts, or the one at each place (V,), as an array.

    Raises
    ------
    TransferError
        One is so long that all would be too large.
    """
    rows, longest = len(texts if places is None else places), max(map(len, texts), default=0)
    if 4 * longest * rows > _MOST_TEXT:
        raise TransferError(f"a label of {longest} characters is too long for {rows} rows")
    found = np.array(texts, dtype=np.str_)
    return found if places is None else found[places]


def colors_in_range(table: npt.NDArray[Any]) -> FloatArray:
    """Bring colours to 0..1: whole numbers are in 0..255, others in 0..1 already; nan is none.

    Raises
    ------
    TransferError
        They are not in their range.
    """
    most = 255.0 if table.dtype.kind in "iu" else 1.0
    colors: FloatArray = table.astype(np.float64) / most
    if ((colors < 0.0) | (colors > 1.0)).any():
        raise TransferError("colours are whole numbers from 0 to 255, or numbers from 0 to 1")
    return colors
