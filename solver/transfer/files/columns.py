"""Attributes as single columns of numbers or text, for formats of tables: CSV and PLY.

A column of an attribute of several is called ``NAME.COLUMN``, as in ``flow.x`` or
``weights.LeftArm``; those of colours ``red``, ``green``, ``blue`` and ``alpha``.
"""

from collections.abc import Callable, Collection, Mapping, Sequence
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from solver.transfer.attributes import COLORS_NAME, Attribute
from solver.transfer.files.limits import colors_in_range

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
    groups: dict[str, list[str]] = {}
    colored = all(channel in columns for channel in CHANNELS[:3])
    for name in columns:
        group = COLORS_NAME if colored and name in CHANNELS else name.partition(".")[0] or name
        groups.setdefault(group, []).append(name)
    found = []
    for group, names in groups.items():
        numeric = all(columns[name].dtype.kind in "if" for name in names)
        if names == [group] or not numeric:
            found += [Attribute(name, columns[name]) for name in names]
        elif group == COLORS_NAME and colored:
            channels = [name for name in CHANNELS if name in names]
            table = np.stack([columns[name] for name in channels], axis=1)
            found.append(Attribute(group, colors_in_range(table), tuple(channels)))
        else:
            table = np.stack([columns[name].astype(np.float64) for name in names], axis=1)
            parts = tuple(name.partition(".")[2] or name for name in names)
            found.append(Attribute(group, table, parts))
    return found


def to_columns(attributes: Sequence[Attribute]) -> dict[str, Column]:
    """Return the columns of attributes; colours as bytes."""
    columns: dict[str, Column] = {}
    for one in attributes:
        if one.name == COLORS_NAME and one.width in (3, 4):
            octets = color_bytes(one.values)
            columns |= {CHANNELS[place]: octets[:, place] for place in range(one.width)}
        elif one.width:
            names = column_names(one)
            columns |= {f"{one.name}.{name}": one.values[:, i] for i, name in enumerate(names)}
        else:
            columns[one.name] = one.values
    return columns


def renamed(
    columns: Mapping[str, Column],
    taken: Collection[str],
    spelling: Callable[[str], str] = str,
) -> dict[str, Column]:
    """Return columns whose names differ from those that are taken: an underscore is appended.

    Parameters
    ----------
    columns
        By name.
    taken
        Names that a format has for its own.
    spelling
        Returns a name as the format can write it; several names may become one.
    """
    found: dict[str, Column] = {}
    for name, values in columns.items():
        own = spelling(name)
        while own in taken or own in found or (own != name and own in columns):
            own += "_"
        found[own] = values
    return found


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
