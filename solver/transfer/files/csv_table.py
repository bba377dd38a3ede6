"""Tables of attributes as text (CSV): a line of names, then a line for each vertex or face.

A column ``vertex`` or ``face`` has the number of each line; without it the lines are in the order
of the file. Columns are grouped as :mod:`.columns` says. A column ``NAME:text`` is text, whatever
it looks like; others are numbers if they look so. The case of names that mean something here does
not count.
"""

import csv
import io
import re
from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from solver.errors import TransferError
from solver.transfer.attributes import WEIGHTS_NAME, Attribute
from solver.transfer.files.columns import CHANNELS, Column, from_columns, to_columns
from solver.transfer.files.limits import check_size, text_column
from solver.transfer.files.names import renamed
from solver.transfer.overlap import CORNERS, FACES, VERTICES

_NUMBERED: Final = {"vertex": VERTICES, "face": FACES}
"""Names of the column of numbers, and what is numbered."""
_NUMBER_OF: Final = {VERTICES: "vertex", FACES: "face", CORNERS: "corner"}
_TEXT: Final = ":text"
"""End of the name of a column of text that may look like numbers, or like nothing."""
_NONE: Final = frozenset({"", "nan", "na", "n/a", "null"})
"""Cells without a value among numbers, in lower case."""
_WHOLE = re.compile(r"[+-]?[0-9]{1,18}")
# Digits are matched in one way only: matching stays linear in the length of a cell.
_NUMBER = re.compile(r"[+-]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][+-]?[0-9]+)?")
_INFINITE = re.compile(r"[+-]?inf(inity)?", re.IGNORECASE)


def read_csv(data: bytes) -> list[Attribute]:
    """Read a table.

    Raises
    ------
    TransferError
        It is not UTF-8 text, lines differ in length, a column has no name, is named twice or has
        both numbers and text, or ``vertex`` or ``face`` does not have each number from 0 once.
    """
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError:
        raise TransferError("the CSV file is not text in UTF-8") from None
    try:
        rows = [row for row in csv.reader(io.StringIO(text, newline=""), strict=True) if row]
    except csv.Error as error:
        raise TransferError(f"the CSV file cannot be read: {error}") from error
    if len(rows) < 2:
        raise TransferError("the CSV file has no rows; begin it with a line of names")
    names = _as_reserved([name.strip() for name in rows[0]])
    if names[0] == "" and len(names) > 1:
        raise TransferError(
            "the first column of the CSV file has no name, as pandas writes its index: call it"
            " vertex or face, or leave it out"
        )
    if len(set(names)) < len(names) or not all(names):
        raise TransferError("the first line of the CSV file needs a different name for each column")
    check_size(len({*names} - {*_NUMBERED, *CHANNELS}), len(rows) - 1)
    if len(names) == 1 and (";" in names[0] or "\t" in names[0]):
        raise TransferError(
            "columns of the CSV file must be separated by commas, and decimals by a point, as in"
            " 1.5"
        )
    for number, row in enumerate(rows[1:]):
        if len(row) != len(names):
            raise TransferError(
                f"row {number} has {len(row)} values, and there are {len(names)} names"
            )
    columns = {
        name: text_column(cells) if _is_text(name) else column_of(name, cells)
        for name, *cells in zip(names, *rows[1:], strict=True)
    }
    numbered = [name for name in _NUMBERED if name in columns]
    if len(numbered) > 1:
        raise TransferError("rows are of vertices or of faces: leave out one of the two columns")
    if not numbered:
        return from_columns(_named(columns))
    found = from_columns(_named(_in_order(columns, numbered[0])))
    return [replace(one, on=_NUMBERED[numbered[0]]) for one in found]


def write_csv(attributes: Sequence[Attribute]) -> bytes:
    """Return attributes as a table, which :func:`read_csv` reads if rows are of vertices or faces.

    All are of vertices, all of faces, or all of corners. Colours are bytes. Text that would not be
    read as text is marked so. An attribute that is called as the numbers of the rows, or as marked
    text, gets another name (:func:`.renamed`).
    """
    on, count = attributes[0].on or VERTICES, len(attributes[0].values)
    number = _NUMBER_OF[on]
    named = to_columns(attributes)
    # The case of these names does not count when they are read.
    taken = {name for name in named if name.lower() in _NUMBERED} | {*_NUMBERED}
    taken |= {name for name, values in named.items() if _is_text(name) and values.dtype.kind != "U"}
    columns = _marked(renamed(named, [number] if on == CORNERS else taken))
    texts = [values for values in columns.values() if values.dtype.kind == "U"]
    # The writer does not quote what has this alone, and the reader would end the line there.
    broken = any((np.char.find(one, "\r") >= 0).any() for one in texts)
    stream = io.StringIO(newline="")
    writer = csv.writer(
        stream,
        lineterminator="\n",
        quoting=csv.QUOTE_NONNUMERIC if broken else csv.QUOTE_MINIMAL,
    )
    writer.writerow([number, *columns])
    writer.writerows(zip(range(count), *(one.tolist() for one in columns.values()), strict=True))
    return stream.getvalue().encode()


