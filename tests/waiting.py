"""Waiting until a condition holds."""

import time
from collections.abc import Callable
from typing import TypeVar

T = TypeVar("T")

PATIENCE = 240.0
"""Seconds, far beyond what a slow machine takes."""


def until(found: Callable[[], T | None], seconds: float = PATIENCE, pause: float = 0.02) -> T:
    """Ask again and again, and return the first answer that is true.

    Parameters
    ----------
    found
        What is asked for.
    seconds
        Limit of the time.
    pause
        Seconds between questions.
    """
    deadline = time.monotonic() + seconds
    while not (answer := found()):
        assert time.monotonic() < deadline, f"{answer} after {seconds:g} seconds"
        time.sleep(pause)
    return answer
