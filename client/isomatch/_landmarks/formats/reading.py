"""Parts that readers of landmark files share: numbers, coordinate systems, errors with the line."""

import csv
import io
import math
from collections.abc import Collection, Sequence
from typing import Final, Literal, TypeAlias

CoordinateSystem: TypeAlias = Literal["LPS", "RAS"]
"""Directions of the axes: left, posterior, superior; or right, anterior, superior."""

_CODES: Final[dict[str, CoordinateSystem]] = {"LPS": "LPS", "RAS": "RAS", "1": "LPS", "0": "RAS"}
"""Names of coordinate systems, and the numbers that Slicer wrote up to version 4.10."""

_MISSING: Final = frozenset({"", "na", "nan"})


class FormatError(ValueError):
    """A file is not of its format.

    Parameters
    ----------
    message
        What is wrong.
    line
        Number of the line, from 1; None where no line can be named.
    """

    def __init__(self, message: str, line: int | None = None) -> None:
        super().__init__(message if line is None else f"line {line}: {message}")


def coordinate_system(given: str, line: int | None = None) -> CoordinateSystem:
    """Return the coordinate system that a file names.

    Raises
    ------
    FormatError
        It is neither LPS nor RAS, such as IJK, whose unit is a voxel of an image.
    """
    found = _CODES.get(given.strip().upper())
    if found is None:
        raise FormatError(f"coordinate system {given.strip()[:20]!r} is neither LPS nor RAS", line)
    return found


def number(text: str, line: int) -> float:
    """Return a finite number, whose decimals may follow a comma.

    Raises
    ------
    FormatError
        It is not one.
    """
    found = _parsed(text)
    if not math.isfinite(found):
        raise FormatError(f"{text.strip()[:40]!r} is not a finite number", line)
    return found


def is_number(text: str) -> bool:
    """Return whether an entry is a finite number."""
    return math.isfinite(_parsed(text))


def whole_number(text: str, line: int, most: int) -> int:
    """Return a number of things from 0 to `most`.

    Raises
    ------
    FormatError
        It is not one.
    """
    digits = text.strip()
    if not (digits.isascii() and digits.isdigit()) or len(digits) > 9 or int(digits) > most:
        raise FormatError(f"{digits[:20]!r} is not a number from 0 to {most}", line)
    return int(digits)


def position(texts: Sequence[str], line: int) -> tuple[float, ...] | None:
    """Return the coordinates of a landmark; None if all are empty, NA or nan: it is missing.

    Raises
    ------
    FormatError
        Some are missing, or one is not a finite number.
    """
    if all(map(is_missing, texts)):
        return None
    return tuple(number(text, line) for text in texts)


def is_missing(text: str) -> bool:
    """Return whether an entry stands for a coordinate that is missing."""
    return text.strip().lower() in _MISSING


def lines_of(text: str) -> list[str]:
    """Return the lines of a text, whichever system wrote it.

    `str.splitlines` also ends them at separators of Unicode, which names and remarks may have.
    """
    return text.replace("\r\n", "\n").replace("\r", "\n").split("\n")


def check_named_once(names: Sequence[str], known: Collection[str], line: int) -> None:
    """Refuse a row of names in which a known one recurs.

    Raises
    ------
    FormatError
        One does.
    """
    for name in known:
        if names.count(name) > 1:
            raise FormatError(f"the column {name!r} is named twice", line)


def table(text: str) -> list[tuple[int, list[str]]]:
    """Return the rows of a table that is delimited by commas, semicolons or tab stops.

    Parameters
    ----------
    text
        Of the file. Where the first line has two semicolons or tab stops they are the delimiter,
        as commas may be those of decimals.

    Returns
    -------
    Line number and stripped entries of each row that is not empty.

    Raises
    ------
    FormatError
        A quotation does not end.
    """
    lines = io.StringIO(text, newline="").readlines()
    first = next((line for line in lines if line.strip()), "")
    delimiter = next((mark for mark in ";\t" if first.count(mark) >= 2), ",")
    reader = csv.reader(lines, delimiter=delimiter, strict=True)
    try:
        rows = [(reader.line_num, [entry.strip() for entry in row]) for row in reader]
    except csv.Error as error:
        raise FormatError(str(error), reader.line_num) from error
    return [(line, entries) for line, entries in rows if any(entries)]


def one_line(text: str) -> str:
    """Return a name in one line, for formats in which a line ends it."""
    return " ".join(text.split())


def _parsed(text: str) -> float:
    """A number, nan if it is none; 1.234,5 and 1,234,567 are none."""
    plain = text.replace(",", ".") if "." not in text else text
    try:
        # float() takes digits grouped by underscores, and those of all scripts.
        return float(plain) if plain.isascii() and "_" not in plain else math.nan
    except ValueError:
        return math.nan
