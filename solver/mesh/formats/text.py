"""Tables of numbers in text files, read strictly."""

import re
from collections.abc import Sequence
from typing import Final

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.errors import MeshError

_NO_NUMBER: Final = re.compile(
    r"(?:(?P<whole>invalid literal for int)\(\) with base 10:"
    r"|could not convert string(?: to float:)?)"
    r" '(?P<word>.*)'(?: to float64 at row (?P<row>\d+), column \d+\.)?",
    re.DOTALL,
)
"""Messages of Python and NumPy about a word that is no number."""

_DECIMAL_COMMA: Final = re.compile(r"[+-]?\d+,\d+")


def decode(data: bytes) -> str:
    """Text of a file; bytes that are not UTF-8 (in comments, say) become replacement marks."""
    return data.decode("utf-8-sig", errors="replace")


def lines_of(text: str) -> list[str]:
    """Lines of a text, whichever system wrote it.

    `str.splitlines` also breaks them at form feeds and at separators of Unicode, which comments and
    names may have.
    """
    return text.replace("\r\n", "\n").replace("\r", "\n").split("\n")


def float_table(lines: Sequence[str], what: str) -> FloatArray:
    """Read lines of equally many numbers.

    Parameters
    ----------
    lines
        One row each, numbers separated by white space.
    what
        Name of a row, for messages: "vertex".

    Returns
    -------
    (rows, columns) float64; (0, 0) without lines.

    Raises
    ------
    MeshError
        Something is not a number, or rows differ in length.
    """
    if not lines:
        return np.zeros((0, 0))
    if not all(map(str.strip, lines)):  # NumPy would skip them and renumber the others
        raise MeshError(f"a {what} line is empty; the file is cut off or damaged")
    try:
        return np.loadtxt(lines, dtype=np.float64, comments=None, ndmin=2)
    except ValueError as error:
        raise MeshError(f"a {what} line cannot be read: {plain_reason(error)}") from error


def check_digits(text: str) -> None:
    """Refuse what Python reads as a number and no mesh file has: 1_0 as 10, digits of all scripts.

    Raises
    ------
    ValueError
        The text has it.
    """
    if "_" in text or not text.isascii():
        raise ValueError("a word in it is no number")


def counted_lists(lines: Sequence[str], what: str) -> tuple[IntArray, IntArray]:
    """Read lines that hold a count and then that many integers; the rest of a line is ignored.

    Parameters
    ----------
    lines
        One list each.
    what
        Name of a list, for messages: "face".

    Returns
    -------
    sizes : (rows,) int64
    values : (sum of sizes,) int64

    Raises
    ------
    MeshError
        Something is not an integer, or a list is shorter than its count.
    """
    sizes: list[int] = []
    values: list[int] = []
    try:
        check_digits("\n".join(lines))
        equal = _equal_lists(lines)
        if equal is not None:
            return equal
        for number, line in enumerate(lines):
            size, *row = line.split()
            sizes.append(int(size))
            if not 0 <= sizes[-1] <= len(row):
                raise MeshError(
                    f"{what} {number} promises {size} values and has {len(row)}; "
                    "the file is cut off or damaged"
                )
            values.extend(map(int, row[: sizes[-1]]))
        return np.array(sizes, dtype=np.int64), np.array(values, dtype=np.int64)
    except (ValueError, OverflowError) as error:
        raise MeshError(f"a {what} line cannot be read: {plain_reason(error)}") from error


def _equal_lists(lines: Sequence[str]) -> tuple[IntArray, IntArray] | None:
    """Counts and values of lines of equally many integers; ``None`` for all others.

    NumPy reads them in a tenth of the time, and refuses whatever is not plainly an integer.
    """
    try:
        table = np.loadtxt(lines, dtype=np.int64, comments=None, ndmin=2) if lines else None
    except ValueError:
        return None
    # NumPy skips empty lines.
    if table is None or len(table) != len(lines):
        return None
    sizes, values = table[:, 0].copy(), table[:, 1:]
    if sizes.min() < 0 or sizes.max() > values.shape[1]:
        return None
    return sizes, values[np.arange(values.shape[1]) < sizes[:, None]]


def last_line_note(text: str) -> tuple[str, ...]:
    """Return a warning if the text does not end with a line break.

    That is the only trace of a file that was cut off within its last number.
    """
    if not text or text[-1].isspace():
        return ()
    return ("the file does not end with a line break; if it was cut off, its last face is wrong",)


def plain_reason(error: Exception) -> str:
    """Return why a line of numbers cannot be read, without the terms of NumPy."""
    if isinstance(error, OverflowError):
        return "a number in it is too large"
    said = str(error)
    if said.startswith("Exceeds the limit"):
        return "a number in it has too many digits"
    found = _NO_NUMBER.match(said)
    if found:
        kind = "whole number" if found["whole"] else "number"
        about = [] if found["row"] is None else [f"row {found['row']}, counted from 0"]
        about += ["write a decimal point"] if _DECIMAL_COMMA.fullmatch(found["word"]) else []
        return f"{found['word'][:40]!r} is no {kind}" + (f" ({'; '.join(about)})" if about else "")
    return said.partition(";")[0].rstrip(".")
