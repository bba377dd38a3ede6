"""Results of several shapes as text of one screen."""

from collections.abc import Iterable, Sequence
from typing import Final

MOST_LINES: Final = 20
"""Lines below the heading."""

_LONGEST: Final = 40
"""Characters of a shortened name."""


def called(shapes: Iterable[tuple[str | None, str]]) -> list[str]:
    """Return what shapes are called: their names, with the ids of those that share one.

    Parameters
    ----------
    shapes
        Name and id of each; one without a name is called by its id. Ids are never shortened, since
        the service takes whole ones only.
    """
    given = [(None if name is None else _short(name), shape) for name, shape in shapes]
    owners: dict[str | None, set[str]] = {}
    for name, shape in given:
        owners.setdefault(name, set()).add(shape)
    return [
        shape if name is None else name if len(owners[name]) == 1 else f"{name} ({shape})"
        for name, shape in given
    ]


def _short(name: str) -> str:
    return name if len(name) <= _LONGEST else f"{name[: _LONGEST - 1]}…"


def screen(heading: str, lines: Sequence[str]) -> str:
    """Return a heading and the lines below it, with the number of those that are left out."""
    shown = [f"  {line}" for line in lines[:MOST_LINES]]
    left = len(lines) - len(shown)
    return "\n".join([heading, *shown, *([f"  and {left} more"] if left else [])])


def change(before: float, after: float) -> str:
    """Return a measure before and after, once if it is the same."""
    return f"{after:.3g}" if before == after else f"{before:.3g} -> {after:.3g}"
