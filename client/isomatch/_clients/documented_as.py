"""Docstrings that the blocking and the asynchronous classes share."""

from collections.abc import Callable
from typing import Any, TypeVar

MethodT = TypeVar("MethodT", bound=Callable[..., Any])


def documented_as(blocking: Callable[..., Any]) -> Callable[[MethodT], MethodT]:
    """Decorator: give an asynchronous method the docstring of its blocking counterpart."""

    def document(method: MethodT) -> MethodT:
        method.__doc__ = blocking.__doc__
        return method

    return document
