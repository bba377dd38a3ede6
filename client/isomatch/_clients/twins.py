"""The sync and the async client say the same of themselves: it is written once."""

from collections.abc import Callable
from typing import Any, TypeVar

MethodT = TypeVar("MethodT", bound=Callable[..., Any])


def documented_as(twin: Callable[..., Any]) -> Callable[[MethodT], MethodT]:
    """Give a method the docstring of its twin, which does the same and blocks."""

    def document(method: MethodT) -> MethodT:
        method.__doc__ = twin.__doc__
        return method

    return document
