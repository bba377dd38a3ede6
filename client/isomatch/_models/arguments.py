"""Arguments as users give them: names that are checked, and structures as text."""

from collections.abc import Mapping
from contextlib import suppress
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


def structure_choice(text: str) -> StructureChoice:
    """Return the structure that a text names, as in ``hks:times=0.1,1``.

    Parameters
    ----------
    text
        A name and, after colons, parameters; several values of one are separated by commas.

    Raises
    ------
    ValueError
        A parameter has no value.
    """
    name, *given = text.split(":")
    parameters: dict[str, Any] = {}
    for one in given:
        key, separator, value = one.partition("=")
        if not (key and separator and value):
            raise ValueError(f"{one!r} in {text!r} is not of the form parameter=value")
        parameters[key] = _values(value)
    return {"name": name, **parameters} if parameters else name


def _values(text: str) -> Any:
    if "," in text:
        return [_number(part) for part in text.split(",") if part]
    return _number(text)


def _number(text: str) -> int | float | str:
    # The service refuses other text, and says what is expected.
    for kind in (int, float):
        with suppress(ValueError):
            return kind(text)
    return text
