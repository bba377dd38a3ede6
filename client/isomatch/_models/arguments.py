"""Arguments as users give them: names that are checked, and structures."""

from collections.abc import Mapping
from typing import Any, TypeAlias

StructureChoice: TypeAlias = str | dict[str, Any]
"""A metric or a descriptor: its name, or that as ``"name"`` and its parameters."""


def check_names(
    given: Mapping[str, object], known: Mapping[str, object], method: str = "match"
) -> None:
    """Refuse misspelt parameters before anything is sent, as Python refuses misspelt arguments.

    Parameters
    ----------
    given
        The parameters.
    known
        The known parameters, such as ``MatchParameters.__annotations__``.
    method
        The method that takes them.

    Raises
    ------
    TypeError
        A name is not a parameter.
    """
    unknown = sorted(set(given) - set(known))
    if unknown:
        raise TypeError(
            f"{method}() got unexpected parameter {', '.join(map(repr, unknown))}; "
            f"it takes {', '.join(sorted(known))}"
        )
