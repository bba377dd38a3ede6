"""The rows of a PLY file: binary or text, as columns by property name."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from solver.arrays import FloatArray, IntArray
from solver.errors import MeshError
from solver.mesh_formats.text import counted_lists, float_table

Values: TypeAlias = npt.NDArray[Any]

Columns: TypeAlias = dict[str, FloatArray | tuple[IntArray, Values]]
"""By property: a number per row, or (sizes, values one after the other) of a list per row."""


FACE_LISTS = ("vertex_indices", "vertex_index")
"""Names under which faces list their corners."""


@dataclass(frozen=True)
class Property:
    """A property of an element's rows.

    Parameters
    ----------
    name
        As in the header.
    kind
        NumPy's code of its type, without byte order.
    length
        Code of the type of the list's length; ``None`` for a single number.
    """

    name: str
    kind: str
    length: str | None = None


@dataclass(frozen=True)
class Element:
    """A kind of row, how many there are, and their properties in order."""

    name: str
    rows: int
    properties: tuple[Property, ...]

    def with_property(self, prop: Property) -> "Element":
        """Return the element with one property more.

        Raises
        ------
        MeshError
            It has one of that name already.
        """
        if any(known.name == prop.name for known in self.properties):
            raise MeshError(f"the PLY header declares the property {prop.name} twice")
        return replace(self, properties=(*self.properties, prop))

    def __iter__(self) -> Iterator[Property]:
        return iter(self.properties)


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
        least = sum(np.dtype(prop.length or prop.kind).itemsize for prop in element)
        if element.rows * least > len(body) - position:
            raise _cut_off(element)
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
    if not element.rows or not element.properties:
        return _empty(element), position
    sizes, _ = _row_at(element, body, position, byte_order)
    fields: list[tuple[str, str, tuple[int, ...]]] = []
    for number, prop in enumerate(element):
        if prop.length is None:
            fields.append((f"value{number}", byte_order + prop.kind, ()))
        else:
            fields.append((f"size{number}", byte_order + prop.length, ()))
            fields.append((f"value{number}", byte_order + prop.kind, (sizes[number],)))
    row = np.dtype(fields)
    if element.rows * row.itemsize <= len(body) - position:
        table = np.frombuffer(body, dtype=row, count=element.rows, offset=position)
        names = [name for name, _, _ in fields if name.startswith("size")]
        if all((table[name] == sizes[int(name[4:])]).all() for name in names):
            return _uniform(element, table), position + element.rows * row.itemsize
    return _walk(element, body, position, byte_order)


def _uniform(element: Element, table: Values) -> Columns:
    columns: Columns = {}
    for number, prop in enumerate(element):
        values = table[f"value{number}"]
        if prop.length is None:
            columns[prop.name] = values.astype(np.float64)
        else:
            sizes = table[f"size{number}"].astype(np.int64)
            columns[prop.name] = (sizes, values.reshape(-1))
    return columns


def _row_at(element: Element, body: bytes, position: int, byte_order: str) -> tuple[list[int], int]:
    """Lengths of a row's lists (0 for numbers), and where the next row begins."""
    sizes: list[int] = []
    for prop in element:
        size, items = 0, 1
        if prop.length is not None:
            size = items = int(_read(body, position, byte_order + prop.length, 1, element)[0])
            if size < 0:
                raise MeshError(f"a {element.name} of the PLY file has a list of negative length")
            position += np.dtype(prop.length).itemsize
        sizes.append(size)
        position += items * np.dtype(prop.kind).itemsize
    if position > len(body):
        raise _cut_off(element)
    return sizes, position


def _walk(element: Element, body: bytes, position: int, byte_order: str) -> tuple[Columns, int]:
    """Row by row, for lists of different lengths."""
    sizes: list[list[int]] = []
    values: list[list[Values]] = [[] for _ in element]
    for _ in range(element.rows):
        lengths, end = _row_at(element, body, position, byte_order)
        sizes.append(lengths)
        for number, prop in enumerate(element):
            items = 1
            if prop.length is not None:
                items = lengths[number]
                position += np.dtype(prop.length).itemsize
            values[number].append(_read(body, position, byte_order + prop.kind, items, element))
            position += items * np.dtype(prop.kind).itemsize
        position = end
    columns: Columns = {}
    for number, prop in enumerate(element):
        joined = np.concatenate(values[number])
        if prop.length is None:
            columns[prop.name] = joined.astype(np.float64)
        else:
            lengths_column = np.array([row[number] for row in sizes], dtype=np.int64)
            columns[prop.name] = (lengths_column, joined)
    return columns, position


def _read(body: bytes, position: int, kind: str, count: int, element: Element) -> Values:
    if position + count * np.dtype(kind).itemsize > len(body):
        raise _cut_off(element)
    return np.frombuffer(body, dtype=kind, count=count, offset=position)


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
    lines = [line for raw in text.splitlines() if (line := raw.strip())]
    columns: dict[str, Columns] = {}
    position = 0
    for element in elements:
        if not element.properties or not element.rows:
            columns[element.name] = _empty(element)
            continue
        if element.rows > len(lines) - position:
            raise _cut_off(element)
        rows = lines[position : position + element.rows]
        position += element.rows
        columns[element.name] = _text_rows(element, rows)
    return columns


def _text_rows(element: Element, rows: list[str]) -> Columns:
    first = element.properties[0]
    if first.length is not None and first.name in FACE_LISTS:
        # What follows (colours, texture coordinates) is not needed.
        return {first.name: counted_lists(rows, element.name)}
    if any(prop.length is not None for prop in element):
        return _text_walk(element, rows)
    table = float_table(rows, element.name)
    if table.shape[1] != len(element.properties):
        raise MeshError(
            f"a {element.name} line of the PLY file has {table.shape[1]} numbers; "
            f"its header promises {len(element.properties)}"
        )
    return {prop.name: table[:, number] for number, prop in enumerate(element)}


def _text_walk(element: Element, rows: list[str]) -> Columns:
    """Word by word, for lists that stand behind other properties."""
    sizes: list[list[int]] = [[] for _ in element]
    words: list[list[str]] = [[] for _ in element]
    try:
        for row in rows:
            rest = row.split()
            for number, prop in enumerate(element):
                size = 1 if prop.length is None else int(rest.pop(0))
                if not 0 <= size <= len(rest):
                    raise _cut_off(element)
                sizes[number].append(size)
                words[number] += rest[:size]
                rest = rest[size:]
        columns: Columns = {}
        for number, prop in enumerate(element):
            if prop.length is None:
                columns[prop.name] = np.array(words[number], dtype=np.float64)
            else:
                values = np.array(words[number], dtype="f8" if prop.kind[0] == "f" else "i8")
                columns[prop.name] = (np.array(sizes[number], dtype=np.int64), values)
    except (ValueError, IndexError, OverflowError) as error:
        raise MeshError(f"a {element.name} line of the PLY file cannot be read: {error}") from error
    return columns


def _empty(element: Element) -> Columns:
    nothing = np.zeros(0, dtype=np.int64)
    return {
        prop.name: np.zeros(0) if prop.length is None else (nothing, nothing) for prop in element
    }


def _cut_off(element: Element) -> MeshError:
    return MeshError(
        f"the PLY file promises {element.rows} rows of {element.name} and ends before them; "
        "it is cut off or damaged"
    )
