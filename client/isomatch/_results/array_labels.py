"""Labels of vertices as the service reads them: whole numbers or text."""

from typing import Any, Final

import numpy as np
import numpy.typing as npt

_LARGEST_LABEL: Final = 2.0**53
"""Whole numbers up to this are exact in double precision."""


def as_labels(values: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Return labels as int64 or text; -1 stands for nan, a vertex without a label.

    Parameters
    ----------
    values
        (V,) whole numbers of any type, booleans, text, or bytes that are UTF-8. Signed integers
        and text keep their type.

    Raises
    ------
    ValueError
        They are of another shape or type, floats are not all whole, or numbers are too large.
    """
    if values.ndim != 1:
        raise ValueError(f"labels are a number or text of each vertex, not shape {values.shape}")
    kind = values.dtype.kind
    if kind in "iU":
        return values
    if kind == "b" or (kind == "u" and values.max(initial=0) <= np.iinfo(np.int64).max):
        return values.astype(np.int64)
    if kind == "u":
        raise ValueError("labels must not be beyond 2^63 - 1")
    if kind == "f":
        return _whole(values)
    if kind == "S":
        return _text(values)
    raise ValueError(
        f"labels are whole numbers or text, not {values.dtype}: give array.astype(str) or"
        " .astype(int)"
    )


def _whole(values: npt.NDArray[Any]) -> npt.NDArray[np.int64]:
    if np.isnan(values).all():
        raise ValueError("labels are nan everywhere")
    filled = np.where(np.isnan(values), -1.0, values)
    wrong = filled[(filled != np.rint(filled)) | ~(np.abs(filled) <= _LARGEST_LABEL)]
    if wrong.size:
        raise ValueError(f"labels are whole numbers up to 2^53, or text, not {wrong[0]}")
    return filled.astype(np.int64)


def _text(values: npt.NDArray[Any]) -> npt.NDArray[np.str_]:
    try:
        return np.char.decode(values, "utf-8")
    except UnicodeDecodeError as error:
        raise ValueError("labels are bytes that are not UTF-8; give array.astype(str)") from error
