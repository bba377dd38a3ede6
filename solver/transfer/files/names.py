"""Names that differ, for what a format tells apart by name."""

from collections.abc import Callable, Collection, Iterable, Mapping
from typing import TypeVar

T = TypeVar("T")


def distinct(names: Iterable[str]) -> tuple[str, ...]:
    """Return names of which each occurs once: those that recur get their place as a suffix.

    Examples
    --------
    >>> distinct(["arm", "hand", "arm"])
    ('arm', 'hand', 'arm_2')
    """
    found: dict[str, None] = {}
    for name in names:
        own = f"{name}_{len(found)}" if name in found else name
        while own in found:
            own += "_"
        found[own] = None
    return tuple(found)


def renamed(
    columns: Mapping[str, T],
    taken: Collection[str],
    spelling: Callable[[str], str] = str,
) -> dict[str, T]:
    """Return columns by names that differ from those that are taken: an underscore is appended.

    Parameters
    ----------
    columns
        By name, or something else that has names.
    taken
        Names that a format has for its own.
    spelling
        Returns a name as the format can write it; several names may become one.
    """
    found: dict[str, T] = {}
    for name, values in columns.items():
        own = spelling(name)
        while own in taken or own in found or (own != name and own in columns):
            own += "_"
        found[own] = values
    return found
