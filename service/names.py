"""Names of shapes: one line of text that can be shown anywhere."""

import re
from pathlib import PureWindowsPath
from typing import Final

LONGEST: Final = 200

_UNSHOWABLE: Final = re.compile(
    "[\x00-\x1f\x7f-\x9f\u2028\u2029\u202a-\u202e\u2066-\u2069\ud800-\udfff]"
)
"""Controls of terminals, breaks of lines, and what turns the direction of the text round it."""


def showable(name: str) -> str:
    """Return a name as it is.

    Raises
    ------
    ValueError
        It has characters that are no part of a line of text.
    """
    if _UNSHOWABLE.search(name):
        raise ValueError("Input should be one line of text, without control characters")
    return name


def base_name(path: str) -> str:
    """Return the last part of a path, of either kind of system, as far as it can be shown."""
    return PureWindowsPath(_UNSHOWABLE.sub("", path)).name
