"""The rows of a PLY file: binary or text, as columns by property name."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import islice
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from solver.arrays import IntArray
from solver.errors import MeshError

Values: TypeAlias = npt.NDArray[Any]

Columns: TypeAlias = dict[str, Values | tuple[IntArray, Values]]
"""By property: a number per row, or (sizes, values one after the other) of a list per row."""


@dataclass(frozen=True)
class Property:
    """A property of an element's rows.

    Parameters
    ----------
    kind
        NumPy's code of its type, without byte order.
    length
        Code of the type of the list's length; ``None`` for a single number.
    """

    kind: str
    length: str | None = None


@dataclass(frozen=True)
class Element:
    """A kind of row, how many there are, and their properties by name, in order."""

    name: str
    rows: int
    properties: dict[str, Property] = field(default_factory=dict)


def binary_columns(elements: Sequence[Element], body: bytes, byte_order: str) -> dict[str, Columns]:
    """Read the binary rows that follow the header.

    Parameters
    ----------
    elements
        What the header declares.
    body
        Everything after the header.
    byte_order
        "<" or ">".

    Raises
    ------
    MeshError
        There are more or fewer bytes than the header promises.
    """
    columns: dict[str, Columns] = {}
    position = 0
    for element in elements:
        columns[element.name], position = _binary_rows(element, body, position, byte_order)
    if position != len(body):
        raise MeshError(
            f"the PLY file has {len(body) - position} bytes more than its header promises; "
            "it is damaged (was it transferred as text?)"
        )
    return columns


def _binary_rows(
    element: Element, body: bytes, position: int, byte_order: str
) -> tuple[Columns, int]:
    """Read rows in runs whose lists have the same lengths."""
    kinds = {
        (name, what): np.dtype(byte_order + kind)
        for name, prop in element.properties.items()
        for what, kind in (("size", prop.length), ("value", prop.kind))
        if kind
    }
    read = {key: bytearray() for key in kinds}
    left, longest = element.rows if kinds else 0, 1
    while left:
        row = _row_type(element, body, position, byte_order)
        fitting = min(left, longest, (len(body) - position) // row.itemsize)
        table = np.frombuffer(body, row, fitting, position)
        alike = np.ones(fitting, dtype=np.bool_)
        for number, (_, what) in enumerate(kinds):
            if what == "size":
                alike &= table[f"f{number}"] == table[f"f{number}"][0]
        run = fitting if alike.all() else int(np.argmin(alike))
        for number, key in enumerate(kinds):
            read[key] += table[f"f{number}"][:run].tobytes()
        # Looking further ahead only after success keeps the work linear whatever the lists are.
        longest = 2 * longest if run == longest else 1
        left -= run
        position += run * row.itemsize
    columns: Columns = {}
    for name, prop in element.properties.items():
        values = np.frombuffer(read[name, "value"], kinds[name, "value"])
        if prop.length is None:
            columns[name] = values
        else:
            sizes = np.frombuffer(read[name, "size"], kinds[name, "size"]).astype(np.int64)
            columns[name] = (sizes, values)
    return columns, position


def _row_type(element: Element, body: bytes, position: int, byte_order: str) -> np.dtype[np.void]:
    """Layout of the row that begins at `position`, all of which is there; fields f0, f1, ..."""
    fields: list[tuple[str, str, tuple[int, ...]]] = []
    for prop in element.properties.values():
        items = 1
        if prop.length is not None:
            length = np.dtype(byte_order + prop.length)
            if position + length.itemsize > len(body):
                raise _cut_off(element)
            items = int(np.frombuffer(body, length, 1, position)[0])
            if items < 0:
                raise MeshError(f"a {element.name} of the PLY file has a list of negative length")
            fields.append((f"f{len(fields)}", length.str, ()))
            position += length.itemsize
        position += items * np.dtype(prop.kind).itemsize
        if position > len(body):
            raise _cut_off(element)
        shape = () if prop.length is None else (items,)
        fields.append((f"f{len(fields)}", byte_order + prop.kind, shape))
    return np.dtype(fields)


def text_columns(elements: Sequence[Element], text: str) -> dict[str, Columns]:
    """Read the text rows that follow the header, one line each.

    Parameters
    ----------
    elements
        What the header declares.
    text
        Everything after the header.

    Raises
    ------
    MeshError
        There are fewer lines than the header promises, or one cannot be read.
    """
    lines = [line for line in text.splitlines() if line.strip()]
    columns: dict[str, Columns] = {}
    position = 0
    for element in elements:
        end = position + element.rows if element.properties else position
        if end > len(lines):
            raise _cut_off(element)
        try:
            columns[element.name] = _text_rows(element, lines[position:end])
        except (ValueError, OverflowError) as error:
            raise MeshError(
                f"a {element.name} line of the PLY file cannot be read: {error}; "
                "the file is cut off or damaged"
            ) from error
        position = end
    return columns


def _text_rows(element: Element, rows: Sequence[str]) -> Columns:
    sizes: dict[str, list[int]] = {name: [] for name in element.properties}
    words: dict[str, list[str]] = {name: [] for name in element.properties}
    for row in rows:
        rest = iter(row.split())
        for name, prop in element.properties.items():
            size = 1 if prop.length is None else int(next(rest, ""))
            sizes[name].append(size)
            words[name].extend(islice(rest, size))
        if next(rest, None) is not None:
            raise ValueError("it is longer than the header says")
        if "_" in row:  # Python would read 1_0 as 10
            raise ValueError("a word in it is no number")
    columns: Columns = {}
    for name, prop in element.properties.items():
        if len(words[name]) != sum(sizes[name]):
            raise ValueError(f"{name} is shorter than promised")
        if prop.length is None:
            columns[name] = np.array(words[name], dtype=np.float64)
        else:
            kind = np.float64 if prop.kind.startswith("f") else np.int64
            columns[name] = (np.array(sizes[name], np.int64), np.array(words[name], kind))
    return columns


def _cut_off(element: Element) -> MeshError:
    return MeshError(
        f"the PLY file promises {element.rows} rows of {element.name} and ends before them; "
        "it is cut off or damaged"
    )
