"""Limits of requests, as the arguments of clients give them."""

import math
import operator
from numbers import Real


def timeout_given(given: float | None) -> float | None:
    """Return the seconds without progress after which a request fails; None for no limit.

    Raises
    ------
    TypeError
        It is no number.
    ValueError
        It is not over 0.
    """
    if given is None:
        return None
    if not isinstance(given, Real):
        raise TypeError(f"timeout must be a number of seconds or None, not {given!r}")
    if not 0.0 < given < math.inf:
        raise ValueError(f"timeout must be over 0 and finite, not {given!r}; None is no limit")
    return float(given)


def wait_given(given: float | None) -> float | None:
    """Return the seconds to wait for a job or an upload; None for no limit.

    Raises
    ------
    TypeError
        It is no number.
    ValueError
        It is negative or nan.
    """
    if given is None:
        return None
    if not isinstance(given, Real):
        raise TypeError(f"timeout must be a number of seconds or None, not {given!r}")
    if not given >= 0.0:
        raise ValueError(f"timeout must be 0 or more, not {given!r}; None is no limit")
    return float(given)


def retries_given(given: int) -> int:
    """Return the greatest number of repetitions of a request.

    Raises
    ------
    TypeError
        It is no whole number.
    ValueError
        It is negative.
    """
    try:
        retries = operator.index(given)
    except TypeError as error:
        raise TypeError(f"retries must be a whole number, not {given!r}") from error
    if retries < 0:
        raise ValueError(f"retries must be 0 or more, not {retries}")
    return retries
