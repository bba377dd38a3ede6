"""Structures as text, as the command line takes them."""

from contextlib import suppress
from typing import Any

from isomatch._models.arguments import StructureChoice
from isomatch._models.parameters import LISTS


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
        parameters[key] = _values(value, is_list="," in value or (name, key) in LISTS)
    return {"name": name, **parameters} if parameters else name


def _values(text: str, is_list: bool) -> Any:
    if is_list:
        return [_number(part) for part in text.split(",") if part]
    return _number(text)


def _number(text: str) -> int | float | str:
    # The service refuses other text, and says what is expected.
    for kind in (int, float):
        with suppress(ValueError):
            return kind(text)
    return text
