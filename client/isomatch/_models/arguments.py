"""Arguments as users give them: names that are checked, choices, landmarks and structures."""

from collections.abc import Mapping, Sequence
from typing import Annotated, Any, Final, TypeAlias

import numpy as np
import numpy.typing as npt
from pydantic import GetPydanticSchema

READ_AS_TEXT: Final = GetPydanticSchema(lambda _, handler: handler(str))
"""Of a choice: answers of services of other versions may have others."""

LandmarkPairs: TypeAlias = Annotated[
    Sequence[Sequence[int]] | npt.NDArray[np.integer[Any]],
    GetPydanticSchema(lambda _, handler: handler(list[tuple[int, int]])),
]
"""Pairs of vertices, or an integer array (n, 2); of results a list of tuples."""

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
