"""The rows of a PLY file: binary or text, as columns by property name."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from solver.arrays import IntArray
from solver.errors import MeshError
from solver.mesh.formats.ply_rows import CUT_OFF, NEGATIVE, copy_values, list_sizes
from solver.mesh.formats.text import check_digits, lines_of, plain_reason

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
        NumPy's code of the type of the list's length; ``None`` for a single number.
    """

    kind: str
    length: str | None = None


@dataclass(frozen=True)
class Element:
    """An element of the header: its name, number of rows, and properties by name, in order."""

    name: str
    rows: int
    properties: dict[str, Property] = field(default_factory=dict)


def binary_columns(elements: Sequence[Element], body: bytes, byte_order: str) -> dict[str, Columns]:
    """Read the binary rows that follow the header.

    Parameters
    ----------
    elements
        Elements that the header declares.
    body
        Bytes after the header.
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
    """Columns of an element, and the position where its rows end."""
    kinds = {name: np.dtype(byte_order + prop.kind) for name, prop in element.properties.items()}
    if not kinds:
        return {}, position
    widths = np.array([kind.itemsize for kind in kinds.values()], dtype=np.int64)
    types = [np.dtype(prop.length or "V0") for prop in element.properties.values()]
    lengths = np.array([kind.itemsize for kind in types], dtype=np.int64)
    shortest = int(np.where(lengths > 0, lengths, widths).sum())
    if element.rows * shortest > len(body) - position:
        raise _cut_off(element)
    if not lengths.any():
        row = np.dtype(list(kinds.items()))
        table = np.frombuffer(body, row, element.rows, position)
        return {name: table[name] for name in kinds}, position + element.rows * shortest
    signed = np.array([kind.kind == "i" for kind in types])
    octets = np.frombuffer(body, np.uint8)
    layout = widths, lengths
    sizes, end = list_sizes(octets, position, element.rows, *layout, signed, byte_order == ">")
    if end == NEGATIVE:
        raise MeshError(f"a {element.name} of the PLY file has a list of negative length")
    if end == CUT_OFF:
        raise _cut_off(element)
    counts = np.full(len(widths), element.rows, dtype=np.int64)
    counts[lengths > 0] = sizes.sum(axis=0)
    ends = np.cumsum(counts * widths)
    starts = ends - counts * widths
    values = np.empty(int(ends[-1]), dtype=np.uint8)
    copy_values(octets, position, sizes, *layout, starts.copy(), values)
    lists = iter(sizes.T)
    columns: Columns = {}
    for (name, kind), start, stop, length in zip(kinds.items(), starts, ends, lengths, strict=True):
        found = values[start:stop].view(kind)
        columns[name] = (np.ascontiguousarray(next(lists)), found) if length else found
    return columns, end


def text_columns(elements: Sequence[Element], text: str) -> tuple[dict[str, Columns], int]:
    """Read the text rows that follow the header, one line each.

    Parameters
    ----------
    elements
        Elements that the header declares.
    text
        Text after the header.

    Returns
    -------
    The columns by element, and the number of lines after the last row.

    Raises
    ------
    MeshError
        There are fewer lines than the header promises, or one cannot be read.
    """
    lines = [line for line in lines_of(text) if line.strip()]
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
                f"a {element.name} line of the PLY file cannot be read: {plain_reason(error)}; "
                "the file is cut off or damaged"
            ) from error
        position = end
    return columns, len(lines) - position


def _text_rows(element: Element, rows: Sequence[str]) -> Columns:
    sizes: dict[str, list[int]] = {name: [] for name in element.properties}
    words: dict[str, list[str]] = {name: [] for name in element.properties}
    check_digits("\n".join(rows))
    for row in rows:
        written, place = row.split(), 0
        for name, prop in element.properties.items():
            size = 1
            if prop.length is not None:
                size = int(written[place]) if place < len(written) else 0
                place += 1
            if not 0 <= size <= len(written) - place:
                raise ValueError(f"{name[:80]} has not as many values as it promises")
            sizes[name].append(size)
            words[name] += written[place : place + size]
            place += size
        if place < len(written):
            raise ValueError("it is longer than the header declares")
    columns: Columns = {}
    for name, prop in element.properties.items():
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
