"""Attributes as single columns of numbers or text, for formats of tables: CSV and PLY.

A column of an attribute of several is called ``NAME.COLUMN``, as in ``flow.x`` or
``weights.LeftArm``; those of colours ``red``, ``green``, ``blue`` and ``alpha``. Read again,
columns of numbers are one attribute if there are two or more of a name, or one of weights, and none
is called by the name alone: ``seg.label`` is a column as others, and so is ``k.max`` beside ``k``.
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from solver.transfer.attributes import COLORS_NAME, WEIGHTS_NAME, Attribute
from solver.transfer.files.limits import colors_in_range
from solver.transfer.files.names import renamed

CHANNELS: Final = ("red", "green", "blue", "alpha")
_AXES: Final = "xyz"

Column = npt.NDArray[Any]


def from_columns(columns: Mapping[str, Column]) -> list[Attribute]:
    """Group columns into attributes, in their order.

    Parameters
    ----------
    columns
        (V,) int64, float64 or text by name.

    Raises
    ------
    TransferError
        Colours are neither in 0..1 nor whole numbers in 0..255.
    """
    channels = _channels(columns)
    others = {name: values for name, values in columns.items() if name not in channels}
    groups = _groups(others, columns)
    grouped = {name for names in groups.values() for name in names}
    # By the first of their columns.
    found = {
        names[0]: Attribute(group, _table(columns, names), tuple(_split(one)[1] for one in names))
        for group, names in groups.items()
    }
    found |= {name: Attribute(name, others[name]) for name in others if name not in grouped}
    if channels:
        # Nothing but the colours may have their name.
        (own,) = renamed({COLORS_NAME: channels}, {COLORS_NAME, *columns, *groups})
        found = {
            name: replace(one, name=own) if one.name == COLORS_NAME else one
            for name, one in found.items()
        }
        table = np.stack([columns[name] for name in channels], axis=1)
        colors = Attribute(COLORS_NAME, colors_in_range(table), channels)
        found[next(name for name in columns if name in channels)] = colors
    return [found[name] for name in columns if name in found]


def _channels(columns: Mapping[str, Column]) -> tuple[str, ...]:
    """Return the columns of colours; none unless there are red, green and blue in numbers."""
    there = tuple(name for name in CHANNELS if name in columns and _is_numeric(columns[name]))
    return there if {*CHANNELS[:3]} <= {*there} else ()


def _groups(others: Mapping[str, Column], columns: Mapping[str, Column]) -> dict[str, list[str]]:
    """Return the columns of attributes of several, by the name of the attribute."""
    groups: dict[str, list[str]] = {}
    for name in others:
        group, column = _split(name)
        if group and column:
            groups.setdefault(group, []).append(name)
    return {
        group: names
        for group, names in groups.items()
        if group not in columns
        and (len(names) > 1 or group == WEIGHTS_NAME)
        and all(_is_numeric(others[name]) for name in names)
    }


def _split(name: str) -> tuple[str, str]:
    """Return the name of an attribute and of its column; those of joints may have dots."""
    if name.startswith(f"{WEIGHTS_NAME}."):
        return WEIGHTS_NAME, name[len(WEIGHTS_NAME) + 1 :]
    group, _, column = name.rpartition(".")
    return group, column


def _table(columns: Mapping[str, Column], names: Sequence[str]) -> npt.NDArray[np.float64]:
    return np.stack([columns[name].astype(np.float64) for name in names], axis=1)


def _is_numeric(values: Column) -> bool:
    return values.dtype.kind in "if"


def to_columns(attributes: Sequence[Attribute]) -> dict[str, Column]:
    """Return the columns of attributes by names that differ; colours as bytes.

    An attribute gets another name if it, or its columns, would be read as a part of another one.
    """
    wide = {one.name: one for one in attributes if one.width}
    single = {one.name: one for one in attributes if not one.width}
    parts = {name for one in wide.values() for name in _columns_of(one)}
    groups = renamed(wide, {*single, *parts}, _group_name)
    tables = {one.name: _columns_of(replace(one, name=name)) for name, one in groups.items()}
    taken = {*groups, *(name for own in tables.values() for name in own)}
    colored = any(map(_is_colors, attributes))
    named = renamed(single, taken, lambda name: _single_name(name, groups, colored))
    tables |= {one.name: {name: one.values} for name, one in named.items()}
    return {name: values for one in attributes for name, values in tables[one.name].items()}


def _group_name(name: str) -> str:
    """Return a name of an attribute of several columns that is not read as weights.

    The case of `weights` does not count in CSV.
    """
    if name == WEIGHTS_NAME or not _is_of_weights(f"{name}."):
        return name
    return name.replace(".", "_") if "." in name else f"{name}_"


def _single_name(name: str, groups: Collection[str], colored: bool) -> str:
    """Return a name of an attribute of one column that is not read as a part of one of several."""
    if WEIGHTS_NAME in groups and _is_of_weights(name):
        name = name.replace(".", "_", 1)
    while _split(name)[0] in groups:
        name = "_".join(_split(name))
    # The case of the names of colours does not count when they are read.
    return f"{name}_" if colored and name.lower() in CHANNELS else name


def _is_of_weights(column: str) -> bool:
    return column.lower().startswith(f"{WEIGHTS_NAME}.")


def _columns_of(attribute: Attribute) -> dict[str, Column]:
    """Return the columns of an attribute of several."""
    if _is_colors(attribute):
        octets = color_bytes(attribute.values)
        return {CHANNELS[place]: octets[:, place] for place in range(attribute.width)}
    names = (f"{attribute.name}.{name}" for name in column_names(attribute))
    return {name: attribute.values[:, place] for place, name in enumerate(names)}


def _is_colors(attribute: Attribute) -> bool:
    return attribute.name == COLORS_NAME and attribute.width in (3, 4)


def column_names(attribute: Attribute) -> tuple[str, ...]:
    """Return the names of an attribute's columns: its own, x y z, or numbers from 0."""
    if attribute.columns:
        return attribute.columns
    if attribute.width == len(_AXES):
        return tuple(_AXES)
    return tuple(map(str, range(attribute.width)))


def color_bytes(colors: npt.NDArray[Any]) -> npt.NDArray[np.uint8]:
    """Colours in 0..1 as bytes; black where there is none."""
    shown = np.nan_to_num(colors, nan=0.0).clip(0.0, 1.0)
    octets: npt.NDArray[np.uint8] = np.rint(255.0 * shown).astype(np.uint8)
    return octets
