"""Names that differ, for what a format tells apart by name."""

from collections.abc import Iterable


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
