"""The catalogue of the structures that can be chosen, and choices by their names."""

from functools import cache
from typing import Final

from broker.contracts.structure_choices import DESCRIPTORS, METRICS
from broker.contracts.structures import Choice, Structures

_KINDS: Final = METRICS | DESCRIPTORS


@cache
def catalogue() -> Structures:
    """Return all structures that can be chosen."""
    return Structures(
        metrics=tuple(kind.about for kind in METRICS.values()),
        descriptors=tuple(kind.about for kind in DESCRIPTORS.values()),
    )


def choice(given: Choice | str) -> Choice:
    """Return a structure with its parameters; for a name, those by default."""
    return _KINDS[given](name=given) if isinstance(given, str) else given


def choices(given: Choice | str | tuple[Choice | str, ...]) -> tuple[Choice, ...]:
    """Return structures with their parameters, given one for all levels or one for each."""
    return tuple(map(choice, given if isinstance(given, tuple) else (given,)))
