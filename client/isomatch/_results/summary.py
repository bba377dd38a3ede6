"""Results of several shapes as text of one screen."""

from collections.abc import Sequence
from typing import Final

MOST_LINES: Final = 20
"""Lines below the heading."""

_LONGEST: Final = 40
"""Characters of a shortened name."""

_ID: Final = 8
"""Characters of a shortened id."""


def called(name: str | None, shape: str) -> str:
    """Return the name of a shape beside the start of its id, as in ``a.off (9b74c989)``."""
    if name is None:
        return shape[:_ID]
    short = name if len(name) <= _LONGEST else f"{name[: _LONGEST - 1]}…"
    return f"{short} ({shape[:_ID]})"


def screen(heading: str, lines: Sequence[str]) -> str:
    """Return a heading and the lines below it, with the number of those that are left out."""
    shown = [f"  {line}" for line in lines[:MOST_LINES]]
    left = len(lines) - len(shown)
    return "\n".join([heading, *shown, *([f"  and {left} more"] if left else [])])


def change(before: float, after: float) -> str:
    """Return a measure before and after, once if it is the same."""
    return f"{after:.3g}" if before == after else f"{before:.3g} -> {after:.3g}"
