"""Numba's compiler as decorators that keep the type of the decorated function."""

from collections.abc import Callable
from typing import TypeVar, cast

import numba

_Function = TypeVar("_Function", bound=Callable[..., object])


def kernel(function: _Function) -> _Function:
    """Compile a small pure function on arrays to machine code, once per machine.

    The compiled code is kept on disk beside the module (or in ``NUMBA_CACHE_DIR``), so only the
    first process on a machine pays for the compilation. Floating-point arithmetic stays strict
    (no ``fastmath``), so that the same input has the same result on every worker.

    Parameters
    ----------
    function
        A function that numba can compile in nopython mode.

    Returns
    -------
    function
        The compiled function, with the signature of the original.
    """
    return cast(_Function, numba.njit(cache=True, nogil=True)(function))


def inlined(function: _Function) -> _Function:
    """Compile a very small function into each compiled function that calls it.

    Meant for functions with many arguments in inner loops, where passing these would take longer
    than the computation.

    Parameters
    ----------
    function
        A function that numba can compile in nopython mode.

    Returns
    -------
    function
        The compiled function, with the signature of the original.
    """
    return cast(_Function, numba.njit(cache=True, nogil=True, inline="always")(function))
