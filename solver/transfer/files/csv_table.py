"""Tables of attributes as text (CSV): a line of names, then a line for each vertex or face.

A column ``vertex`` or ``face`` has the number of each line; without it the lines are in the order
of the file. Columns are grouped as :mod:`.columns` says.
"""

import csv
import io
import re
from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from solver.errors import TransferError
from solver.transfer.attributes import Attribute
from solver.transfer.files.columns import Column, from_columns, renamed, to_columns
from solver.transfer.files.limits import check_size
from solver.transfer.overlap import CORNERS, FACES, VERTICES

_NUMBERED: Final = {"vertex": VERTICES, "face": FACES}
"""Names of the column of numbers, and what is numbered."""
_NUMBER_OF: Final = {VERTICES: "vertex", FACES: "face", CORNERS: "corner"}
_WHOLE = re.compile(r"\s*[+-]?[0-9]{1,18}\s*")
_NUMBER = re.compile(r"\s*[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?\s*")


def read_csv(data: bytes) -> list[Attribute]:
    """Read a table.

    Raises
    ------
    TransferError
        It is not UTF-8 text, lines differ in length, a column is named twice or has both numbers
        and text, or ``vertex`` or ``face`` does not have each number from 0 once.
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
    names = [name.strip() for name in rows[0]]
    if len(set(names)) < len(names) or not all(names):
        raise TransferError("the first line of the CSV file needs a different name for each column")
    check_size(len(names), len(rows) - 1)
    if len(names) == 1 and ";" in names[0]:
        raise TransferError("columns of the CSV file must be separated by commas, and 1.5 is 1.5")
    for number, row in enumerate(rows[1:]):
        if len(row) != len(names):
            raise TransferError(
                f"row {number} has {len(row)} values, and there are {len(names)} names"
            )
    columns = {name: column_of(name, cells) for name, *cells in zip(names, *rows[1:], strict=True)}
    numbered = [name for name in _NUMBERED if name in columns]
    if len(numbered) > 1:
        raise TransferError("rows are of vertices or of faces: leave out one of the two columns")
    if not numbered:
        return from_columns(columns)
    found = from_columns(_in_order(columns, numbered[0]))
    return [replace(one, on=_NUMBERED[numbered[0]]) for one in found]


def write_csv(attributes: Sequence[Attribute]) -> bytes:
    """Return attributes as a table, which :func:`read_csv` reads if rows are of vertices or faces.

    All are of vertices, all of faces, or all of corners. Colours are bytes. An attribute that is
    called as the numbers of the rows are gets another name (:func:`.renamed`).
    """
    on, count = attributes[0].on or VERTICES, len(attributes[0].values)
    number = _NUMBER_OF[on]
    columns = renamed(to_columns(attributes), [number] if on == CORNERS else _NUMBERED)
    stream = io.StringIO(newline="")
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow([number, *columns])
    writer.writerows(zip(range(count), *(one.tolist() for one in columns.values()), strict=True))
    return stream.getvalue().encode()


def column_of(name: str, cells: Sequence[str]) -> Column:
    """Return cells as int64, float64 or text; nan among numbers, and empty cells of text, are none.

    Raises
    ------
    TransferError
        There are both numbers and text, or all cells are empty.
    """
    whole = [_WHOLE.fullmatch(cell) is not None for cell in cells]
    if all(whole):
        return np.array([int(cell) for cell in cells], dtype=np.int64)
    number = [_NUMBER.fullmatch(cell) is not None for cell in cells]
    if any(number):
        number = [known or cell.strip() == "nan" for known, cell in zip(number, cells, strict=True)]
    if all(number):
        return np.array([float(cell) for cell in cells])
    # Of a column of numbers, the one that is none; of a column of text, the one that is a number.
    if any(number):
        row = number.index(not number[0])
        raise TransferError(
            f"{name[:40]!r} has both numbers and text: row {row} is {cells[row][:40]!r}"
        )
    if not any(cell.strip() for cell in cells):
        raise TransferError(f"{name[:40]!r} is empty in all rows")
    return np.array(cells, dtype=np.str_)


def _in_order(columns: dict[str, Column], number: str) -> dict[str, Column]:
    numbers = columns.pop(number)
    order = np.argsort(numbers, kind="stable")
    if not np.array_equal(numbers[order], np.arange(len(numbers))):
        raise TransferError(f"the column {number!r} must have each number from 0 once")
    return {name: values[order] for name, values in columns.items()}