def _is_text(name: str) -> bool:
    return name.lower().endswith(_TEXT)


def _marked(columns: dict[str, Column]) -> dict[str, Column]:
    """Return columns with the mark of text, where it would be read as something else."""
    return {
        f"{name}{_TEXT}"
        if values.dtype.kind == "U" and (_is_text(name) or not _looks_like_text(values))
        else name: values
        for name, values in columns.items()
    }


def _looks_like_text(values: Column) -> bool:
    try:
        return column_of("", values.tolist()).dtype.kind == "U"
    except TransferError:
        return False


def _named(columns: dict[str, Column]) -> dict[str, Column]:
    """Return columns by their names without the mark of text."""
    found = {
        name[: -len(_TEXT)] if _is_text(name) else name: values for name, values in columns.items()
    }
    if len(found) < len(columns) or not all(found):
        raise TransferError(f"columns need different names, also without {_TEXT!r} at their end")
    return found


def column_of(name: str, cells: Sequence[str]) -> Column:
    """Return cells as int64, float64 or text.

    Among numbers, cells that are empty, ``nan``, ``NA`` or ``null`` in any case are nan; among
    text, empty ones are none.

    Raises
    ------
    TransferError
        There are both numbers and text, a number is infinite, or no cell has a value.
    """
    words = [cell.strip() for cell in cells]
    if all(map(_WHOLE.fullmatch, words)):
        return np.array([int(word) for word in words], dtype=np.int64)
    there = [word.lower() not in _NONE for word in words]
    if not any(there):
        raise TransferError(f"{name[:40]!r} has no value in any row")
    number = [_NUMBER.fullmatch(word) is not None for word in words]
    infinite = [_INFINITE.fullmatch(word) is not None for word in words]
    numeric = [one or other for one, other in zip(number, infinite, strict=True)]
    if all(known or not given for known, given in zip(numeric, there, strict=True)):
        values = np.array(
            [float(word) if given else np.nan for word, given in zip(words, there, strict=True)]
        )
        if np.isinf(values).any():
            row = int(np.argmax(np.isinf(values)))
            raise TransferError(
                f"{name[:40]!r} has infinite numbers, which cannot be carried: row {row} is"
                f" {cells[row][:40]!r}"
            )
        return values
    if any(number):
        # Of a column of numbers, the first text; of a column of text, the first number.
        numbers, texts = sum(numeric), sum(there) - sum(numeric)
        mostly = numeric[there.index(True)] if numbers == texts else numbers > texts
        row = next(
            place
            for place, (known, given) in enumerate(zip(numeric, there, strict=True))
            if given and known != mostly
        )
        raise TransferError(
            f"{name[:40]!r} has both numbers and text: row {row} is {cells[row][:40]!r}; if all are"
            f" text, call the column {name[:40] + _TEXT!r} in CSV"
        )
    return text_column(cells)


def _as_reserved(names: Sequence[str]) -> list[str]:
    """Return names of columns, with those that mean something here in lower case."""
    lower = [name.lower() for name in names]
    reserved = {*_NUMBERED}
    if {*CHANNELS[:3]} <= {*lower}:
        reserved |= {*CHANNELS}
    found = [small if small in reserved else name for small, name in zip(lower, names, strict=True)]
    skin = f"{WEIGHTS_NAME}."
    return [skin + one[len(skin) :] if one.lower().startswith(skin) else one for one in found]


def _in_order(columns: dict[str, Column], number: str) -> dict[str, Column]:
    numbers = columns.pop(number)
    order = np.argsort(numbers, kind="stable")
    if not np.array_equal(numbers[order], np.arange(len(numbers))):
        raise TransferError(f"the column {number!r} must have each number from 0 once")
    return {name: values[order] for name, values in columns.items()}
