"""Syntax of ids: hexadecimal digits, for prototypes and attributes after a prefix."""

import re
from typing import Final

ID_DIGITS: Final = 32

_SHAPE: Final = re.compile(rf"[0-9a-f]{{{ID_DIGITS}}}")
_PROTOTYPE: Final = re.compile(f"p-{_SHAPE.pattern}")
_ATTRIBUTES: Final = re.compile(f"a-{_SHAPE.pattern}")
# Matches of a batch have its id with a number.
_BEGINNING: Final = re.compile(rf"[0-9a-f]{{1,{ID_DIGITS - 1}}}(-[0-9]+)?")

# Services of other versions may have ids of other forms; none has a dot or a slash, as files have.
_ANY: Final = re.compile(r"[0-9a-zA-Z_-]{1,64}")


def is_shape_id(given: str) -> bool:
    """Return whether a text is the id of a shape, or of a job."""
    return _SHAPE.fullmatch(given) is not None


def is_prototype_id(given: str) -> bool:
    """Return whether a text is the id of a prototype."""
    return _PROTOTYPE.fullmatch(given) is not None


def is_attributes_id(given: str) -> bool:
    """Return whether a text is the id of a file of attributes."""
    return _ATTRIBUTES.fullmatch(given) is not None


def may_be_id(given: str) -> bool:
    """Return whether a text may be an id of any kind, and part of a path."""
    return _ANY.fullmatch(given) is not None


def begins_job_id(given: str) -> bool:
    """Return whether a text may be the beginning of the id of a job, as in ``9b74c989``.

    Of a match of a batch it has the number of the match, as in ``9b74c989-1``.
    """
    return _BEGINNING.fullmatch(given) is not None
